"""Interventions and conditions by spec: those that ship, those of a package, and those of nobody."""

import re
from dataclasses import dataclass
from pathlib import Path

import pytest

from lockprobe.foundation.errors import BadValue, UserMistake
from lockprobe.foundation.plugins import allow
from lockprobe.foundation.spec import Spec
from lockprobe.interventions.asked_and_done import Tremble
from lockprobe.interventions.conditions import (
    interventions_in,
    interventions_of,
    read_condition,
    shipped,
    shipped_as,
    sweep,
)
from lockprobe.testing import check_intervention
from lockprobe.trial.condition import Condition, Recorded, place_of, spec_of

HERE = Path(__file__).parent
DOCS = (HERE.parents[1] / "docs" / "conditions.md").read_text("utf-8")
ROWS = dict(re.findall(r"^\| `([^`]+)` \| (\w+) ", DOCS, re.MULTILINE))
"""Spec in the documentation -> place."""


def test_every_one_that_ships_has_a_line_in_the_documentation():
    assert {shipped_as(Spec.parse(spec)) for spec in ROWS} == set(shipped().values())


MORE = [
    *(f"flip?p=0.3&{reading}" for reading in ("keep=0.5", "others=kept", "only=blocked", "at=4", "while=looping")),
    *(f"flip?p=0.3&inverts=position&{others}" for others in ("keep=0.5", "others=kept", "others=noisy")),
    "correction?p=0.4&first=truth&last=lie", "distract?p=0.3&luck=flip",
]  # fmt: skip
CONTRACTS = [spec for spec in ROWS if "like=" not in spec] + MORE
"""But for the one that needs another study, whose tests have the same laws."""


@pytest.mark.parametrize("spec", CONTRACTS)
def test_every_one_keeps_its_contract_and_plays_as_in_truth_at_dose_0(spec, monkeypatch):
    monkeypatch.chdir(HERE)
    (one,) = interventions_of(spec)
    assert place_of(type(one)) == ROWS.get(spec, place_of(type(one)))
    check_intervention(one, doses=(0, 1), modality="symbolic")


@pytest.mark.parametrize(
    ("spec", "said"),
    [
        ("lie", "no intervention is called 'lie'"),
        ("flip?p", "'flip?p', expected options as name"),
        ("flip?p=0.1 +", "no intervention is called ''"),
        ("python:nowhere:Nothing", "does not work (ModuleNotFoundError: No module named 'nowhere')"),
        ("python:json:JSONDecoder", "a frozen dataclass"),
        (f"python:{__name__}:Both", "exactly one of perceive, brief, recall, act"),
        (f"python:{__name__}:pytest.Item", "a frozen dataclass"),
        ("flip?q=1", "no option of flip is called 'q'"),
        ("flip?while_=looping", "no option of flip is called 'while_'"),
        ("flip?p=2", "p: got 2.0, expected a number from 0 to 1"),
        ("flip?p=nan", "got nan, expected a"),
        ("flip?inverts=both", "inverts: got 'both', expected one of position, outcome"),
        ("flip?keep=2", "keep: got 2.0, expected a number from 0 to 1"),
        ("flip?keep=0.5&others=kept", "others: got 'kept', expected none with keep=0.5, which says it already"),
        ("flip?only=true", "only: got 'true', expected one of moved, blocked, any"),
        ("flip?while=lost", "while: got 'lost', expected one of looping, always"),
        ("flip?at=4;0", "at: got 0, expected a whole number from 1"),
        ("flip?at=4;x", "at: got 'x', expected a whole number"),
        ("flip?part=none", "part: got 'none', expected one of both, outcome, position"),
        ("flip?part=outcome&keep=1", "part: got 'outcome', expected none with inverts, others or keep"),
        ("flip?others=noisy", "others: got 'noisy', expected inverts=position with it, and no keep, part, only or"),
        ("flip?inverts=position&others=noisy&keep=1", "others: got 'noisy', expected inverts=position with it"),
        ("flip?like=rgb&by=place", "by: got 'place', expected one of joint, direction, total"),
        ("flip?like=rgb&part=outcome", "none with others=noisy or part"),
        ("flip?like=rgb&rates=slider:0.1", "rates: got 'slider:0.1', expected joints with the rates"),
        ("flip?like=rgb&rates=slider:0.1:1.2", "rates: got 'slider:0.1:1.2'"),
        ("flip?like=rgb&rates=slider:1.2:0.1", "rates: got 'slider:1.2:0.1'"),
        ("flip?like=rgb&rates=:0.1:0.2", "rates: got ':0.1:0.2'"),
        ("flip?like=rgb&rates=slider:0:1;slider:0:1", "rates: got 'slider:0:1'"),
        ("phantom?p=1.2", "p: got 1.2, expected a number from 0 to 1"),
        ("correction?at=3;0", "at: got 0, expected a whole number from 1"),
        ("correction?first=half", "first: got 'half', expected one of lie, truth"),
        ("correction?last=half", "last: got 'half', expected one of lie, truth"),
        ("correction?others=noisy", "others: got 'noisy', expected one of fresh, kept"),
        ("correction?inverts=all", "inverts: got 'all', expected one of position, outcome"),
        ("correction?p=2", "p: got 2"),
        ("delay?lag=-1", "lag: got -1, expected a whole number from 0"),
        ("history?last=-1", "a whole number from 0"),
        ("hypothesis?ask=never", "ask: got 'never', expected one of before, after, off"),
        ("nudge?after=1", "after: got 1, expected a whole number from 2"),
        ("prompt", "a file with an instruction"),
    ],
)
def test_what_is_none_is_refused_in_one_line(spec, said):
    allow(spec)
    with pytest.raises(UserMistake) as refused:
        interventions_of(spec)
    assert said in str(refused.value)
    assert "\n" not in str(refused.value)


@dataclass(frozen=True, kw_only=True)
class Louder:
    """Ends every report with an exclamation mark of its own kind."""

    marks: int = 1

    def brief(self, briefing, past, task, rng):
        return briefing


@dataclass(frozen=True)
class Both(Louder):
    """Acts at two places."""

    def act(self, joint, past, task, rng):
        return joint


def test_a_stranger_s_class_is_named_by_its_module():
    allow(f"python:{__name__}:Louder")
    (made,) = interventions_of(f"python:{__name__}:Louder?marks=3")
    assert made == Louder(marks=3)
    assert spec_of(made) == f"python:{__name__}:Louder?marks=3"
    check_intervention(made)


@pytest.mark.parametrize(
    ("spec", "p", "nothing"),
    [
        ("truth", 0, True), ("flip?p=0", 0, True), ("flip?p=0.1234567890123", 0.1234567890123, False),
        ("tremble?p=0", None, True), ("tremble?p=0 + flip?p=0&others=kept", None, True), ("nudge", None, False),
        ("tremble?p=0.1", None, False), ("symbolic?tell=outcome", 0, True),
    ],
)  # fmt: skip
def test_only_flips_have_a_flip_rate_and_dose_0_does_nothing(spec, p, nothing):
    assert (read_condition(spec).p, read_condition(spec).does_nothing) == (p, nothing)


@pytest.mark.parametrize(
    ("written", "specs"),
    [
        ("tremble?p=0,0.1, 0.2", ["tremble?p=0", "tremble?p=0.1", "tremble?p=0.2"]),
        (
            "nudge?after=3 + drop?p=0.1,0.2&luck=flip",
            ["nudge?after=3 + drop?p=0.1&luck=flip", "nudge?after=3 + drop?p=0.2&luck=flip"],
        ),
        (
            "flip?p=0,0.2,0.4 + nudge + tremble?p=0,0.1",
            [
                "nudge", "nudge + tremble?p=0.1", "flip?p=0.2 + nudge", "flip?p=0.2 + nudge + tremble?p=0.1",
                "flip?p=0.4 + nudge", "flip?p=0.4 + nudge + tremble?p=0.1",
            ],
        ),
        ("flip?p=0.4&keep=0,0.5,1", ["flip?p=0.4", "flip?p=0.4&keep=0.5", "flip?p=0.4&others=kept"]),
        ("flip?p=0,0.4 + rgb?blur=0,8", ["rgb", "rgb?blur=8", "flip?p=0.4 + rgb", "flip?p=0.4 + rgb?blur=8"]),
        ("nudge + rgbd?noise=1&blur=2,4", ["nudge + rgbd?noise=1&blur=2", "nudge + rgbd?noise=1&blur=4"]),
    ],
)  # fmt: skip
def test_a_sweep_is_one_condition_for_each_combination_of_doses(written, specs):
    assert [one.spec for one in sweep(written)] == specs


@pytest.mark.parametrize(
    "spec",
    [
        "tremble?p=0.1", "nudge?after=2,3", "truth", "tremble?p=0,0.1 + nudge?after=2,3", "symbolic?tell=state,both",
        " + ".join(f"{name}?p={','.join('0' * 11)}" for name in ("flip", "drop", "tremble")),
    ],
)  # fmt: skip
def test_a_sweep_is_over_several_values_of_a_dose(spec):
    with pytest.raises(BadValue, match="sweep"):
        sweep(spec)


def test_settings_import_nothing_until_a_trial_is_played():
    stranger = Condition(interventions=(Recorded(spec="python:mine:Hush?x=1", doses=("x",)),))
    assert stranger.acting == ((Spec.parse("python:mine:Hush?x=1"), ("x",)),)
    assert stranger.doses == {"python:mine:Hush.x": 1.0}
    with pytest.raises(BadValue, match="what a file or a directory names is data, and is not run"):
        interventions_in(stranger)
    known = Condition(interventions=(Recorded(spec="tremble?p=0.1", doses=("p",)),))
    assert (known.is_recorded, read_condition("tremble?p=0.1").is_recorded) == (True, False)
    assert known == Condition(interventions=(Tremble(p=0.1),))
    assert interventions_in(known) == (Tremble(p=0.1),)
