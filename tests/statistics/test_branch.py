"""Where trials are forked, and the effect of an arm there: pairs within trials, places that all trials have."""

from dataclasses import replace

import pytest

import lockprobe
from lockprobe.statistics.branch import branch_effects, fork_steps
from lockprobe.statistics.loops import onset
from lockprobe.trial.record import ForkName


def trial(number=1, agent="cognitive:insistent", p=0.0):
    one = lockprobe.run_trial(agent=agent, p=p, trial=number, seed=3)
    one = replace(one, study="flips")
    return replace(one, key=str(one.name))


def fork(parent, arm, *, solved, at=4, time=1, following=""):
    """A fork that ends as it is told to, with the parent's steps but for the next joint."""
    steps = list(parent.steps)
    if following:
        steps[at] = replace(steps[at], joint=following)
    name = ForkName(parent=parent.key, at=at, arm=arm, time=time)
    return replace(parent, key=str(name), fork=name, steps=tuple(steps), ending="solved" if solved else "budget")


def effects_of(forks, parents, *more, **asked):
    return branch_effects(forks, {parent.key: parent for parent in parents}, *more, **asked)


def only(effects, outcome="success"):
    (found,) = [one for one in effects if one.outcome == outcome]
    return found


def on_success(effects, by="arm"):
    return {getattr(one, by): one for one in effects if one.outcome == "success"}


def test_a_place_is_one_after_which_the_trial_goes_on():
    one = trial()
    last = len(one.steps)
    assert fork_steps(one, "4") == (4,)
    assert fork_steps(one, str(last)) == ()
    assert fork_steps(one, "every") == tuple(range(1, last))
    assert fork_steps(one, "onset") == (onset(one.actions),)
    assert fork_steps(one, "first-lie") == ()


def test_continuations_are_paired_and_a_trial_counts_once():
    """Two trials, two continuations: +1 and 0 in the first, +1 and +1 in the second."""
    parents = [trial(1), trial(2)]
    forks = []
    for parent, ends in zip(parents, [((0, 1), (1, 1)), ((0, 1), (0, 1))], strict=True):
        for time, (told, lied) in enumerate(ends, 1):
            forks += [fork(parent, "truth", solved=told, time=time), fork(parent, "lie", solved=lied, time=time)]
    found = only(effects_of(forks, parents))
    assert (found.where, found.arm, found.change.n, found.change.clusters) == ("4", "lie", 4, 2)
    assert (found.after_truth, found.change.value) == (0.25, 0.75)


def test_outcomes_of_the_next_action():
    parents, forks = [trial(1), trial(2)], []
    for parent in parents:
        last = parent.steps[3].joint
        other = next(joint for joint in parent.joints if joint != last)
        forks += [fork(parent, arm, solved=False, following=to) for arm, to in (("truth", last), ("lie", other))]
    effects = effects_of(forks, parents, ["4"])
    again = only(effects, "repeats")
    assert (again.after_truth, again.change.value) == (1.0, -1.0)
    assert only(effects, "steps").change.value == 0


def test_effects_on_several_agents_are_one_family_and_those_on_baselines_another():
    """P values are multiplied and intervals are those of the divided level, as of no other agent."""

    def found(*agents):
        parents = [trial(number, agent=agent) for agent in agents for number in range(1, 13)]
        arms = (("truth", 0), ("lie", 11))
        forks = [fork(one, arm, solved=i % 12 < n) for arm, n in arms for i, one in enumerate(parents)]
        return on_success(effects_of(forks, parents), "agent")

    first, second, baseline = "cognitive:insistent", "cognitive:careful", "random"
    alone, several = found(first)[first], found(first, second, baseline)
    assert [several[agent].agents for agent in (first, second, baseline)] == [2, 2, 1]
    assert several[first].change.p_value == pytest.approx(2 * alone.change.p_value)
    assert several[first].change.low < alone.change.low
    assert found(first, baseline)[first] == alone
