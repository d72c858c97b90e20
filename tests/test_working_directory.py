"""Nothing that lies in the working directory runs, as in an unpacked archive: also not in processes that are started."""

import re
import subprocess
import sys
from importlib.metadata import packages_distributions
from pathlib import Path

import foreign
import forked
import pytest
from builders import small_study, write_study

ROOT = Path(__file__).parents[1]
SOURCES = [path for room in ("src", "robot/src") for path in (ROOT / room).rglob("*.py")]

NAMES = sorted(
    name for name in {*sys.stdlib_module_names, *packages_distributions(), "canary_of_spawn"} if name.isidentifier()
)
"""Every module that somebody may expect to be another one."""

AS_TYPED = """
import sys
del sys.path[0]  # as with the command
import lockprobe.cli.live_report
import lockprobe.studies.running.runner
lockprobe.cli.live_report.PAUSE = 0  # a report during a run is due at once
lockprobe.studies.running.runner._ALONE = 1e-3
from lockprobe.cli import main
main()
"""

STARTING = {
    "processes for strategies": (
        *("run", "flips", "--agent", "random", "--p", "0,0.4", "--trials", "20", "--no-report", "--workers", "2"),
        *("--out", "st2"),
    ),
    "a report during the run, worker processes, a probe of the pictures": (
        *("run", "modalities", "--agent", "viewer", "--modality", "rgb", "--plant", "fast-twin?width=64&height=64"),
        *("--p", "0,0.4", "--trials", "2", "--max-steps", "1", "--workers", "2", "--out", "seen"),
    ),
    "processes for populations": ("power", "--p", "0,0.4", "--success", "0.3,0.6", "--studies", "20", "--workers", "2"),
    "a probe of the pictures": ("doctor",),
}  # fmt: skip
"""What starts processes -> a command that does."""


@pytest.fixture
def archive(tmp_path):
    """A directory with a study and a file of every name, each of which leaves a trace if it is imported."""
    write_study(tmp_path / "st", small_study())
    for name in NAMES:
        (tmp_path / f"{name}.py").write_text(f"open({str(tmp_path / foreign.SUNG)!r}, 'a').write('{name} ')\n", "utf-8")
    return tmp_path


def sung(archive):
    trace = archive / foreign.SUNG
    return trace.read_text() if trace.exists() else ""


@pytest.mark.parametrize("what", STARTING)
def test_no_process_that_a_command_starts_runs_what_lies_there(archive, what):
    done = forked.run(STARTING[what], script=AS_TYPED, cwd=archive)
    assert sung(archive) == ""
    assert "Traceback" not in done.stderr
    assert done.returncode in (0, 1), done.stderr


def test_the_command_as_it_is_installed_runs_nothing_of_it(archive):
    done = subprocess.run([Path(sys.executable).with_name("lockprobe"), "status", "st"], cwd=archive, text=True)
    assert (done.returncode, sung(archive)) == (0, "")


def test_the_files_would_run_where_python_looks_into_the_working_directory(archive):
    subprocess.run([sys.executable, "-c", "import canary_of_spawn"], cwd=archive, capture_output=True)
    assert "canary_of_spawn" in sung(archive)


def test_what_a_person_names_still_runs_and_takes_nothing_else_along(archive):
    (archive / "mine.py").write_text(
        "import random, statistics\n"
        "from lockprobe import Decision\n"
        "class First:\n"
        "    facts = {}\n    async def decide(self, situation, rng):\n"
        "        return Decision(joint=situation.task.joints[0])\n"
    )
    line = ("run", "flips", "--agent", "python:mine:First", "--p", "0", "--trials", "1", "--repetitions", "1")
    done = forked.run((*line, "--no-report"), cwd=archive)
    assert (done.returncode, sung(archive)) == (0, ""), done.stderr


def test_every_place_that_starts_an_interpreter_does_so_safely():
    starts = re.compile(r"\.Popen\(|subprocess\.(run|check_)|get_context\(|sys\.executable")
    safe = re.compile(r"with .*(safe_path|held_back)\(\)")
    found = {path.name: bool(safe.search(text)) for path in SOURCES if starts.search(text := path.read_text("utf-8"))}
    assert {"live_report.py", "processes.py"} <= found.keys()
    assert [name for name, is_safe in found.items() if not is_safe and name != "safe_path.py"] == []
