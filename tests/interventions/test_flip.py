"""The outcome flip: what it inverts, how often, and what becomes of it."""

import itertools
import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lockprobe.foundation.errors import BadValue, UserMistake
from lockprobe.interventions.catalogue import interventions_of
from lockprobe.interventions.flip import READINGS, OutcomeFlip, flip_of
from lockprobe.interventions.phantom import Phantom
from lockprobe.statistics.loops import onset
from lockprobe.studies.running.single import run_trial
from lockprobe.trial.condition import spec_of
from lockprobe.trial.record import STATES, Moment, Percept, Task

TASK = Task(joints=("A", "B", "C"), target="C", budget=20)
TRUTH = Percept(joint="B", outcome="moved", positions=(False, True, False))


class Fixed:
    """A stream that always gives one number."""

    def __init__(self, number):
        self.number = number

    def random(self):
        return self.number


def tell(channel, percept=TRUTH, previous=None, number=0.0):
    past = () if previous is None else (Moment(was=TRUTH, told=previous),)
    return channel.perceive(percept, past, TASK, Fixed(number))


LIKE = [OutcomeFlip(inverts=inverts, keep=keep) for inverts in ("position", "outcome") for keep in (0, 0.5, 1)]
NOISY = OutcomeFlip(inverts="position", others="noisy")
PARTS = [OutcomeFlip(part="outcome"), *(OutcomeFlip(part="position", inverts=one) for one in ("position", "outcome"))]


@pytest.mark.parametrize("like", LIKE, ids=lambda one: one.reading)
def test_nothing_is_flipped_at_zero_and_everything_at_one(like):
    honest, lying = tell(like), tell(like.at_rate(1.0), number=0.999999)
    assert honest.outcome == "moved"
    assert lying.outcome == "blocked"


def test_outcome_and_position_of_the_attempted_joint_agree():
    told = tell(OutcomeFlip(p=1.0))
    assert (told.outcome, told.positions) == ("blocked", (False, False, False))


def test_the_first_look_is_never_flipped():
    opening = Percept(positions=(False, False, False))
    assert tell(OutcomeFlip(p=1.0), opening) == opening


def test_a_lie_is_gone_in_the_next_report_of_another_joint():
    lie = tell(OutcomeFlip(p=1.0))
    later = Percept(joint="A", outcome="blocked", positions=(False, True, False))
    assert tell(OutcomeFlip(p=0.0), later, lie).positions == (False, True, False)


def test_a_latched_lie_stays_until_the_joint_is_attempted_again():
    lie = tell(OutcomeFlip(p=1.0, inverts="position", others="kept"))
    later = Percept(joint="A", outcome="blocked", positions=(False, True, False))
    still = tell(OutcomeFlip(p=0.0, inverts="position", others="kept"), later, lie)
    assert still.positions == (False, False, False)
    again = Percept(joint="B", outcome="moved", positions=(False, False, False))
    assert tell(OutcomeFlip(p=0.0, inverts="position", others="kept"), again, still).positions == (False, False, False)
    assert tell(OutcomeFlip(p=0.0, inverts="position", others="kept"), again, lie).outcome == "moved"


def played(like, seed=1, agent="random", p=0.5, **settings):
    return run_trial(agent=agent, box="chain-8", condition=[like.at_rate(p)], seed=seed, max_steps=40, **settings)


def told_errors(trial):
    """After each step the joints told falsely, as bits in panel order."""
    truth = [step.state for step in trial.steps[1:]]
    told = [step.told_state for step in trial.steps]
    return [[a != b for a, b in zip(one, other, strict=True)] for one, other in zip(truth, told, strict=False)]


@pytest.mark.parametrize("seed", range(1, 6))
@pytest.mark.parametrize("like", LIKE, ids=lambda one: one.reading)
def test_each_reading_is_its_law_of_false_positions(like, seed):
    """Position: false if this report is flipped. Outcome: false if it was before, or this report is flipped, not both.
    Others: true if fresh, as they were if kept."""
    flips = [step.told_falsely for step in played(OutcomeFlip(), seed, modality="symbolic").steps]
    trial = played(like, seed, modality="symbolic")
    before = [False] * 8
    for step, flipped, after in zip(trial.steps, flips, told_errors(trial), strict=False):
        assert step.told_falsely == flipped
        for joint in range(8):
            if trial.joints[joint] == step.joint:
                assert after[joint] == flipped ^ (like.inverts == "outcome" and before[joint])
            elif like.keep in (0, 1):
                assert after[joint] == (before[joint] and like.keep == 1)
            else:
                assert not after[joint] or before[joint]
        before = after


@pytest.mark.parametrize("seed", range(1, 4))
@pytest.mark.parametrize("like", PARTS, ids=lambda one: f"{one.part}-{one.inverts}")
def test_one_part_of_a_false_report_is_false_at_the_steps_of_the_whole(like, seed):
    flips = [step.told_falsely for step in played(OutcomeFlip(), seed, modality="symbolic").steps]
    trial, before = played(like, seed, modality="symbolic"), [False] * 8
    assert [step.told_falsely for step in trial.steps] == [flipped and like.part == "outcome" for flipped in flips]
    for step, flipped, after in zip(trial.steps, flips, told_errors(trial), strict=False):
        for joint, name in enumerate(trial.joints):
            repeated = like.inverts == "outcome" and before[joint]
            assert after[joint] == (like.part == "position" and name == step.joint and flipped ^ repeated)
        before = after


@pytest.mark.parametrize("modality", [STATES, "symbolic?tell=outcome"])
@pytest.mark.parametrize("part", ["outcome", "position"])
def test_one_part_alone_needs_reports_of_two(part, modality):
    expected = re.escape(f"part: got '{part}', expected both with {modality}; symbolic tells outcomes and positions")
    with pytest.raises(BadValue, match=f"^{expected}$"):
        run_trial(condition=f"flip?p=0.4&part={part}", modality=modality)


def test_noise_on_all_joints_inverts_each_position_with_probability_p_and_independently():
    rng, flip = np.random.default_rng(5), NOISY.at_rate(0.3)
    percepts = [flip.perceive(TRUTH, (), TASK, rng) for _ in range(20_000)]
    false = np.array([one.positions for one in percepts]) ^ np.array(TRUTH.positions)
    assert false.mean(axis=0) == pytest.approx([0.3] * 3, abs=0.014)
    assert np.corrcoef(false.T.astype(float)) == pytest.approx(np.eye(3), abs=0.03)
    assert ([one.outcome == "blocked" for one in percepts] == false[:, 1]).all()


def test_noise_on_all_joints_is_nested_in_p_and_inverts_the_attempted_joint_as_every_reading_does():
    memoryless = [step.told_falsely for step in played(OutcomeFlip(), modality="symbolic").steps]
    trials = [played(NOISY, p=p, modality="symbolic") for p in (0.2, 0.5, 0.8)]
    assert [step.told_falsely for step in trials[1].steps] == memoryless
    fewer, some, more = (np.array(told_errors(trial)) for trial in trials)
    assert (fewer <= some).all()
    assert (some <= more).all()
    assert fewer.sum() < some.sum() < more.sum()


def test_noise_on_all_joints_keeps_to_the_steps_of_the_flip():
    trial = run_trial(
        agent="random", box="chain-8", condition=[OutcomeFlip(p=1, inverts="position", others="noisy", at=(3, 5))]
    )
    assert [any(wrong) for wrong in told_errors(trial)][:6] == [False, False, True, False, True, False]
    assert all(told_errors(trial)[2])


@pytest.mark.parametrize("agent", ["random", "human-inspired", "cognitive:perseverant"])
@pytest.mark.parametrize("keep", [0, 0.5, 1])
def test_inverted_outcomes_are_a_share_p_of_those_that_an_agent_infers(agent, keep):
    """By comparing two reports, whatever the agent does; where positions are inverted, repeats change the share."""
    like = OutcomeFlip(keep=keep)
    trials = [played(like, trial=trial, agent=agent, p=0.3, modality=STATES) for trial in range(1, 41)]
    false = [step.told_falsely for trial in trials for step in trial.steps]
    assert abs(np.mean(false) - 0.3) < 4 * (0.21 / len(false)) ** 0.5


def test_an_agent_that_repeats_infers_other_outcomes_than_a_share_p_where_positions_are_inverted():
    """2p(1 - p) after a repeat, .32 at p = .2 and .32 at .8, where the last report was of the same joint."""
    for p, share in ((0.2, 0.32), (0.8, 0.32)):
        rng, channel, past, false = np.random.default_rng(3), OutcomeFlip(p=p, inverts="position"), (), []
        for _ in range(4_000):
            blocked = Percept(joint="B", outcome="blocked", positions=(False, False, False))
            told = channel.perceive(blocked, past, TASK, rng)
            false += [told.positions != past[-1].told.positions] if past else []
            past = (Moment(was=blocked, told=told),)
        assert np.mean(false) == pytest.approx(share, abs=0.03)


@pytest.mark.parametrize("agent", ["random", "random-no-repeat", "round-robin"])
def test_an_agent_that_ignores_reports_chooses_the_same_under_every_reading(agent):
    assert len({tuple(played(like, agent=agent, modality=STATES).actions) for like in [*LIKE, NOISY]}) == 1
    parts = [*PARTS, OutcomeFlip(only="moved"), OutcomeFlip(only="blocked")]
    conditions = [*([replace(like, p=0.5)] for like in parts), [Phantom(p=0.5)]]
    given_ = {"agent": agent, "box": "chain-8", "seed": 1, "max_steps": 40, "modality": "symbolic"}
    trials = [run_trial(condition=condition, **given_) for condition in conditions]
    truth = played(LIKE[0], agent=agent, p=0.0, modality=STATES)
    assert {tuple(trial.actions) for trial in trials} == {tuple(truth.actions)}
    assert len({str([(step.told_moved, step.told_state) for step in trial.steps]) for trial in trials}) > 4


def test_positions_that_survive_at_a_smaller_keep_are_a_subset_of_those_at_a_larger():
    told = [
        told_errors(played(OutcomeFlip(inverts="position", keep=keep), modality="symbolic"))
        for keep in (0, 0.3, 0.6, 0.9, 1)
    ]
    for fewer, more in itertools.pairwise(told):
        assert all(b or not a for low, high in zip(fewer, more, strict=True) for a, b in zip(low, high, strict=True))
    assert len({str(one) for one in told}) == 5


def test_a_false_position_survives_with_probability_keep_and_independently_of_other_joints():
    rng, flip = np.random.default_rng(5), OutcomeFlip(p=0.5, keep=0.3)
    truth = Percept(joint="B", outcome="blocked", positions=(False, False, False))
    past = (Moment(was=truth, told=Percept(joint="A", outcome="moved", positions=(True, False, True))),)
    told = np.array([flip.perceive(truth, past, TASK, rng).positions for _ in range(20_000)])
    assert told.mean(axis=0) == pytest.approx([0.3, 0.5, 0.3], abs=0.014)
    assert np.corrcoef(told.T.astype(float)) == pytest.approx(np.eye(3), abs=0.03)


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
    ],
)
def test_every_flip_has_one_spec_and_a_name(spec, canonical, reading):
    (flip,) = interventions_of(spec)
    assert (spec_of(flip), flip.reading) == (canonical, reading)
    assert interventions_of(canonical) == (flip,)
    assert READINGS[flip.inverts, flip.others] in reading


def test_a_part_has_a_name_of_its_own():
    assert OutcomeFlip(part="outcome").reading == "outcome noise with true positions"
    assert OutcomeFlip(part="position", inverts="position").reading == "memoryless state noise with true outcomes"


@given(st.integers(0, 10_000), st.floats(0, 1), st.floats(0, 1))
def test_the_flips_at_a_smaller_p_are_a_subset_of_those_at_a_larger(seed, one, other):
    low, high = sorted((one, other))

    def flips(p):
        rng = np.random.default_rng(seed)
        channel = OutcomeFlip(p=p)
        return [channel.perceive(TRUTH, (), TASK, rng).outcome == "blocked" for _ in range(20)]

    assert all(not at_low or at_high for at_low, at_high in zip(flips(low), flips(high), strict=True))


def test_it_draws_equally_often_whatever_its_parameters():
    after = set()
    for channel in [like.at_rate(p) for like in [*LIKE, NOISY, *PARTS] for p in (0.0, 0.3, 1.0)]:
        rng = np.random.default_rng(1)
        past = ()
        for _ in range(7):
            past = (*past, Moment(was=TRUTH, told=channel.perceive(TRUTH, past, TASK, rng)))
        after.add(rng.random())
    assert len(after) == 1


def test_its_rate_is_p():
    rng = np.random.default_rng(7)
    channel = OutcomeFlip(p=0.3)
    n = 20_000
    flipped = sum(channel.perceive(TRUTH, (), TASK, rng).outcome == "blocked" for _ in range(n))
    assert abs(flipped / n - 0.3) < 4 * (0.3 * 0.7 / n) ** 0.5


def test_bad_settings_are_named():
    with pytest.raises(BadValue, match=r"^flip rate p: got 1.2, expected a number from 0 to 1$"):
        OutcomeFlip(p=1.2)
    with pytest.raises(BadValue, match=r"^flip rate p: got nan"):
        OutcomeFlip(p=float("nan"))
    with pytest.raises(BadValue, match="^inverts: got 'both', expected one of position, outcome$"):
        OutcomeFlip(p=0.2, inverts="both")
    with pytest.raises(BadValue, match=r"^keep: got 2, expected a number from 0 to 1$"):
        OutcomeFlip(p=0.2, keep=2)
    with pytest.raises(BadValue, match=r"^others: got 'kept', expected none with keep=0.5, which says it already$"):
        OutcomeFlip(p=0.2, keep=0.5, others="kept")
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
    assert lies("flip?p=0.5&from=5", seed=3)[0] == {step for step in every if step >= 5}
    assert lies("flip?p=0.5&until=9", seed=3)[0] == {step for step in every if step <= 9}
    assert lies("flip?p=0.5&from=5&until=9", seed=3)[0] == {step for step in every if 5 <= step <= 9}
    assert lies("flip?p=0.5&at=4;8;11", seed=3)[0] == every & {4, 8, 11}


@pytest.mark.parametrize("seed", range(1, 9))
def test_while_looping_every_report_is_true_until_the_first_loop_is_complete(seed):
    every, trial = lies("flip?p=1&while=looping", agent="random", seed=seed)
    first = onset(trial.actions) or None
    assert min(every, default=None) == first
    for step in range(1, len(trial.steps) + 1):
        before, last = trial.actions[: max(step - 3, 0)], trial.actions[max(step - 3, 0) : step]
        assert (step in every) == any(before[i : i + 3] == last for i in range(len(before) - 2))


def test_every_option_is_in_the_record():
    plain, set_ = (lies(spec)[1].channels[0] for spec in ("flip?p=0.4", "flip?p=0.4&from=2&at=4;8&while=looping"))
    acting = {"channel": "OutcomeFlip", "p": 0.4, "inverts": "outcome", "others": "fresh", "keep": 0.0, "part": "both"}
    assert plain == acting | {"only": "any", "from": None, "until": None, "at": "", "while": "always"}
    assert set_ == {**plain, "from": 2, "at": "4;8", "while": "looping"}


def test_the_draws_are_as_many_whatever_the_options():
    after = set()
    for spec in ("flip?p=1", "flip?p=1&only=moved", "flip?p=1&at=4", "flip?p=1&from=9", "flip?p=1&while=looping"):
        (channel,) = interventions_of(spec)
        rng = np.random.default_rng(1)
        for _ in range(7):
            channel.perceive(TRUTH, (Moment(was=TRUTH, told=TRUTH),), TASK, rng)
        after.add(rng.random())
        assert interventions_of(spec_of(channel)) == (channel,)
    assert len(after) == 1


def test_a_report_that_says_nothing_is_not_inverted():
    silent = Percept(joint="B")
    assert tell(OutcomeFlip(p=1.0), silent) == silent


@pytest.mark.parametrize(
    ("spec", "said"),
    [
        ("flip?only=true", "only: got 'true', expected one of moved, blocked, any"),
        ("flip?while=lost", "while: got 'lost', expected one of looping, always"),
        ("flip?from=0", "from: got 0, expected a step from 1"),
        ("flip?at=4;0", "at: got 0, expected a step from 1"),
        ("flip?at=4;x", "at: got 'x', expected a whole number"),
        ("flip?from=5&until=4", "until: got 4, expected a step from 5, the first step of the flip"),
        ("flip?part=none", "part: got 'none', expected one of both, outcome, position"),
        ("flip?part=outcome&keep=1", "part: got 'outcome', expected none with inverts, others or keep"),
        (
            "flip?others=noisy",
            "others: got 'noisy', expected inverts=position with it, and no keep, part, only or while",
        ),
        ("flip?inverts=position&others=noisy&keep=1", "others: got 'noisy', expected inverts=position with it"),
        ("flip?from_=5", "no option of flip is called 'from_'"),
    ],
)
def test_bad_options_are_named_as_users_call_them(spec, said):
    with pytest.raises(UserMistake, match=f"^{re.escape(said)}"):
        interventions_of(spec)
