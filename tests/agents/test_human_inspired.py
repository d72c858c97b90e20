"""The human-inspired strategy and its relatives, by published figures and by their rules."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lockprobe import propagate, run_trial
from lockprobe.agents.catalogue import resolve
from lockprobe.agents.human_inspired import PRESETS, HumanInspired
from lockprobe.agents.policy import Told, View
from lockprobe.foundation.errors import BadValue


def play(agent, n, p=0.0, **settings):
    return [run_trial(agent=agent, p=p, trial=i, seed=3, **settings) for i in range(1, n + 1)]


@pytest.mark.parametrize("flip", ["transient", "sticky", "outcome-only"])
def test_noise_only_hurts_the_human_inspired_strategy(flip):
    courses = [propagate("human-inspired", p=p, flip=flip) for p in (0.0, 0.3, 0.6)]
    shares = [course.success for course in courses]
    nines = [course.solved[9] for course in courses]
    assert shares == sorted(shares, reverse=True)
    assert nines[0] > nines[1] > nines[2]
    assert shares[2] < 0.9


def test_human_inspired_never_retries_a_failed_joint_before_a_perceived_move():
    for trial in play("human-inspired", 30, p=0.3):
        failed = set()
        for step in trial.steps:
            if len(failed) < len(trial.joints):
                assert step.joint not in failed
            if step.told_moved:
                failed.clear()
            else:
                failed.add(step.joint)


def test_strategies_say_what_they_were_told():
    for trial in play("human-inspired", 20, p=0.5):
        for before, step in zip(trial.steps, trial.steps[1:], strict=False):
            assert step.decision.claimed == ("moved" if before.told_moved else "blocked")
        assert trial.steps[0].decision.claimed is None


@pytest.mark.parametrize(
    ("preset", "mean", "eighty", "last"),
    [("target-first", 8.5, 9, 10), ("target-last", 5.5, 6, 7), ("target-any", 7.0, 8, 10), ("proximity", 5.5, 7, 7)],
)
def test_presets_have_their_figures_on_chain_4(preset, mean, eighty, last):
    """Mean steps, 80 % by, all by, when told the truth."""
    course = propagate(f"human-inspired:{preset}")
    assert (course.by(0.8), course.by(1)) == (eighty, last)
    assert course.steps == pytest.approx(mean)


def told(joint, moved, shifted=None):
    return Told(joint=joint, moved=moved, shifted=shifted)


def after(agent, view, *reports):
    memory = agent.begin(view)
    for report in reports:
        memory = agent.remember(view, memory, report)
    return list(agent.choices(view, memory))


FOUR = View(joints=4, target=0)


def test_target_last_leaves_the_target_for_when_nothing_else_is_left():
    agent = HumanInspired(target="last")
    assert after(agent, FOUR) == [1, 2, 3]
    assert after(agent, FOUR, told(1, False), told(3, False)) == [2]
    assert after(agent, FOUR, told(1, False), told(3, False), told(2, False)) == [0]
    assert after(agent, FOUR, *(told(j, False) for j in (1, 3, 2, 0))) == [0, 1, 2, 3]


def test_proximity_goes_to_the_nearest_that_has_neither_moved_nor_failed():
    agent = HumanInspired(target="any", nearest=True)
    view = View(joints=4, target=0, places=((0.0, 0.5), (0.3, 0.5), (0.5, 0.5), (0.6, 0.5)))
    assert after(agent, view) == [0, 1, 2, 3]
    assert after(agent, view, told(2, False)) == [0, 1, 3]
    assert after(agent, view, told(2, True)) == [3]
    assert after(agent, view, told(2, True), told(3, False)) == [1]
    assert after(agent, view, told(2, True), told(3, True)) == [1]
    both = View(joints=3, target=0, places=((0.2, 0.5), (0.4, 0.5), (0.6, 0.5)))
    assert after(agent, both, told(1, True)) == [0, 2]


def test_memory_per_configuration_lasts_until_the_configuration_comes_again():
    agent = HumanInspired(target="any", memory="configuration", spare="moved")
    assert after(agent, FOUR, told(1, False, 0)) == [0, 2, 3]
    assert after(agent, FOUR, told(1, False, 0), told(2, True, 0b100)) == [0, 1, 3]
    back = (told(1, False, 0), told(2, True, 0b100), told(2, True, 0))
    assert after(agent, FOUR, *back) == [0, 3]
    assert after(agent, FOUR, *back, told(0, False, 0), told(3, False, 0)) == [0, 1, 2, 3]


def test_the_joint_that_moved_last_is_left_for_later_while_others_fail():
    agent = HumanInspired(target="any", memory="configuration", spare="moved")
    reports = [told(2, True, 0b100), told(0, False, 0b100)]
    assert after(agent, FOUR, *reports) == [1, 3]
    reports += [told(1, False, 0b100), told(3, False, 0b100)]
    assert after(agent, FOUR, *reports) == [2]


@settings(max_examples=60, deadline=None)
@given(
    preset=st.sampled_from(list(PRESETS)),
    lapse=st.sampled_from([0.0, 0.3, 1.0]),
    reports=st.lists(st.tuples(st.integers(0, 4), st.booleans()), max_size=12),
)
def test_choices_are_never_empty_and_probabilities_are_of_them(preset, lapse, reports):
    agent = HumanInspired(**PRESETS[preset], lapse=lapse)
    view = View(joints=5, target=2, places=tuple((i / 5, 0.5) for i in range(5)))
    memory = agent.begin(view)
    for joint, moved in reports:
        memory = agent.remember(view, memory, told(joint, moved))
    choices = agent.choices(view, memory)
    assert choices
    shares = agent.probabilities(view, memory)
    assert sum(shares) == pytest.approx(1)
    for joint in range(5):
        assert shares[joint] == pytest.approx(lapse / 5 + (1 - lapse) * (joint in choices) / len(choices))


def test_its_parameters_are_on_record_except_for_the_default():
    assert run_trial(agent="human-inspired").facts == {}
    assert run_trial(agent="human-inspired:target-last").facts["target"] == "last"


def test_a_lapse_is_a_probability():
    with pytest.raises(BadValue, match=r"^lapse: got 1.5, expected a number from 0 to 1$"):
        resolve("human-inspired?lapse=1.5")
    with pytest.raises(BadValue, match=r"^lapse: got nan"):
        resolve("human-inspired?lapse=nan")
