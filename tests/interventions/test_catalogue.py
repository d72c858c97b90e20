"""Interventions by spec: those that ship, those of a package, and those of nobody."""

import json
import re
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import pytest

from lockprobe.foundation.errors import UserMistake
from lockprobe.foundation.plugins import allow
from lockprobe.foundation.spec import Spec
from lockprobe.interventions.catalogue import interventions_of, shipped, shipped_as
from lockprobe.studies.running.single import run_trial
from lockprobe.testing import check_intervention
from lockprobe.trial.condition import place_of, spec_of

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
ROWS = dict(
    re.findall(r"^\| `([^`]+)` \| (\w+) ", (ROOT / "docs" / "interventions.md").read_text("utf-8"), re.MULTILINE)
)
"""Spec in the documentation -> place."""


def test_every_one_that_ships_has_a_test_file_and_a_line_in_the_documentation():
    kinds = {shipped_as(Spec.parse(spec)) for spec in ROWS}
    assert kinds == set(shipped().values())
    modules = {kind.__module__.rpartition(".")[2] for kind in shipped().values()}
    assert [module for module in modules if not (HERE / f"test_{module}.py").exists()] == []


ALONE = {spec: place for spec, place in ROWS.items() if "like=" not in spec}
"""Those that need no other study; the other one has tests of its own for the same laws."""


@pytest.mark.parametrize(("spec", "place"), ALONE.items())
def test_every_one_keeps_its_contract_and_plays_as_in_truth_at_dose_0(spec, place, monkeypatch):
    monkeypatch.chdir(HERE)
    (one,) = interventions_of(spec)
    assert place_of(type(one)) == place
    check_intervention(one, doses=(0,))


def test_they_are_found_when_a_spec_is_read_and_not_before():
    code = """if True:
        import sys, lockprobe
        lockprobe.run_trial
        print([m for m in sys.modules if m == 'lockprobe.interventions.tremble'])
        lockprobe.run_trial(condition='drop')
        print([m for m in sys.modules if m == 'lockprobe.interventions.tremble'])
    """
    ran = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert ran.stdout.split() == ["[]", "['lockprobe.interventions.tremble']"]


def test_a_condition_is_read_in_order_and_written_again():
    spec = "flip?p=0.4&others=kept + nudge?after=3 + tremble?p=0.1"
    assert " + ".join(map(spec_of, interventions_of(spec))) == spec
    assert interventions_of("truth") == interventions_of("") == ()


@pytest.mark.parametrize(
    ("spec", "said"),
    [
        ("lie", "no intervention is called 'lie'"),
        ("flip?q=1", "no option of flip is called 'q'"),
        ("flip?p=2", "expected a number from 0 to 1"),
        ("flip?p", "expected options as name"),
        ("nudge?after=1", "expected a number of copies from 2"),
        ("python:nowhere:Nothing", "importable class"),
        ("python:json:JSONDecoder", "json is one of Python"),
        (f"python:{__name__}:Both", "exactly one of perceive, brief, recall, act"),
        (f"python:{__name__}:pytest.Item", "a frozen dataclass"),
        ("history?last=-1", "a whole number from 0"),
        ("flip?p=0.1 +", "no intervention is called ''"),
    ],
)
def test_what_is_none_is_refused_in_one_line(spec, said):
    allow(spec)
    with pytest.raises(UserMistake, match=said.replace("?", r"\?")) as refused:
        interventions_of(spec)
    assert "\n" not in str(refused.value)


@dataclass(frozen=True, kw_only=True)
class Louder:
    """Ends every report with an exclamation mark of its own kind."""

    marks: int = 1

    def brief(self, briefing, past, task, rng):
        return briefing


@dataclass(frozen=True)
class Both:
    """Acts at two places."""

    def brief(self, briefing, past, task, rng):
        return briefing

    def act(self, joint, past, task, rng):
        return joint


def test_a_stranger_s_class_is_named_by_its_module(monkeypatch):
    allow(f"python:{__name__}:Louder")
    (made,) = interventions_of(f"python:{__name__}:Louder?marks=3")
    assert made == Louder(marks=3)
    assert spec_of(made) == f"python:{__name__}:Louder?marks=3"
    check_intervention(made)
    with pytest.raises(UserMistake, match="exactly one of perceive, brief, recall, act"):
        place_of(Both)


@dataclass(frozen=True)
class Draws:
    """Draws as often as its dose says."""

    doses = ("p",)
    p: float = 0.0

    def act(self, joint, past, task, rng):
        rng.random(int(10 * self.p))
        return joint


@dataclass(frozen=True)
class Counts:
    """Keeps something between calls."""

    def act(self, joint, past, task, rng):
        SEEN.append(joint)
        return task.joints[len(SEEN) % len(task.joints)]


SEEN: list[str] = []


@dataclass(frozen=True)
class Always:
    """Acts at dose 0."""

    doses = ("p",)
    p: float = 0.0

    def act(self, joint, past, task, rng):
        return task.joints[0]


@pytest.mark.parametrize(
    ("one", "said"), [(Draws(p=0.5), "equally often"), (Counts(), "keeps something"), (Always(), "as in truth")]
)
def test_the_contract_finds_who_breaks_it(one, said):
    with pytest.raises(AssertionError, match=said):
        check_intervention(one)


def test_one_intervention_has_the_same_luck_whatever_else_acts():
    alone, beside = (
        run_trial(agent="random", condition=spec) for spec in ("tremble?p=0.5", "drop?p=0.9 + tremble?p=0.5")
    )
    assert alone.actions == beside.actions
    assert any(step.chosen for step in alone.steps)


def test_a_flip_in_a_condition_is_the_flip_of_a_study():
    by_p, by_spec = run_trial(p=0.4, seed=5), run_trial(condition="flip?p=0.4", seed=5)
    assert by_p.steps == by_spec.steps
    assert by_p.channels == by_spec.channels
    with pytest.raises(UserMistake, match="flips reports itself"):
        run_trial(p=0.2, condition="flip?p=0.4")


def test_the_command_lists_them(lockprobe_command):
    rows = [json.loads(line) for line in lockprobe_command("list", "interventions", "--json").splitlines()]
    assert {row["spec"] for row in rows} == set(shipped())
    assert {row["spec"]: row["doses"] for row in rows}["tremble"] == ["p"]
    assert [row["place"] for row in rows] == sorted((row["place"] for row in rows), key=PLACES.index)


PLACES = ["told", "asked", "remembered", "done"]


@pytest.fixture
def lockprobe_command(capsys, monkeypatch):
    from lockprobe.cli import main

    def run(*arguments):
        monkeypatch.setattr("sys.argv", ["lockprobe", *arguments])
        with pytest.raises(SystemExit):
            main()
        return capsys.readouterr().out

    return run


def test_numbers_of_a_stream_do_not_depend_on_the_dose():
    def slips(p):
        return {step.step for step in run_trial(agent="random", condition=f"tremble?p={p}").steps if step.chosen}

    few, many = slips(0.2), slips(0.9)
    shared = range(1, 1 + min(len(run_trial(agent="random", condition=f"tremble?p={p}").steps) for p in (0.2, 0.9)))
    assert few & set(shared) <= many
