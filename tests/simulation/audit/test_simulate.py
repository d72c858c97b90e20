"""Simulated agents are as their world says."""

from dataclasses import fields, replace
from itertools import pairwise

import numpy as np
import pytest

from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.seeds import generator
from lockprobe.simulation.audit.simulate import BUDGET, simulate, simulate_columns, simulate_outcomes, simulate_study
from lockprobe.simulation.audit.simulated_agents import WORLDS, Design
from lockprobe.statistics.outcomes import broken_off, outcomes
from lockprobe.trial.trial_json import trial_from_json, trial_to_json

LARGE = Design(repetitions=1, trials=3000)


@pytest.mark.parametrize("name", WORLDS)
def test_records_are_possible_and_say_what_the_columns_say(name):
    made = WORLDS[name]
    design = made.design
    trials = simulate(made, design, generator(1, name))
    planned = len(design.p) * design.clusters
    assert len(trials) == len({trial.key for trial in trials})
    assert 0.3 * planned < len(trials) < planned if made.leaves else len(trials) == planned
    for trial in trials:
        assert trial_from_json(trial_to_json(trial)) == trial
        assert (
            all(a != b for a, b in zip(trial.actions, trial.actions[1:], strict=False))
            or made.trap[0]
            or made.lost
            or made.repeats
        )
    columns = simulate_columns(made, design, generator(1, name))
    for read, drawn in zip((outcomes(trials), broken_off(trials)), columns, strict=True):
        for field in fields(read):
            assert np.array_equal(getattr(read, field.name), getattr(drawn, field.name))


AS_STATED = [
    n for n, made in WORLDS.items() if made.harm == 1 and not (made.lost or made.people or made.breaks or made.slow)
]


@pytest.mark.parametrize("name", AS_STATED)
def test_where_loops_are_irrelevant_success_is_as_stated(name):
    design = replace(LARGE, p=WORLDS[name].design.p)
    drawn = simulate_outcomes(WORLDS[name], design, generator(2, name))
    for p, stated in zip(design.p, WORLDS[name].success, strict=True):
        share = drawn.solved[drawn.dose == p].mean()
        assert abs(share - stated) < 4 * (stated * (1 - stated) / LARGE.clusters) ** 0.5
    assert drawn.length[drawn.solved].min() == 4
    assert set(drawn.length[~drawn.solved]) == {BUDGET}


def test_loops_keep_the_trapped_agent_from_solving_and_noise_frees_it():
    made = WORLDS["loop-trapped"]
    drawn = simulate_outcomes(made, LARGE, generator(3))
    free = simulate_outcomes(replace(made, harm=1.0), LARGE, generator(3))
    solved, looped = [[values[drawn.dose == p].mean() for p in LARGE.p] for values in (drawn.solved, drawn.looped)]
    assert solved[0] < 0.5
    assert solved[-1] > 0.62
    assert looped[0] > 0.6
    assert looped[-1] < 0.5
    assert np.allclose([free.solved[free.dose == p].mean() for p in LARGE.p], made.success, atol=0.03)


def test_an_agent_that_is_lost_both_loops_and_fails_whatever_p_is():
    drawn = simulate_outcomes(WORLDS["lost-half"], LARGE, generator(5))
    for p in LARGE.p:
        assert abs(drawn.solved[drawn.dose == p].mean() - (0.9 + 0.2) / 2) < 0.04
    assert drawn.looped[~drawn.solved].mean() > drawn.looped[drawn.solved].mean() + 0.3


def test_where_actions_may_repeat_they_are_uniform():
    trials = simulate(WORLDS["uniform"], Design(repetitions=1, trials=300), generator(9))
    again = [a == b for trial in trials for a, b in pairwise(trial.actions)]
    assert abs(np.mean(again) - 0.25) < 4 * (0.25 * 0.75 / len(again)) ** 0.5


def test_the_records_of_the_lowest_p_are_those_of_the_study():
    made = WORLDS["loop-trapped"]
    *_, lowest = simulate_study(made, made.design, generator(1))
    assert lowest == [trial for trial in simulate(made, made.design, generator(1)) if trial.p == 0]


def test_shared_luck_makes_a_share_of_trials_alike_at_every_p():
    drawn = simulate_outcomes(WORLDS["shared-luck"], LARGE, generator(4))
    onsets = drawn.onset.reshape(len(LARGE.p), -1)
    lengths = drawn.length.reshape(len(LARGE.p), -1)
    alike = ((onsets == onsets[0]) & (lengths == lengths[0])).all(axis=0)
    assert abs(alike.mean() - 0.5) < 0.04


def test_unequal_luck_is_one_luck_for_all_p_but_the_lowest():
    drawn = simulate_outcomes(WORLDS["unequal-luck"], LARGE, generator(6))
    solved = drawn.solved.reshape(len(LARGE.p), -1)
    assert (solved[1:] == solved[1]).all()
    assert abs(np.corrcoef(solved[0], solved[1])[0, 1]) < 0.06


def test_people_are_unequally_good_and_as_good_as_stated_on_average():
    made = replace(WORLDS["people"], people=1000)
    drawn = simulate_outcomes(made, LARGE, generator(7))
    assert abs(drawn.solved.mean() - 0.5) < 0.02
    assert len(set(drawn.player)) == 7000
    of_one = drawn.solved.reshape(7000, 3).mean(axis=1)
    assert of_one.var() > 1.5 * 0.25 / 3


def test_calls_that_fail_break_long_trials_under_one_condition():
    drawn, broken = simulate_columns(WORLDS["broken-trials"], LARGE, generator(8))
    assert set(broken.dose) == {0.6}
    assert 0.5 < len(broken) / LARGE.clusters < 0.75
    here = drawn.dose == 0.6
    assert drawn.solved[here].mean() > drawn.solved[~here].mean() + 0.15
    assert not broken.solved.any()
    assert broken.length.min() == 0


def test_equal_seeds_give_equal_studies_and_others_do_not():
    first, again, other = (simulate(WORLDS["no-effect"], Design(), generator(seed)) for seed in (1, 1, 2))
    assert first == again
    assert first != other


def test_designs_that_do_not_fit_are_refused():
    with pytest.raises(BadValue, match="one for each of 2 flip rates"):
        simulate(WORLDS["no-effect"], Design(p=(0.0, 0.4)), generator(1))


def test_skewed_steps_have_equal_means_and_rare_long_trials():
    drawn = simulate_outcomes(WORLDS["skewed-steps"], LARGE, generator(7))
    assert drawn.solved.all()
    for p in LARGE.p:
        steps = drawn.length[drawn.dose == p]
        assert steps.mean() == pytest.approx(6, abs=0.3)
        assert (steps == BUDGET).mean() == pytest.approx(0.05 * (p > 0), abs=0.02)


def test_those_who_leave_have_failed_last_and_the_able_stay():
    made = WORLDS["dropout"]
    drawn = simulate_outcomes(made, Design(repetitions=1, trials=600), generator(8))
    names, place = np.unique(drawn.player, return_inverse=True)
    last = np.array([np.flatnonzero(place == i)[-1] for i in range(len(names))])
    boxes = np.bincount(place)
    assert not drawn.solved[last][boxes < boxes.max()].any()
    assert drawn.solved.mean() > 0.55
    assert np.mean(np.bincount(place, drawn.solved) / boxes) < 0.48
