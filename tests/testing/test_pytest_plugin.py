"""pytest finds the fixtures by itself, and pays for them where they are used."""

import subprocess
import sys

USES = """
from lockprobe.interventions.drop import Drop

def test_all(check_agent, check_box, check_intervention, check_measure, check_plant, make_trial, play_trials, scripted_agent, scripted_provider):
    check_intervention(Drop(p=0.5))
    check_agent(scripted_agent(0, 1), boxes=["chain-4"])
    check_plant("symbolic", boxes=["chain-4"])
    check_box("chain-4")
    check_measure("solved")
    assert make_trial([3, 2, 1, 0]).solved
    assert len(play_trials("random", 2)) == 2
    assert scripted_provider(["yes"]).url.startswith("http://127.0.0.1:")
"""

UNUSED = """
import sys

def test_nothing_is_imported():
    assert "lockprobe.testing.pytest_plugin" in sys.modules
    assert not {"numpy", "pydantic", "lockprobe.testing.trials", "lockprobe.trial.record"} & sys.modules.keys()
"""


def run(directory, text):
    (directory / "pytest.ini").write_text("[pytest]\n", "utf-8")
    (directory / "test_it.py").write_text(text, "utf-8")
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-W", "error"]
    return subprocess.run(command, cwd=directory, capture_output=True, text=True, timeout=120)


def test_the_fixtures_are_there(tmp_path):
    done = run(tmp_path, USES)
    assert done.returncode == 0, done.stdout + done.stderr


def test_whoever_uses_none_imports_nothing(tmp_path):
    done = run(tmp_path, UNUSED)
    assert done.returncode == 0, done.stdout + done.stderr
