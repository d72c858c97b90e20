"""Actions judged by ideal observers: by hand, by identity and against chance."""

from dataclasses import replace
from math import log2

import numpy as np
import pytest
from builders import make_trial
from clumsy import HAND

from lockprobe import run_trial
from lockprobe.agents.ideal_observer import IdealObserver
from lockprobe.boxes.beliefs.structures import interlocks
from lockprobe.boxes.families import box
from lockprobe.foundation.errors import BadValue, UnknownName
from lockprobe.statistics import rationality as module
from lockprobe.statistics.rationality import JUDGED, judge, prior_for, rationality
from lockprobe.statistics.rules import unbroken
from lockprobe.testing import play_trials

FLIPS = ("re-observed", "integrated", "outcome-only")


def played(agent, n, p=0.0, **settings):
    return [run_trial(agent=agent, p=p, trial=i, seed=4, **settings) for i in range(1, n + 1)]


def steps(trial, noise="naive", prior="single-parent"):
    return judge(trial, prior=prior, noise=noise).steps


def test_first_steps_by_hand():
    """142 interlocks, 64 with a free target: it is best tried first, for 483/142 steps; another joint costs 28/142 more."""
    target, other = (steps(make_trial([joint]))[0] for joint in (0, 3))
    assert target.entropy == other.entropy == pytest.approx(log2(142))
    assert (target.optimal, target.regret) == (True, 0.0)
    assert (other.optimal, other.regret) == (False, pytest.approx(28 / 142))
    assert target.gained == pytest.approx(log2(142 / 78))
    share = 64 / 142
    assert target.expected == pytest.approx(-share * log2(share) - (1 - share) * log2(1 - share))
    assert target.by_chance["optimal"] == 1 / 4
    assert target.by_chance["regret"] == pytest.approx(3 / 4 * 28 / 142)
    assert target.by_chance["uninformative"] == 0


def test_the_same_failure_again_costs_a_step_and_tells_nothing():
    again = steps(make_trial([0, 0]))[1]
    assert (again.regret, again.expected, again.gained) == (pytest.approx(1), 0, 0)
    assert again.uninformative
    assert not again.optimal


def test_to_one_who_doubts_a_check_may_tell_something():
    check = steps(make_trial([1, 1]), "0.3")[1]
    assert check.expected > 0.05
    assert not check.uninformative
    assert steps(make_trial([1, 1]), "naive")[1].uninformative


def test_a_known_chain_is_opened_without_loss():
    """Under the prior of chains the joints are tried in an order that cannot be wasted."""
    found = judge(make_trial([3, 2, 1, 0]), prior="chains", noise="naive")
    assert all(step.optimal for step in found.steps)
    assert [step.gained for step in found.steps] == pytest.approx([log2(3), 1, 0, 0])
    assert found.entropy_left == 0
    assert [step.uninformative for step in found.steps] == [False, False, True, False]


@pytest.mark.parametrize("flip", FLIPS)
@pytest.mark.parametrize("noise", ["naive", "aware"])
def test_an_ideal_observer_is_optimal_to_itself(flip, noise):
    for trial in played(IdealObserver(noise=noise), 12, p=0.3, flip=flip):
        for step in steps(trial, noise):
            assert step.optimal
            assert step.regret == pytest.approx(0, abs=1e-9)


@pytest.mark.parametrize("noise", ["naive", "aware", "0.3"])
def test_what_is_gained_adds_up(noise):
    for flip in FLIPS:
        for trial in played("random", 8, p=0.3, flip=flip):
            found = judge(trial, prior="single-parent", noise=noise)
            assert sum(step.gained for step in found.steps) == pytest.approx(log2(142) - found.entropy_left)
            for step in found.steps:
                assert 0 <= step.expected <= step.best <= step.entropy + 1e-9
                assert 0 <= step.by_chance["expected"] <= step.best + 1e-12
                assert step.regret >= 0
                assert step.optimal == (step.regret < 1e-9)


@pytest.mark.parametrize("noise", ["naive", "aware"])
def test_a_random_agent_is_as_rational_as_chance(noise):
    found = [step for trial in played("random", 40, p=0.3) for step in steps(trial, noise)]
    for name in ("optimal", "regret", "uninformative", "expected"):
        beyond = np.array([getattr(step, name) - step.by_chance[name] for step in found])
        assert beyond.std() > 0.1
        assert abs(beyond.mean()) < 4 * beyond.std() / len(found) ** 0.5


def test_gained_bits_are_those_expected_when_the_truth_is_drawn_from_the_prior_of_one_who_doubts():
    """On one box they may differ; told the truth on chains under their own prior they agree on average over labels."""
    found = [step for trial in played("random-no-repeat", 100) for step in steps(trial, "naive", "chains")]
    beyond = np.array([step.gained - step.expected for step in found])
    assert abs(beyond.mean()) < 4 * beyond.std() / len(found) ** 0.5


def test_the_panel_may_be_laid_out_in_any_order():
    for trial in played("random", 5, p=0.3):
        turned = replace(
            trial,
            joints=trial.joints[::-1],
            steps=tuple(replace(s, state=s.state[::-1], told_state=s.told_state[::-1]) for s in trial.steps),
        )
        for noise in ("naive", "aware"):
            assert judge(turned, prior="single-parent", noise=noise) == judge(trial, prior="single-parent", noise=noise)


def test_one_condition_is_the_mean_of_its_actions():
    trials = played("human-inspired", 6, p=0.3)
    for found in rationality([*trials, make_trial([1], broken="model")]):
        every = [step for trial in trials for step in steps(trial, found.noise)]
        assert (found.trials, found.steps, found.not_judged) == (6, len(every), 0)
        assert found.optimal.value == pytest.approx(np.mean([step.optimal for step in every]))
        assert found.optimal.clusters == 6
        assert found.regret.value == pytest.approx(np.mean([step.regret for step in every]))
        assert found.regret.low <= found.regret.value <= found.regret.high
        assert found.best == pytest.approx(np.mean([step.best for step in every]))
        assert found.by_chance["optimal"] == pytest.approx(np.mean([step.by_chance["optimal"] for step in every]))
        assert (found.prior, found.interlocks) == ("single-parent", 142)


def test_one_who_believes_reports_is_confused_by_false_ones_and_one_who_doubts_is_not():
    for flip in FLIPS:
        naive, aware = rationality(played("round-robin", 20, p=0.4, flip=flip))
        assert naive.restarts > 0.5
        assert aware.restarts == 0
        assert naive.gained < naive.expected - 0.1
    assert rationality(played("round-robin", 20))[0].restarts == 0


def test_a_box_with_two_conditions_on_a_joint_contradicts_the_prior():
    """Told the truth of a box whose target needs two joints open, the observer has to begin again."""
    first, second, third = make_trial([1, 2, 3]).steps
    told = [
        replace(first, moved=True, told_moved=True, told_state="0100", state="0000"),
        replace(second, joint=first.joint, moved=True, told_moved=True, told_state="0000", state="0100"),
        replace(third, joint=first.joint, moved=False, told_moved=False, told_state="0000", state="0000"),
    ]
    found = judge(replace(make_trial([1]), steps=tuple(told)), prior="single-parent", noise="naive")
    assert found.restarts == 1


def test_only_so_many_trials_are_judged(monkeypatch):
    trials = [make_trial([0, 1], trial=i) for i in range(1, JUDGED + 4)]
    assert [(found.trials, found.not_judged) for found in rationality(trials)] == [(JUDGED, 3)] * 2
    monkeypatch.setattr(module, "ACTIONS", 5)
    assert [(found.trials, found.steps) for found in rationality(trials)] == [(3, 6)] * 2


def test_boxes_have_their_prior_or_are_not_judged():
    assert [prior_for(joints) for joints in range(2, 9)] == ["single-parent"] * 3 + ["chains"] * 2 + [None] * 2
    assert {found.prior for found in rationality(played("random", 2, box="chain-5"))} == {"chains"}
    assert rationality(played("random", 2, box="chain-7")) == ()
    assert rationality([make_trial([], broken="model")]) == ()
    assert rationality([]) == ()


def test_equal_trials_give_equal_numbers():
    trials = played("random", 5, p=0.2)
    assert rationality(trials) == rationality(trials)


def test_what_does_not_exist_is_refused():
    with pytest.raises(UnknownName, match="no prior is called 'any'"):
        judge(make_trial([0]), prior="any")
    with pytest.raises(BadValue, match="noise: got 'some'"):
        judge(make_trial([0]), prior="chains", noise="some")


def values_of(known):
    """Expected steps of every set of interlocks and configuration, by sweeps; what a missed joint says is not known."""
    alive = frozenset(np.flatnonzero(known.distance[:, 0] < 255).tolist())
    ways, queue = {}, [(alive, 0)]
    while queue:
        there, here = state = queue.pop()
        if state in ways:
            continue
        ways[state] = []
        for joint in range(known.joints):
            moved = frozenset(s for s in there if known.masks[here][joint] >> s & 1)
            parts = [(moved, (moved, here ^ 1 << joint) if joint else None), (there - moved, (there - moved, here))]
            ways[state].append([(len(part) / len(there), then) for part, then in parts if part])
            queue += [then for part, then in parts if part and then is not None]
    values = dict.fromkeys(ways, 0.0)
    for _ in range(60):
        values = {state: min(_costs(found, values)) for state, found in ways.items()}
    return {state: _costs(found, values) for state, found in ways.items()}


def _costs(ways, values):
    return [1 + sum(share * (values[then] if then else 0.0) for share, then in way) for way in ways]


def test_actions_before_a_broken_rule_are_judged_as_by_enumeration_and_none_after_it():
    plain, known = box("chain-3"), interlocks("single-parent", 3)
    values = values_of(known)
    trials = play_trials("random", 8, box="chain-3", plant=f"{HAND}?misses=1;3;5&forces=4")
    firsts = [unbroken(trial, plain) for trial in trials]
    assert {0, 2} < {*firsts}
    left, optimal, lost = [], 0, 0.0
    for trial, first in zip(trials, firsts, strict=True):
        numbers = {joint: i for i, joint in enumerate(dict.fromkeys((trial.target, *trial.actions, *trial.joints)))}
        alive, here = frozenset(range(len(known))), 0
        for step in trial.steps[:first]:
            joint, costs = numbers[step.joint], values[alive, here]
            optimal += costs[joint] < min(costs) + 1e-9
            lost += costs[joint] - min(costs)
            alive = frozenset(s for s in alive if (known.masks[here][joint] >> s & 1) == step.moved)
            here ^= step.moved << joint
        left += [log2(len(alive))] * (first > 0)
    naive, _ = rationality(trials, plain)
    assert (naive.trials, naive.steps) == (len(left), sum(firsts))
    assert naive.left_out == sum(len(trial.steps) for trial in trials) - sum(firsts)
    assert (naive.optimal.count, naive.regret.value * naive.steps) == (optimal, pytest.approx(lost))
    assert (naive.entropy_left, naive.restarts) == (pytest.approx(np.mean(left)), 0)
    assert rationality(trials)[0].restarts > 0  # what they were told of these attempts no interlock explains


def test_without_a_judged_action_there_is_nothing_and_without_a_broken_rule_all_is_judged():
    assert rationality(play_trials("random", 2, plant=f"{HAND}?forces=1&knocks=1"), box()) == ()
    kept = played("human-inspired", 3)
    assert rationality(kept, box()) == rationality(kept)
    assert rationality(kept)[0].left_out == 0
