"""Help, options and names: what a newcomer types first, each option explained once, and a name that is nearly right."""

import re
import subprocess
import sys
from collections import defaultdict
from pathlib import Path

import pytest
import typer
from builders import SOLUTION, make_trial, small_study, write_study
from typer.testing import CliRunner

from lockprobe import __version__
from lockprobe.cli import COMMANDS, build, every_command
from lockprobe.cli.options import AS_RUN, Command
from lockprobe.studies.options.studyfile import preset

AS_PAPER = Path(__file__).parents[2] / "docs" / "as-paper.md"

MOST = 120
"""So many options a person can look through."""

WITH_STUDY_OPTIONS = ("run", "serve", "mcp", "power", "play", "branch")


def declared(command, path=""):
    """The options of a command and of its parts: path, option, whether help refers to ``lockprobe run`` for it."""
    groups = command.by_heading(typer.Context(command)) if isinstance(command, Command) else {"Options": command.params}
    for heading, options in groups.items():
        for option in options:
            if option.param_type_name == "option" and option.name != "help":
                yield path, option, heading == AS_RUN
    for name, part in getattr(command, "commands", {}).items():
        yield from declared(part, f"{path} {name}".strip())


@pytest.fixture(scope="module")
def everything():
    return typer.main.get_command(build(every_command()))


def test_there_are_few_options_and_each_is_explained_in_one_way(everything):
    """One counts in every command whose help explains it. Brackets at the end say what holds in a command."""
    assert sum(not as_run for _, _, as_run in declared(everything)) <= MOST
    said, spelled = defaultdict(lambda: defaultdict(list)), defaultdict(set)
    for path, option, _ in declared(everything):
        spelled[option.help].add("/".join(option.opts))
        for spelling in (*option.opts, *option.secondary_opts):
            said[spelling][re.sub(r"( \([^()]*\))?\.$", "", option.help)].append(path)
    assert {spelling: dict(texts) for spelling, texts in said.items() if len(texts) > 1} == {}
    assert {text: names for text, names in spelled.items() if len(names) > 1} == {}


def test_an_option_that_is_given_again_counts_again_or_is_refused(lockprobe):
    for words in (("run", "flips", "--seed", "1", "--seed=2"), ("box", "generate", "--seed", "1", "--seed", "1")):
        assert lockprobe(*words) == (2, "", "lockprobe: Option '--seed' is given 2 times; it can be given only once.\n")
    assert "2 times" in lockprobe("run", "flips", "--assessment", "--no-assessment")[2]
    several = ("--p", "0", "--p", "0.4", "--box", "chain-4", "--box", "fork"), ("--p", "0,0.4", "--box", "chain-4,fork")
    again, once = (lockprobe("run", "flips", "--agent", "random", "--estimate", *words) for words in several)
    assert again == once  # the settings, by their hash
    assert "Settings: " in once[2]


def test_run_shows_the_ten_options_first_that_most_people_need_in_one_screen_and_the_others_refer_to_it(lockprobe):
    short, whole = (re.split(r"\n\n(?=\S)", lockprobe("run", said)[1]) for said in ("--help", "--help-all"))
    for text in (short, whole):
        first, *headings = text[-5:]
        assert len(re.findall(r"^  --", first, re.MULTILINE)) == 11  # with --help-all
        assert [text.partition(":\n")[0] for text in headings] == [
            "The study", "Reports and conditions", "Running", "Hosted models"]  # fmt: skip
    assert "\n\n".join(short).count("\n") <= 48  # one screen
    for named, explained in zip(short[-4:], whole[-4:], strict=True):
        assert re.findall(r"--[a-z-]+", named) == re.findall(r"^  (--[a-z-]+)", explained, re.MULTILINE)
    shown = {}
    for name in WITH_STUDY_OPTIONS:
        command = typer.main.get_command(build([name])).commands[name]
        found = command.by_heading(typer.Context(command))
        listed = [option.name for options in found.values() for option in options]
        assert sorted(listed) == sorted([*(option.name for option in command.params), "help"])
        shown = shown or {option.name: option for options in found.values() for option in options}
        _, _, end = lockprobe(name, "--help")[1].partition(f"{AS_RUN}:\n")
        assert end.replace(",", " ").split() == [option.opts[0] for option in found.get(AS_RUN, ())]
        for option in found.get(AS_RUN, ()):
            facts = ("opts", "secondary_opts", "help", "multiple", "default")
            assert all(getattr(option, fact) == getattr(shown[option.name], fact) for fact in facts)


def test_help_is_everywhere_and_shows_nothing_for_programmers(lockprobe):
    assert lockprobe("--version") == (0, f"lockprobe {__version__}\n", "")
    for command in COMMANDS:
        short, long = lockprobe(command, "-h"), lockprobe(command, "--help")
        assert short == long
        assert (short[0], "Usage: " in short[1]) == (0, True)
        assert not re.search(r"^ *(Args|Returns|Raises):|``", short[1], re.MULTILINE), command


def test_help_and_the_page_on_the_paper_say_the_numbers_of_the_short_study(lockprobe):
    said, full = " ".join(lockprobe("run", "--help-all")[1].split()), preset("flips")
    short = full.when["short"]
    assert f"(in each repetition: {short.trials}; {full.trials} with --full" in said
    assert f"inverted ({','.join(f'{p:g}' for p in short.p)}; 0 to {full.p[-1]} by {full.p[1]} with --full" in said
    (row,) = re.findall(r"^\| trials, flips \| (.*?) \|", AS_PAPER.read_text("utf-8"), re.MULTILINE)
    times = f"{full.repetitions} \N{MULTIPLICATION SIGN}"
    assert (
        row == f"{times} {short.trials} trials at {len(short.p)} rates, {times} {short.strategy_trials} of strategies"
    )


def test_the_shell_completes():
    app = build(["status", "serve", "export"])
    done = CliRunner().invoke(app, [], prog_name="lockprobe", env={
        "_LOCKPROBE_COMPLETE": "complete_bash", "COMP_WORDS": "lockprobe s", "COMP_CWORD": "1"})  # fmt: skip
    assert done.output.split() == ["status", "serve"]


@pytest.mark.parametrize(
    ("arguments", "meant"),
    [
        (["flip"], "lockprobe run flips"),
        (["mine.toml"], "lockprobe run mine.toml"),
        (["statsu"], "status"),
        (["run", "flips", "--agent", "openai/gpt-4o"], "llm:openai/gpt-4o"),
        (["run", "flips", "--agent", "local"], "llm:local"),
    ],
)
def test_did_you_mean(lockprobe, arguments, meant):
    status, _, said = lockprobe(*arguments)
    assert (status, said.count("\n")) == (2, 1)
    assert re.search(r"[dD]id you mean '(.*?)'\?", said)[1] == meant


def test_ctrl_c_while_modules_are_imported_is_one_line(lockprobe, monkeypatch):
    def interrupted(name):
        raise KeyboardInterrupt

    monkeypatch.setattr("lockprobe.cli.import_module", interrupted)
    assert lockprobe("status", "x") == (130, "", "lockprobe: stopped by Ctrl-C\n")


REPORT = {"report.results", "scipy", "matplotlib", "jinja2", "httpx2", "mujoco", "starlette", "uvicorn"}
"""What takes up to two seconds of processor."""

TYPED_WRONG = ("run flisp", "run flips --tirals 3", "run flips --trials many", "run tests", "run flips --agent humn")

HELPED = [*(f"{command} --help" for command in COMMANDS), "run flips --condition fip?p=0.4"]


def test_what_is_quick_imports_nothing_heavy(tmp_path):
    """One after the other in a new process. What an estimate asks, the library of prices, brings a client along."""
    agent = "llm:openai/gpt-4o"
    write_study(tmp_path / "s", small_study([agent]), [make_trial(SOLUTION, agent=agent)])
    priced = f"run flips --estimate --agent {agent}", f"status {tmp_path / 's'}"
    for groups in (
        [(["box show", "box list"], {"scipy", "trial.record", "boxes.boxfile"})],
        [
            (["--help"], {"numpy", "pydantic", "trial.record", "httpx2", "xllamacpp"}),
            (["loops --help", "run --help", *TYPED_WRONG], REPORT | {"numpy", "rich", "asyncio"}),
            (["list agents"], REPORT | {"numpy", "asyncio"}),
            (HELPED, REPORT),
            (priced, REPORT - {"httpx2"}),
        ],
    ):
        code = (
            "import sys; from lockprobe.cli import main\n"
            f"for lines in {[lines for lines, _ in groups]}:\n"
            "    for line in lines:\n"
            "        sys.argv = ['lockprobe', *line.split()]\n"
            "        try: main()\n"
            "        except SystemExit: pass\n"
            "    sys.stderr.write('\\nloaded: ' + ' '.join(sys.modules) + '\\n')"
        )
        done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
        loaded = re.findall("^loaded: (.*)", done.stderr, re.MULTILINE)
        for (lines, heavy), names in zip(groups, loaded, strict=True):
            assert not heavy & {name.removeprefix("lockprobe.") for name in names.split()}, lines
