"""Worlds of known mechanism have the effects that they are made for, exactly."""

import re
from functools import cache
from pathlib import Path

import pytest

from lockprobe.agents.catalogue import resolve
from lockprobe.agents.policy import View
from lockprobe.agents.worlds import WORLDS, LostHalf
from lockprobe.foundation.errors import BadValue, UnknownName
from lockprobe.simulation.exact.propagation import propagate
from lockprobe.statistics.why.arms import ARMS
from lockprobe.studies.running.single import run_trial

SPECS = {arm: "" if arm == "truth" else spec.format(p=0.4, reading="") for arm, spec in ARMS.items()}
FEW = 0.011
"""A change of success that is as good as none."""


@cache
def shares(name):
    """Arm -> the exact probability that a world solves the box."""
    return {arm: propagate(f"world:{name}", condition=spec).success for arm, spec in SPECS.items()}


def changes(name):
    """What each arm changes against the truth."""
    found = shares(name)
    return {arm: found[arm] - found["truth"] for arm in ARMS if arm != "truth"}


def test_the_table_of_the_documentation_is_exact():
    page = (Path(__file__).parents[2] / "docs" / "agents.md").read_text("utf-8")
    rows = re.findall(r"^\| `([a-z-]+)` \| [^|]+ ((?:\| [01]\.\d{3} ){7})\|$", page, re.MULTILINE)
    assert [name for name, _ in rows] == list(WORLDS)
    for name, numbers in rows:
        assert re.findall(r"[01]\.\d{3}", numbers) == [f"{share:.3f}" for share in shares(name).values()]


@pytest.mark.parametrize("name", ["loop-breaker", "form-by-length"])
def test_whatever_is_odd_helps_those_whom_forms_free_and_what_it_says_does_nothing(name):
    found = changes(name)
    assert min(found.values()) > 0.2
    crossed = [found[arm] for arm in ("truth-truth", "lie-truth", "truth-lie", "lie-lie")]
    assert max(crossed) - min(crossed) < 0.001
    assert (crossed[0] - found["remark"] > 0.01) == (name == "form-by-length")


def test_a_sceptic_is_freed_by_two_statements_only_if_they_agree():
    found = changes("sceptic")
    assert found["lie-lie"] == pytest.approx(found["truth-truth"], abs=FEW)
    assert min(found[arm] for arm in ("lie", "remark", "lie-lie")) > 0.2
    assert max(found["lie-truth"], found["truth-lie"]) < found["lie-lie"] - 0.1


def test_what_is_new_but_comes_too_early_does_not_help():
    found = changes("novelty")
    assert found["lie"] > 0.08
    assert all(-FEW < found[arm] < 0 for arm in ARMS if arm not in ("truth", "lie"))


def test_one_false_statement_is_enough_where_any_contradiction_frees():
    found = changes("any-falsehood")
    assert min(found[arm] for arm in ("lie", "lie-truth", "truth-lie", "lie-lie")) > 0.2
    assert found["truth-truth"] == found["remark"] == pytest.approx(0, abs=1e-12)


@pytest.mark.parametrize(
    ("name", "false", "least", "most"),
    [
        ("last-believer", "last", 0.36, 0.37),
        ("perseverant", "last", 0.07, 0.09),
        ("information", "last", -0.06, -0.04),
        ("information-hurts", "last", -0.08, -0.06),
        ("careful-believer", "last", -0.06, -0.04),
        ("first-believer", "first", 0.36, 0.38),
    ],
)
def test_a_believer_is_changed_by_the_statement_that_it_believes_alone(name, false, least, most):
    found = changes(name)
    does, does_not = ("truth-lie", "lie-truth") if false == "last" else ("lie-truth", "truth-lie")
    assert all(least < found[arm] < most for arm in ("lie", "lie-lie", does))
    assert found["truth-truth"] == found["remark"] == pytest.approx(0, abs=1e-12)
    assert found[does_not] < 0 if false == "first" else found[does_not] == pytest.approx(0, abs=1e-12)


def test_who_believes_statements_that_agree_is_helped_by_two_lies_alone():
    found = changes("agreed-believer")
    assert found["lie-lie"] == pytest.approx(found["lie"], abs=1e-12)
    assert found["lie"] > 0.36
    assert found["truth-truth"] == found["remark"] == pytest.approx(0, abs=1e-12)
    assert max(found["lie-truth"], found["truth-lie"]) < 0


@pytest.mark.parametrize(("name", "jolted"), [("plain-believer", False), ("correction-jolt", True)])
def test_corrections_do_not_show_what_lies_do_to_those_who_do_not_believe_them(name, jolted):
    found = changes(name)
    assert found["lie"] > 0.36
    assert found["remark"] == pytest.approx(0, abs=1e-12)
    crossed = [found[arm] for arm in ("truth-truth", "lie-truth", "truth-lie", "lie-lie")]
    assert min(crossed) > 0.09 if jolted else max(crossed) < -0.09
    assert max(crossed) - min(crossed) == pytest.approx(0, abs=0.001 if jolted else 0.04)


def test_two_halves_show_both_of_their_mechanisms():
    found = changes("half-and-half")
    assert found["truth-truth"] == pytest.approx(found["remark"], abs=FEW)
    assert found["remark"] > 0.1
    assert min(found["lie-truth"], found["lie-lie"]) > found["truth-truth"] + 0.15


@pytest.mark.parametrize("name", ["irrelevant", "lost-half"])
def test_nothing_that_is_told_changes_those_who_do_not_heed_it(name):
    assert list(changes(name).values()) == pytest.approx([0] * 6, abs=1e-12)


def test_a_lost_trial_goes_round_two_joints_in_half_of_all_trials():
    policy, view = LostHalf(), View(joints=4, target=0)
    memory, lost = policy.begin(view), 1.0
    for joint in (1, 2, 1, 2, 1):
        lost *= policy.probabilities(view, memory)[joint]
        memory = policy.remember_silence(view, memory, joint)
    assert lost == pytest.approx(0.5 / 6 + 0.5 / 4**5)
    assert sum(policy.probabilities(view, memory)) == pytest.approx(1)


def test_the_second_attempt_decides_which_half_acts():
    policy, view = WORLDS["half-and-half"](), View(joints=4, target=0)
    start = policy.begin(view)
    assert policy.probabilities(view, start) == (0.25,) * 4
    once = policy.remember_silence(view, start, 2)
    assert policy.probabilities(view, once) == pytest.approx((1 / 6, 1 / 6, 1 / 2, 1 / 6))
    for joint, acts in ((2, 0), (3, 1)):
        memory = policy.remember_silence(view, once, joint)
        acting = policy.policies[acts]
        expected = acting.remember_silence(view, acting.remember_silence(view, acting.begin(view), 2), joint)
        assert (memory.acts, memory.kept[acts], memory.kept[1 - acts]) == (acts, expected, None)
        assert policy.probabilities(view, memory) == acting.probabilities(view, expected)


def test_worlds_are_agents_by_spec():
    for world in ("world:loop-breaker", "world:half-and-half", "world:correction-jolt"):
        assert run_trial(agent=world, seed=2).actions == run_trial(agent=world, seed=2).actions
    with pytest.raises(UnknownName, match="loop-braker"):
        resolve("world:loop-braker")
    with pytest.raises(BadValue, match="without options"):
        resolve("world:lost-half?p=1")
    with pytest.raises(BadValue, match="at least three joints"):
        run_trial(agent="world:lost-half", box="chain-2")
