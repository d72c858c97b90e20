"""Simulated agents are as their world says."""

from dataclasses import fields, replace

import numpy as np
import pytest

from lockprobe.analysis.outcomes import outcomes
from lockprobe.audit.simulate import BUDGET, simulate, simulate_outcomes
from lockprobe.audit.worlds import WORLDS, Design, world
from lockprobe.errors import BadValue, UnknownName
from lockprobe.jsonline import trial_from_json, trial_to_json
from lockprobe.seeds import generator

LARGE = Design(repetitions=1, trials=3000)


@pytest.mark.parametrize("name", WORLDS)
def test_records_are_possible_and_say_what_the_columns_say(name):
    made = world(name)
    trials = simulate(made, Design(), generator(1, name))
    assert len(trials) == len({trial.key for trial in trials}) == 210
    for trial in trials:
        assert trial_from_json(trial_to_json(trial)) == trial
        assert all(a != b for a, b in zip(trial.actions, trial.actions[1:], strict=False)) or made.trap[0] or made.lost
    read, drawn = outcomes(trials), simulate_outcomes(world(name), Design(), generator(1, name))
    for field in fields(read):
        assert np.array_equal(getattr(read, field.name), getattr(drawn, field.name))


@pytest.mark.parametrize("name", [name for name, made in WORLDS.items() if made.harm == 1 and not made.lost])
def test_where_loops_are_irrelevant_success_is_as_stated(name):
    drawn = simulate_outcomes(WORLDS[name], LARGE, generator(2, name))
    for p, stated in zip(LARGE.p, WORLDS[name].success, strict=True):
        share = drawn.solved[drawn.p == p].mean()
        assert abs(share - stated) < 4 * (stated * (1 - stated) / LARGE.clusters) ** 0.5
    assert drawn.length[drawn.solved].min() == 4
    assert set(drawn.length[~drawn.solved]) == {BUDGET}


def test_loops_keep_the_trapped_agent_from_solving_and_noise_frees_it():
    made = WORLDS["loop-trapped"]
    drawn = simulate_outcomes(made, LARGE, generator(3))
    free = simulate_outcomes(replace(made, harm=1.0), LARGE, generator(3))
    solved, looped = [[values[drawn.p == p].mean() for p in LARGE.p] for values in (drawn.solved, drawn.looped)]
    assert solved[0] < 0.5
    assert solved[-1] > 0.62
    assert looped[0] > 0.6
    assert looped[-1] < 0.5
    assert np.allclose([free.solved[free.p == p].mean() for p in LARGE.p], made.success, atol=0.03)


def test_an_agent_that_is_lost_both_loops_and_fails_whatever_p_is():
    drawn = simulate_outcomes(WORLDS["lost-half"], LARGE, generator(5))
    for p in LARGE.p:
        assert abs(drawn.solved[drawn.p == p].mean() - (0.9 + 0.2) / 2) < 0.04
    assert drawn.looped[~drawn.solved].mean() > drawn.looped[drawn.solved].mean() + 0.3


def test_shared_luck_makes_a_share_of_trials_alike_at_every_p():
    drawn = simulate_outcomes(WORLDS["shared-luck"], LARGE, generator(4))
    onsets = drawn.onset.reshape(len(LARGE.p), -1)
    lengths = drawn.length.reshape(len(LARGE.p), -1)
    alike = ((onsets == onsets[0]) & (lengths == lengths[0])).all(axis=0)
    assert abs(alike.mean() - 0.5) < 0.04


def test_equal_seeds_give_equal_studies_and_others_do_not():
    first, again, other = (simulate(WORLDS["no-effect"], Design(), generator(seed)) for seed in (1, 1, 2))
    assert first == again
    assert first != other


def test_unknown_worlds_and_designs_that_do_not_fit_are_refused():
    with pytest.raises(UnknownName, match="no-effect"):
        world("no-efect")
    with pytest.raises(BadValue, match="one for each of 2 p"):
        simulate(WORLDS["no-effect"], Design(p=(0.0, 0.4)), generator(1))
