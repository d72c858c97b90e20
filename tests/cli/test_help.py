"""What a newcomer types first: help, the version, a name that is nearly right."""

import re
import subprocess
import sys
from pathlib import Path

import pytest
from builders import SOLUTION, make_trial, small_study, write_study
from typer.testing import CliRunner

from lockprobe import __version__
from lockprobe.cli import COMMANDS, build
from lockprobe.studies.options.presets import preset

AS_PAPER = Path(__file__).parents[2] / "docs" / "as-paper.md"


def test_the_version(lockprobe):
    assert lockprobe("--version") == (0, f"lockprobe {__version__}\n", "")


def test_h_is_help_everywhere(lockprobe):
    for command in ((), ("chance",), ("box",), ("box", "list")):
        short, long = lockprobe(*command, "-h"), lockprobe(*command, "--help")
        assert short == long
        assert short[0] == 0
        assert "Usage: " in short[1]


def test_help_and_the_page_on_the_paper_say_the_numbers_of_the_short_study(lockprobe):
    said, full = " ".join(lockprobe("run", "--help")[1].split()), preset("flips")
    short = full.when["short"]
    assert f"(in each repetition: {short.trials}; {full.trials} with --full" in said
    assert f"inverted ({','.join(f'{p:g}' for p in short.p)}; 0 to {full.p[-1]} by {full.p[1]} with --full" in said
    (row,) = re.findall(r"^\| trials, flips \| (.*?) \|", AS_PAPER.read_text("utf-8"), re.MULTILINE)
    assert row == (f"{full.repetitions} repetitions of {short.trials} trials at {len(short.p)} rates, "
                   f"{short.strategy_trials} of strategies")  # fmt: skip


def test_people_are_offered_no_stop_when_it_is_decided(lockprobe):
    assert "--until" in lockprobe("mcp", "--help")[1]
    assert "--until" not in lockprobe("serve", "--help")[1]


def test_help_and_the_page_say_what_a_study_that_stops_by_itself_assumes(lockprobe):
    page = (AS_PAPER.parent / "statistics.md").read_text("utf-8").replace("**", "")
    for text in (lockprobe("run", "--help")[1], page):
        assert "assumes an effect that does not drift" in " ".join(text.split())


def test_no_help_shows_what_is_for_programmers(lockprobe):
    for command in COMMANDS:
        status, said, _ = lockprobe(command, "--help")
        assert status == 0
        assert not re.search(r"^ *(Args|Returns|Raises):|``", said, re.MULTILINE), command


def test_the_shell_completes(monkeypatch):
    app = build(["status", "serve", "export"])
    done = CliRunner().invoke(app, [], prog_name="lockprobe", env={
        "_LOCKPROBE_COMPLETE": "complete_bash", "COMP_WORDS": "lockprobe s", "COMP_CWORD": "1"})  # fmt: skip
    assert done.output.split() == ["status", "serve"]


@pytest.mark.parametrize(
    ("arguments", "meant"),
    [
        (["flips"], "lockprobe run flips"),
        (["flip"], "lockprobe run flips"),
        (["modalities"], "lockprobe run modalities"),
        (["mine.toml"], "lockprobe run mine.toml"),
        (["statsu"], "status"),
        (["run", "flips", "--agent", "openai/gpt-4o"], "llm:openai/gpt-4o"),
        (["run", "flips", "--agent", "perseverant"], "cognitive:perseverant"),
        (["run", "flips", "--agent", "perseverent?decay=0.5"], "cognitive:perseverant?decay=0.5"),
        (["run", "flips", "--agent", "target-last"], "human-inspired:target-last"),
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


WITHOUT_DEFAULT = {
    "--out", "--json", "--help", "--budget", "--estimate", "--agent", "--models", "--record", "--sequences",
}  # fmt: skip
"""Options that are off, or ask for everything, where they are left out."""


@pytest.mark.parametrize("name", ["run", "chance", "power", "play"])
def test_help_says_the_default_of_every_option_that_takes_a_value(name):
    said = CliRunner().invoke(build([name]), [name, "--help"]).output.partition("Options:")[2]
    rows = [" ".join(row.split()) for row in re.split(r"\n  (?=-)", said)[1:]]
    assert rows
    for row in rows:
        option = re.search(r"--[\w-]+", row)[0]
        takes_a_value = re.match(r"\S+ (<|[A-Z]+(\||\b))", row)
        if takes_a_value and option not in WITHOUT_DEFAULT:
            assert "[default: " in row or re.search(r"\(.+\)|left out", row), row


def _imported(*command_lines):
    """Which modules commands have imported when they end, one after the other in a new process."""
    code = (
        "import sys; from lockprobe.cli import main\n"
        f"for line in {command_lines}:\n"
        "    sys.argv = ['lockprobe', *line.split()]\n"
        "    try: main()\n"
        "    except SystemExit: pass\n"
        "sys.stderr.write('\\n' + ' '.join(sys.modules))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return {name.removeprefix("lockprobe.") for name in done.stderr.splitlines()[-1].split()}


REPORT = {"report.results", "scipy", "matplotlib", "jinja2", "httpx2", "mujoco", "starlette", "uvicorn"}
"""What takes up to two seconds of processor."""


@pytest.mark.parametrize(
    ("lines", "not_imported"),
    [
        (["--help"], {"numpy", "pydantic", "trial.record", "httpx2", "xllamacpp"}),
        (["box show", "box list"], {"scipy", "trial.record", "boxes.boxfile"}),
        (
            [
                "loops --help", "run --help", "run flisp", "run flips --tirals 3", "run flips --trials many", "run tests",
                "run flips --agent humn",
            ],
            REPORT | {"numpy", "rich", "asyncio"},
        ),
        (["list agents"], REPORT | {"numpy", "asyncio"}),
    ],
    ids=["help", "boxes", "typing mistakes", "list"],
)  # fmt: skip
def test_what_is_quick_imports_nothing_heavy(lines, not_imported):
    assert not not_imported & _imported(*lines)


def test_help_an_estimate_and_a_status_import_no_report_and_help_no_provider(tmp_path):
    """The library of prices brings a client along."""
    agent = "llm:openai/gpt-4o"
    write_study(tmp_path / "s", small_study([agent]), [make_trial(SOLUTION, agent=agent)])
    helped = [f"{command} --help" for command in COMMANDS]
    assert not REPORT & _imported(*helped, "run flips --condition fip?p=0.4")
    priced = f"run flips --estimate --agent {agent}", f"status {tmp_path / 's'}"
    assert REPORT & _imported(*priced) <= {"httpx2"}
