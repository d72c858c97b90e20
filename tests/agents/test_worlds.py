"""Worlds of known mechanism have the effects that they are made for, exactly."""

import re
from functools import cache
from pathlib import Path

import pytest

from lockprobe.agents.catalogue import resolve
from lockprobe.agents.policy import View
from lockprobe.agents.worlds import WORLDS, LostHalf
from lockprobe.errors import BadValue, UnknownName
from lockprobe.montecarlo import propagate
from lockprobe.studies.single import run_trial

P = 0.4
ARMS = {
    "lie": f"flip?p={P}",
    "corrected": f"correction?p={P}",
    "placebo": f"correction?p={P}&of=truth",
    "remark": f"distract?p={P}&luck=flip",
    "withheld": f"drop?p={P}&luck=flip",
    "tremble": f"tremble?p={P}&luck=flip",
}


@cache
def success(name, spec=""):
    """The exact probability that a world solves the box."""
    return propagate(f"world:{name}", condition=spec).success


@pytest.fixture(scope="module")
def effects():
    """What each arm changes against the truth, for each world."""
    return {name: {arm: success(name, spec) - success(name) for arm, spec in ARMS.items()} for name in WORLDS}


def test_the_table_of_the_documentation_is_exact():
    page = (Path(__file__).parents[2] / "docs" / "agents.md").read_text("utf-8")
    rows = re.findall(r"^\| `([a-z-]+)` \| [^|]+ ((?:\| [01]\.\d{3} ){6})\|$", page, re.MULTILINE)
    assert [name for name, _ in rows] == list(WORLDS)
    specs = ["", *(ARMS[arm] for arm in ("lie", "corrected", "remark", "withheld", "tremble"))]
    for name, numbers in rows:
        exact = [f"{success(name, spec):.3f}" for spec in specs]
        assert re.findall(r"[01]\.\d{3}", numbers) == exact


def test_the_loop_breaker_is_helped_by_all_that_is_odd_whatever_it_says(effects):
    found = effects["loop-breaker"]
    odd = [found[arm] for arm in ("corrected", "placebo", "remark", "withheld")]
    assert min(odd) > 0.2
    assert max(odd) - min(odd) < 0.002
    assert abs(found["lie"] - odd[0]) < 0.02
    assert found["tremble"] < 0.1


@pytest.mark.parametrize(
    ("name", "least", "most"),
    [("perseverant", 0.07, 0.09), ("information", -0.06, -0.04), ("information-hurts", -0.08, -0.06),
     ("careful-believer", -0.06, -0.04)],
)  # fmt: skip
def test_those_who_believe_are_changed_by_what_lies_say_alone(effects, name, least, most):
    found = effects[name]
    assert least < found["lie"] < most
    assert found["corrected"] == found["placebo"] == found["remark"] == pytest.approx(0, abs=1e-12)


@pytest.mark.parametrize("name", ["irrelevant", "lost-half"])
def test_nothing_that_is_told_changes_those_who_do_not_heed_it(effects, name):
    told = [effects[name][arm] for arm in ("lie", "corrected", "placebo", "remark")]
    assert told == pytest.approx([0] * 4, abs=1e-12)


def test_a_lost_trial_goes_round_two_joints_in_half_of_all_trials():
    policy, view = LostHalf(), View(joints=4, target=0)
    memory, lost = policy.begin(view), 1.0
    for joint in (1, 2, 1, 2, 1):
        lost *= policy.probabilities(view, memory)[joint]
        memory = policy.remember_silence(view, memory, joint)
    assert lost == pytest.approx(0.5 / 6 + 0.5 / 4**5)
    assert sum(policy.probabilities(view, memory)) == pytest.approx(1)


def test_worlds_are_agents_by_spec():
    assert (
        run_trial(agent="world:loop-breaker", seed=2).actions == run_trial(agent="world:loop-breaker", seed=2).actions
    )
    with pytest.raises(UnknownName, match="loop-braker"):
        resolve("world:loop-braker")
    with pytest.raises(BadValue, match="without options"):
        resolve("world:lost-half?p=1")
    with pytest.raises(BadValue, match="at least three joints"):
        run_trial(agent="world:lost-half", box="chain-2")
