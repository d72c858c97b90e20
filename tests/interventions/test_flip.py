"""False reports: what flips and their kin invert, how often, and what becomes of it."""

from itertools import product

import numpy as np
import pytest

from lockprobe.foundation.errors import BadValue
from lockprobe.interventions.conditions import interventions_of
from lockprobe.interventions.flip import READINGS, MisreadFlip, OutcomeFlip, flip_of, misread_rates
from lockprobe.interventions.told import Phantom
from lockprobe.statistics.misinterpretation import Claim
from lockprobe.studies.running.single import run_trial
from lockprobe.trial.condition import spec_of
from lockprobe.trial.record import Moment, Percept, Task

TASK = Task(joints=("A", "B", "C"), target="C", budget=20)
TRUTH = Percept(joint="B", outcome="moved", positions=(False, True, False))
LIKE = [OutcomeFlip(inverts=inverts, keep=keep) for inverts in ("position", "outcome") for keep in (0, 0.5, 1)]
PARTS = [OutcomeFlip(part="outcome"), *(OutcomeFlip(part="position", inverts=one) for one in ("position", "outcome"))]


def played(like, seed=1, agent="random", p=0.5, **settings):
    return run_trial(agent=agent, box="chain-8", condition=[like.at_rate(p)], seed=seed, max_steps=40, **settings)


def told_errors(trial):
    """After each step the joints told falsely, as bits in panel order."""
    truth = [step.state for step in trial.steps[1:]]
    told = [step.told_state for step in trial.steps]
    return [[a != b for a, b in zip(one, other, strict=True)] for one, other in zip(truth, told, strict=False)]


@pytest.mark.parametrize("seed", [1, 2])
@pytest.mark.parametrize("like", [*LIKE, *PARTS], ids=lambda one: one.reading)
def test_each_reading_is_its_law_of_false_positions(like, seed):
    """Position: false if this report is flipped. Outcome: false if it was before, or this report is flipped, not both.
    Others: true if fresh, as they were if kept. One part alone: at the same steps, and the other part is true."""
    flips = [step.told_falsely for step in played(OutcomeFlip(), seed, modality="symbolic").steps]
    trial = played(like, seed, modality="symbolic")
    assert [step.told_falsely for step in trial.steps] == [one and like.part != "position" for one in flips]
    before = [False] * 8
    for step, flipped, after in zip(trial.steps, flips, told_errors(trial), strict=False):
        for joint in range(8):
            if trial.joints[joint] == step.joint:
                law = flipped ^ (like.inverts == "outcome" and before[joint])
                assert after[joint] == (law and like.part != "outcome")
            elif like.keep in (0, 1):
                assert after[joint] == (before[joint] and like.keep == 1)
            else:
                assert not after[joint] or before[joint]
        before = after


@pytest.mark.parametrize(
    ("spec", "canonical", "reading"),
    [
        ("flip?p=0.4&others=fresh", "flip?p=0.4", "re-observed outcome noise"),
        ("flip?p=0.4&keep=0&inverts=outcome", "flip?p=0.4", "re-observed outcome noise"),
        ("flip?p=0.4&keep=1", "flip?p=0.4&others=kept", "integrated outcome noise"),
        ("flip?p=0.4&inverts=position", "flip?p=0.4&inverts=position", "memoryless state noise"),
        ("flip?inverts=position&keep=1", "flip?p=0&inverts=position&others=kept", "latched state noise"),
        ("flip?p=0.4&keep=0.5", "flip?p=0.4&keep=0.5", "partly integrated outcome noise (keep = 0.5)"),
        ("flip?others=noisy&inverts=position", "flip?p=0&inverts=position&others=noisy", "independent state noise"),
        ("flip?like=x&rates=a:0:1&size=1", "flip?p=1&like=x&rates=a:0:1&size=1", "re-observed outcome noise"),
        ("flip?like=x&keep=1", "flip?p=1&others=kept&like=x", "integrated outcome noise"),
    ],
)
def test_every_flip_has_one_spec_and_a_name(spec, canonical, reading):
    (flip,) = interventions_of(spec)
    assert (spec_of(flip), flip.reading) == (canonical, reading)
    assert interventions_of(canonical) == (flip,)
    assert READINGS[flip.inverts, flip.others] in reading
    with pytest.raises(BadValue, match="^flip: got 'sometimes', expected one of transient, sticky, outcome-only, mem"):
        flip_of("sometimes")


def lies(condition, agent="round-robin", **settings):
    """The steps with false reports, and the trial."""
    trial = run_trial(agent=agent, box="chain-7", max_steps=30, condition=condition, modality="symbolic", **settings)
    return {step.step for step in trial.steps if step.told_falsely}, trial


def test_options_leave_out_some_of_the_same_steps():
    """An agent that heeds no report attempts the same joints whatever it is told."""
    every, trial = lies("flip?p=0.5", seed=3)
    moved = {step.step for step in trial.steps if step.moved}
    assert {4, 8} & every
    assert lies("flip?p=0.5&only=moved", seed=3)[0] == every & moved
    assert lies("flip?p=0.5&only=blocked", seed=3)[0] == every - moved
    assert lies("flip?p=1&at=1", seed=3)[0] == {1}
    assert lies("flip?p=0.5&at=4;8;11", seed=3)[0] == every & {4, 8, 11}


def test_after_a_missing_report_the_false_one_is_false_to_the_truth():
    outcomes = set()
    for at, others in product(range(2, 9), ("fresh", "kept")):
        spec = f"flip?p=1&at={at}&others={others} + drop?p=1&at={at - 1}"
        trial = run_trial(condition=spec, agent="round-robin", box="chain-7", modality="symbolic")
        told, after = trial.steps[at - 1], trial.steps[at]
        wrong = [
            name for name, *both in zip(trial.joints, told.told_state, after.state, strict=True) if len({*both}) > 1
        ]
        assert (told.told_moved, wrong) == (not told.moved, [told.joint])
        outcomes.add(told.moved)
    assert outcomes == {True, False}


def test_noise_of_all_joints_is_in_the_reports_that_can_be_false_alone():
    noise = "flip?p=1&inverts=position&others=noisy&at=2;4"
    trial = run_trial(agent="random", box="chain-8", condition=noise, max_steps=9, modality="symbolic")
    assert told_errors(trial) == [[step in (2, 4)] * 8 for step in range(1, 9)]


def test_each_joint_has_its_own_number_by_which_its_false_position_lasts():
    numbers = [0.9, 0.2, 0.6, 0.4]
    assert OutcomeFlip(keep=0.5).lasting(numbers) == 0b101
    assert OutcomeFlip(p=0.3, inverts="position", others="noisy").lasting(numbers) == 0b001


def test_one_part_of_a_report_alone_needs_both():
    OutcomeFlip(part="both").check_told("x", both=False)
    OutcomeFlip(part="outcome").check_told("x", both=True)
    with pytest.raises(BadValue, match="part: got 'outcome', expected both with x"):
        OutcomeFlip(part="outcome").check_told("x", both=False)
    with pytest.raises(BadValue, match="inverts: got 'all', expected one of position, outcome"):
        OutcomeFlip(inverts="all")


@pytest.mark.parametrize(
    ("attempted", "lies"),
    [("ABCABC", True), ("ABCAB", False), ("ABCXABC", True), ("ABABA", False), ("ABCABD", False), ("XABCABC", True)],
)
def test_while_looping_every_report_is_true_until_the_last_three_attempts_stood_so_before(attempted, lies):
    past = [Moment(was=TRUTH, told=TRUTH), *(Moment(was=TRUTH, told=TRUTH, attempted=one) for one in attempted[:-1])]
    task = Task(joints=tuple("ABCDX"), target="X", budget=20)
    report = Percept(joint=attempted[-1], outcome="moved")
    flip = OutcomeFlip(p=1.0, while_="looping")
    assert (flip.perceive(report, tuple(past), task, np.random.default_rng(1)) != report) == lies


# Flips like the misreadings of a finished study.
def misread(hidden, invented, **options):
    """The intervention with the same two rates for every joint."""
    return [MisreadFlip(like="rgb", by_label=tuple(f"{label}:{hidden}:{invented}" for label in "ABCDEFGH"), **options)]


def blind(condition, trial=1):
    """A trial of an agent that heeds nothing, so that outcomes are the same whatever it is told."""
    return run_trial(agent="random", box="gray-code-4", trial=trial, condition=condition)


def false(condition, trial):
    return [step.told_falsely for step in blind(condition, trial).steps]


SAID = {
    Claim("a", "blocked", "moved", "moved"): 3, Claim("a", "moved", "moved", "moved"): 1,
    Claim("a", "moved", "blocked", "blocked"): 1, Claim("a", "blocked", "blocked", "blocked"): 4,
    Claim("b", "moved", "moved", "moved"): 1,
}  # fmt: skip
"""What an agent said of two joints, and how often; of a third it said nothing, and of the second no failure."""


@pytest.mark.parametrize(
    ("by", "rates"),
    [
        ("joint", {"a": (0.75, 0.2), "b": (0, 0.2), "c": (0.6, 0.2)}),
        ("direction", dict.fromkeys("abc", (0.6, 0.2))),
        ("total", dict.fromkeys("abc", (0.4, 0.4))),
    ],
)
def test_rates_of_misreading_are_those_of_the_claims_about_a_joint_or_else_about_all(by, rates):
    assert misread_rates(SAID, "abc", by) == rates


@pytest.mark.parametrize("trial", [1, 2])
def test_misreadings_are_as_frequent_as_each_direction_and_joint_has_it_and_at_one_rate_the_flip(trial):
    truth = blind("truth", trial)
    moved = [step.moved for step in truth.steps]
    assert false(misread(0.4, 0.4), trial) == false(misread(0.8, 0.8, p=0.5), trial) == false("flip?p=0.4", trial)
    assert false(misread(1, 0), trial) == moved
    assert false(misread(0, 1), trial) == [not one for one in moved]
    assert blind(misread(0.8, 0.8, p=0.0), trial).steps == truth.steps
    at_one = [step.joint == truth.joints[1] for step in truth.steps]
    assert false(f"flip?like=rgb&rates={truth.joints[1]}:1:1", trial) == at_one  # others have no rates


# Phantoms: which joint seems to jump, how often, and that nothing else is false.
def jumped(p, seed=1, truth=TRUTH, reports=1_000):
    """Whether the position of each joint is false in each report, shape (reports, joints)."""
    rng, past, found = np.random.default_rng(seed), (), []
    for _ in range(reports):
        percept = Phantom(p=p).perceive(truth, past, TASK, rng)
        assert percept.outcome == truth.outcome
        found.append([a != b for a, b in zip(percept.positions, truth.positions, strict=True)])
        past = (Moment(was=truth, told=percept),)
    return np.array(found)


def test_a_share_p_of_reports_has_one_joint_that_jumps_each_other_equally_likely():
    share = jumped(0.4)
    assert set(share.sum(axis=1)) == {0, 1}
    assert share.mean(axis=0) == pytest.approx([0.2, 0, 0.2], abs=0.05)
    assert (jumped(1, reports=200).sum(axis=1) == 1).all()
    alone = Percept(joint="A", outcome="blocked", positions=(False,))
    task = Task(joints=("A",), target="A", budget=2)
    assert Phantom(p=1.0).perceive(alone, (), task, np.random.default_rng(1)) == alone


# Corrections: a report in two statements, of which the last one is what was told.
SAYS = ("lie", "truth")


def steps(condition, seed=1, **more):
    trial = run_trial(agent="round-robin", condition=condition, seed=seed, box="chain-7", max_steps=30, **more)
    return trial.steps


@pytest.mark.parametrize("last", SAYS)
@pytest.mark.parametrize("first", SAYS)
def test_a_correction_hits_the_steps_at_which_the_flip_lies_and_its_last_statement_is_what_is_told(first, last):
    for seed in range(1, 4):
        lied = [step.step for step in steps("flip?p=0.4", seed) if step.told_falsely]
        found = steps(f"correction?p=0.4&first={first}&last={last}", seed)
        assert [step.step for step in found if "Correction:" in step.told] == lied != []
        assert [step.step for step in found if step.told_falsely] == (lied if last == "lie" else [])
