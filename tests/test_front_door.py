"""What ``import lockprobe`` offers and costs; docs/extending.md shows a package that is installed and tested as it is."""

import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

import lockprobe
from lockprobe.foundation.plugins import GROUPS
from lockprobe.testing import make_trial


def test_every_name_is_there_and_only_once_thought_of():
    assert list(lockprobe.__all__) == sorted(set(lockprobe.__all__))
    assert 25 <= len(lockprobe.__all__) <= 32
    for name in lockprobe.__all__:
        thing = getattr(lockprobe, name)
        home = getattr(thing, "__module__", "lockprobe")
        assert home.startswith("lockprobe")
        assert not any(part.startswith("_") for part in home.split("."))
    assert set(lockprobe.__all__) <= set(dir(lockprobe))


def test_the_door_is_quick():
    """Only what announces the environment is imported, and no class of it before it is asked for."""
    code = (
        "import sys, lockprobe; dir(lockprobe); "
        "print(sorted({'numpy', 'pydantic', 'asyncio', 'importlib.metadata', 'lockprobe.trial.record', 'lockprobe.trial.loop'}"
        " & sys.modules.keys())); lockprobe.Joint; lockprobe.UserMistake; print('numpy' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines() == ["[]", "False"]


MISTAKES = [
    (lambda: lockprobe.run_trial(agent="mcp:x"), "agent: got 'mcp:x', expected one that is called: people join"),
    (lambda: lockprobe.run_trial(agent="random?x=1"), "no option of random is called 'x'; there are: none"),
    (lambda: lockprobe.study(3), "no study is called '3'; there are: flips, "),
    (lambda: lockprobe.study(Path("none.toml")), "none.toml: cannot be read"),
    (lambda: lockprobe.run_study("flips", "d"), "study: got 'flips', expected a study, as lockprobe.study makes"),
    (lambda: lockprobe.tidy(None), "trials: got None, expected a trial or several"),
    (lambda: lockprobe.propagate(p="0.4"), "p: got '0.4', expected a number"),
    (lambda: lockprobe.propagate(modality=5), "modality: got 5, expected a text"),
    (lambda: lockprobe.propagate(max_steps="20"), "max_steps: got '20', expected a whole number from 1 to 10000"),
    (lambda: lockprobe.population(trials=1.5), "trials: got 1.5, expected a whole number from 1"),
    (lambda: lockprobe.population(repetition="x"), "repetition: got 'x', expected a whole number from 1"),
    (lambda: lockprobe.population(flip=None), "flip: got None, expected one of transient, sticky, outcome-only, mem"),
    (lambda: lockprobe.population(p=[0, 0.4]), "p: got \\[0, 0.4\\], expected a number"),
    (lambda: box_of(initial="00"), "initial: got '00', expected positions True \\(open\\) and False"),
    (lambda: box_of(interlock={"a": {"b": True}}), "interlock of a: got {'b': True}, expected a tuple of clauses"),
    (lambda: make_trial(["slider-1"]), "joint: got 'slider-1', expected a whole number from 0 to 3"),
]  # fmt: skip


def box_of(**wrong):
    joints = tuple(lockprobe.Joint(name=name, kind="prismatic") for name in "ab")
    usual = {"name": "x", "joints": joints, "interlock": {}, "initial": (False,) * 2, "target": "a"}
    return lockprobe.Lockbox(**usual | wrong)


@pytest.mark.parametrize(("ask", "said"), MISTAKES)
def test_a_mistake_is_one_line_that_says_what_was_asked_and_what_exists(ask, said):
    with pytest.raises(lockprobe.UserMistake, match=said) as mistake:
        ask()
    assert "\n" not in str(mistake.value)


ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "examples" / "third_party"
PAGE = (ROOT / "docs" / "extending.md").read_text("utf-8")
SHOWN = dict(re.findall(r"^`([\w./]+)`:\n\n```(?:py|toml)\n(.*?)^```$", PAGE, re.DOTALL | re.MULTILINE))


def test_the_page_shows_files_as_they_are():
    assert {"pyproject.toml", "src/latecomer/late.py"} <= set(SHOWN)
    for name, text in SHOWN.items():
        assert text == (PACKAGE / name).read_text("utf-8"), name
    assert PAGE.count("\n```py\n") + PAGE.count("\n```toml\n") == len(SHOWN)


def test_the_package_adds_one_of_each_kind_and_is_tested_with_the_wheel_alone():
    points = tomllib.loads(SHOWN["pyproject.toml"])["project"]["entry-points"]
    ours = {"lockprobe.commands", "lockprobe.tools", "lockprobe.plant_sources"}
    assert set(points) == set(GROUPS.values()) - ours
    assert all(group in PAGE.partition("## The package")[0] for group in points)
    assert ".ci/third-party" in (ROOT / ".ci" / "run").read_text("utf-8")


def test_the_page_begins_with_the_names_of_the_front_door():
    table = PAGE.partition("| names | what they are |")[2].partition("\n\n")[0]
    first = [line.split("|")[1] for line in table.splitlines() if line.startswith("| `")]
    assert sorted(name for cell in first for name in re.findall(r"`(\w+)`", cell)) == sorted(lockprobe.__all__)
