"""What a directory or a file says is data, and what lies in the working directory stays there: no command runs either.

Every command of the command line has a row here, so that a new one has to say which of its arguments come from elsewhere.
Directories and files name code in every place that can name code. The code is a canary: a module of the working directory
that leaves a file when it is imported, and a shell command that leaves one when it is called.
"""

import json
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import cache
from importlib.metadata import packages_distributions
from pathlib import Path
from tempfile import TemporaryDirectory

import forked
import pytest
import strangers
import typer
from builders import play_study, write_study
from stored import rewrite
from typed import typed_here

from lockprobe.boxes.families import box
from lockprobe.cli import build, every_command
from lockprobe.foundation import plugins
from lockprobe.interventions.conditions import flips
from lockprobe.interventions.told import Drop
from lockprobe.studies.study import Study
from lockprobe.trial.condition import Condition, Recorded
from lockprobe.trial.trial_json import trial_to_json

pytestmark = pytest.mark.usefixtures("placeholders")

ROOT = Path(__file__).parents[1]
SOURCES = [path for room in ("src", "robot/src") for path in (ROOT / room).rglob("*.py")]

MODULE = "canary"

SUNG = "it-ran"
"""The file that any code of the canary leaves in the working directory."""

CALL = f"python:os:system?command=touch%20{SUNG}"

AGENTS = (CALL, f"python:{MODULE}:First?place=1")
PLANT = f"python:{MODULE}:Plain"
ACTING = f"python:{MODULE}:Hush?steps=1"

KINDS = ("agents", "plant", "condition")
"""What of a directory names code."""


def _directory(path: Path, kind: str) -> Path:
    """The directory of a study that names code. Each agent owes its last trial."""
    return Path(shutil.copytree(_made(kind).name, path, dirs_exist_ok=True))


@cache
def _made(kind: str) -> TemporaryDirectory[str]:
    made = TemporaryDirectory()
    path = Path(made.name)
    played = Study(name="flips", agents=("random",), boxes=(box("chain-4"),), conditions=flips((0.0, 0.4)), trials=2)
    if kind == "condition":
        played = replace(played, conditions=(Condition(), Condition(interventions=(Drop(p=0.5),), name="x")))
    trials = play_study(played)[:-1]
    named = played
    if kind == "condition":
        named = replace(played, conditions=(Condition(), Condition(interventions=(Recorded(spec=ACTING),), name="x")))
        trials = [replace(trial, specs=named.labelled(trial.condition).specs) for trial in trials]
    if kind == "plant":
        named = replace(played, plant=PLANT)
        trials = [replace(trial, plant={"plant": PLANT}) for trial in trials]
    if kind == "agents":
        named = replace(played, agents=AGENTS)
        trials = [
            replace(trial, agent=agent, key=str(replace(trial.name, agent=agent)))
            for agent in AGENTS
            for trial in trials
        ]
    write_study(path, replace(played, agents=("random",)), [])
    (path / "study.json").write_text(json.dumps(named.settings()))
    identities = [named.record_identity(named.labelled(trial.condition)) for trial in trials]
    rewrite(path, [json.loads(trial_to_json(trial)) for trial in trials], identities)
    return made


def study_files(here: Path) -> Sequence[Path]:
    """Study files that name code in every setting that can."""
    lines = (
        f'agent = ["random", "{CALL}"]',
        f'plant = "{PLANT}"',
        f'box = "python:{MODULE}:gate?size=5"',
        f'condition = "tremble?p=0.1 + {ACTING}"',
        f'sweep = "python:{MODULE}:Hush?steps=0,1"',
        f'[[condition]]\nname = "x"\nspec = "{ACTING}"',
    )
    made = [here / f"foreign-{i}.toml" for i in range(len(lines))]
    for file, line in zip(made, lines, strict=True):
        file.write_text(f"{line}\n", "utf-8")
    return made


NOTHING_FOREIGN = {
    "chance", "power", "play", "list agents", "list plants", "list interventions", "list models", "doctor",
    "box list", "box generate", "rig calibrate", "rig check",
}  # fmt: skip
"""Commands that take no directory of a study, no study file and no records."""

KEY = "flips/random/flip?p=0.4/rep=1/trial=1"

TAKING: dict[str, list[list[str]]] = {
    "run": [
        ["run", "flips", "--p", "0,0.4", "--trials", "2", "--out", "DIR"],
        ["run", "flips", "--p", "0,0.4", "--trials", "2", "--out", "DIR", "--estimate"],
        ["run", "flips", "--condition", "drop?p=0.5", "--trials", "2", "--out", "DIR"],
        ["run", "FILE"],
    ],
    "status": [["status", "DIR"]],
    "report": [["report", "DIR"], ["report", "DIR", "OTHER"]],
    "verify": [["verify", "DIR"]],
    "export": [["export", "DIR"], ["export", "DIR", "--table", "records", "--format", "jsonl"]],
    "import": [
        ["import", "mine", "DIR"],
        ["run", "flips", "--p", "0,0.4", "--trials", "2", "--out", "mine"],
        ["verify", "mine"],
        ["branch", "--at", "2", "mine"],
    ],
    "replay": [["replay", "DIR", KEY]],
    "branch": [["branch", "DIR", "--at", "2"], ["branch", "DIR", KEY, "--at", "2", "--allow", "python:canary:Other"]],
    "serve": [["serve", "DIR", "--port", "0"], ["serve", "FILE", "--port", "0"]],
    "withdraw": [["withdraw", "DIR", "aaaa01"]],
    "mcp": [["mcp", "flips", "--p", "0,0.4", "--trials", "2", "--out", "DIR"], ["mcp", "FILE"]],
    "loops": [["loops", "DIR/study.db"]],
    "list measures": [["list", "measures", "DIR"]],
    "box show": [["box", "show", "FILE"]],
    "box check": [["box", "check", "FILE"]],
}
"""Command -> command lines, with DIR and OTHER for directories and FILE for a study file."""


def leaves(command: object, above: tuple[str, ...] = ()) -> Iterator[str]:
    for name, one in getattr(command, "commands", {"": None}).items():
        yield from leaves(one, (*above, name)) if one is not None else [" ".join(above)]


def test_every_command_has_its_row():
    every = set(leaves(typer.main.get_command(build(every_command()))))
    assert every == NOTHING_FOREIGN | TAKING.keys(), "say what a new command takes from elsewhere"
    assert not NOTHING_FOREIGN & TAKING.keys()


@pytest.fixture
def here(tmp_path, monkeypatch):
    """The working directory, with the canary. What commands of another test named may not run in this one."""
    text = f"import pathlib\npathlib.Path({str(tmp_path / SUNG)!r}).touch()\n{strangers.WORKING}"
    (tmp_path / f"{MODULE}.py").write_text(text, "utf-8")
    monkeypatch.setattr(plugins, "_named", set())
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", list(sys.path))
    yield tmp_path
    sys.modules.pop(MODULE, None)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("command", TAKING)
def test_no_command_runs_what_a_directory_or_a_file_names(here, command, kind):
    for number, line in enumerate(TAKING[command]):
        if line[-1] == "mine" and not (here / "mine").exists():  # it could not be imported
            continue
        files = study_files(here) if "FILE" in line else [here]
        for file in files if kind == "agents" or len(files) == 1 else []:
            given = [one.replace("FILE", str(file)) for one in line]
            for name in ("DIR", "OTHER"):
                if any(name in one for one in line):
                    there = str(_directory(here / f"{name}-{number}", kind))
                    given = [one.replace(name, there) for one in given]
            done = typed_here(*given)
            assert not (here / SUNG).exists(), f"{' '.join(given)} ran it: {done.stdout}{done.stderr}"
            assert "Traceback" not in done.stderr
            assert MODULE not in sys.modules
            assert str(here) not in sys.path
            assert done.returncode != 2 or done.stderr.splitlines()[-1].startswith("lockprobe: "), done.stderr


def test_the_same_name_runs_when_it_is_named_in_the_command(here):
    """So that the canary is one: it sings where a person names it, and forks need the name."""
    spec = AGENTS[1]
    branch = ("branch", _directory(here / "there", "agents"), f"flips/{spec}/flip?p=0.4", "--at", "2")
    done = typed_here(*branch)
    said = f"lockprobe: agent: got '{spec}', expected --allow with it in this command (in Python: "
    assert (done.returncode, done.stderr.startswith(said)) == (2, True)
    done = typed_here(*branch, "--allow", spec)
    assert done.returncode == 1, done.stderr  # it plays, and not as the strategy did whose records these are
    assert (here / SUNG).exists()


@pytest.mark.usefixtures("here")
@pytest.mark.parametrize(("kind", "named"), [("agent", AGENTS[1]), ("plant", PLANT), ("condition", ACTING)])
def test_one_s_own_study_is_resumed_by_the_command_that_began_it(kind, named):
    rest = () if kind == "agent" else ("--agent", "random")
    short = ("--trials", "1", "--repetitions", "1", "--workers", "1", "--no-report", "--out", "mine")
    for _ in range(2):
        assert typed_here("run", "flips", f"--{kind}", named, *rest, *short).returncode == 0
    assert typed_here("verify", "mine").returncode == 0


def test_verify_runs_nothing_of_an_installed_package(here, monkeypatch):
    (here / "installed").mkdir()
    strangers.install(here / "installed", monkeypatch, text=(here / f"{MODULE}.py").read_text("utf-8"))
    line = ["run", "flips", "--agent", "first", "--condition", "hush", "--trials", "2", "--repetitions", "1"]
    assert typed_here(*line, "--workers", "1", "--plant", "plain", "--out", "mine").returncode == 0
    assert '"measures.untold"' in (here / "mine" / "results.json").read_text("utf-8")
    (here / SUNG).unlink()
    monkeypatch.delitem(sys.modules, "strange")
    done = typed_here("verify", "mine")
    assert done.returncode == 0, done.stdout
    assert "of its rows are not checked: they come from strange-things 0.3" in done.stdout
    assert "; 4 more need a plant or an intervention that does not ship, or a real box, and are not" in done.stdout
    assert not (here / SUNG).exists()


AS_TYPED = """
import sys
del sys.path[0]  # as with the command
import lockprobe.studies.running.executor
lockprobe.studies.running.executor._ALONE = 1e-3
from lockprobe.cli import main
main()
"""


def test_no_process_that_a_command_starts_runs_what_lies_there_but_what_a_person_names(tmp_path):
    """The working directory has a file of every name, each of which leaves a trace if it is imported."""
    sung, names = tmp_path / SUNG, {*sys.stdlib_module_names, *packages_distributions(), "canary_of_spawn"}
    for name in filter(str.isidentifier, names):
        (tmp_path / f"{name}.py").write_text(f"open({str(sung)!r}, 'a').write('{name} ')\n", "utf-8")
    (tmp_path / "mine.py").write_text(
        "import random, statistics\nfrom lockprobe import Decision\nclass First:\n    facts = {}\n"
        "    async def decide(self, situation, rng):\n        return Decision(joint=situation.task.joints[0])\n"
    )
    line = ("run", "flips", "--agent", "python:mine:First", "--p", "0", "--trials", "9", "--repetitions", "1")
    done = forked.run((*line, "--workers", "2", "--no-report", "--out", "st2"), script=AS_TYPED, cwd=tmp_path)
    assert (done.returncode, sung.exists(), "Traceback" in done.stderr) == (0, False, False), done.stderr
    subprocess.run([sys.executable, "-c", "import canary_of_spawn"], cwd=tmp_path, capture_output=True)
    assert sung.exists()  # where Python looks into the working directory they do run


def test_every_place_that_starts_an_interpreter_does_so_safely():
    starts = re.compile(r"\.Popen\(|subprocess\.(run|check_)|get_context\(|sys\.executable")
    safe = re.compile(r"with .*(safe_path|held_back)\(\)")
    found = {path.name: bool(safe.search(text)) for path in SOURCES if starts.search(text := path.read_text("utf-8"))}
    assert {"processes.py"} <= found.keys()
    assert [name for name, is_safe in found.items() if not is_safe and name != "child_processes.py"] == []
