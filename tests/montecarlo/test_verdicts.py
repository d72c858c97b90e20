"""Studies drawn from a pool conclude what whole studies conclude."""

import numpy as np
import pytest

from lockprobe.analysis.series import SeriesArm
from lockprobe.analysis.why import verdict_of, why
from lockprobe.errors import BadValue
from lockprobe.montecarlo.blocks import Played, played_blocks
from lockprobe.montecarlo.verdicts import MECHANISMS, STATED, stated_rates, verdict_rates
from lockprobe.spec import Spec
from lockprobe.studies.single import run_trial
from lockprobe.studies.studyfile import study


def test_the_pool_is_the_trials_of_a_study_and_its_verdict_that_of_the_report():
    planned = study("why", agent="world:loop-breaker", trials=30, repetitions=1, seed=5)
    arms = [one for one in planned.conditions if one.name in ("truth", "lie", "retracted")]
    trials = {
        one.name: [run_trial(agent="world:loop-breaker", condition=one, trial=i, seed=5) for i in range(1, 31)]
        for one in arms
    }
    (pool,) = played_blocks([Played(study=planned, agent="world:loop-breaker", conditions=tuple(arms))], 30)
    assert pool.tolist() == np.transpose([[trial.solved for trial in trials[one.name]] for one in arms]).tolist()
    found = why(
        trials,
        [SeriesArm(label=one.label, specs=tuple(map(Spec.parse, one.specs)), doses=one.dose_names) for one in arms],
    )
    assert verdict_of(*pool.T.astype(float)) == found.verdict


def test_nulls_are_told_and_counts_are_complete():
    (rates,) = verdict_rates(["world:lost-half"], blocks=[20], studies=7, pool=20)
    assert (rates.world, rates.truth, rates.blocks) == ("world:lost-half", "no change", 20)
    assert sum(rates.verdicts.values()) == 7
    assert rates.right + rates.wrong <= 1


@pytest.mark.parametrize(
    ("given", "said"), [({"pool": 10}, "pool"), ({"blocks": [1]}, "blocks"), ({"studies": 0}, "studies")]
)
def test_numbers_that_are_too_small_are_refused(given, said):
    with pytest.raises(BadValue, match=said):
        verdict_rates(["world:irrelevant"], **given)


def test_every_world_has_its_mechanism():
    from lockprobe.agents.worlds import WORLDS

    assert set(MECHANISMS) == {f"world:{name}" for name in WORLDS}


def test_stated_effects_are_told_and_chance_errors_keep_to_their_level():
    """With arms that share no luck the sentence errs in at most 5 % of studies, three standard errors aside."""
    for name, shares in STATED.items():
        small, large = stated_rates(name, shares, blocks=[20, 400], studies=100)
        assert small.right <= large.right + 0.1
        assert max(small.wrong, large.wrong) <= 0.05 + 3 * (0.05 * 0.95 / 100) ** 0.5
        if small.truth != "no change":
            assert large.right > 0.85
    (mixed,) = stated_rates("mixed", (0.2, 0.8, 0.5), blocks=[200], studies=10)
    assert (mixed.truth, mixed.right) == ("both", 1.0)


@pytest.mark.parametrize(("shares", "blocks"), [((0.2, 0.5), [50]), ((0.2, 0.5, 1.5), [50]), ((0.2, 0.5, 0.5), [1])])
def test_effects_that_are_none_are_refused(shares, blocks):
    with pytest.raises(BadValue):
        stated_rates("x", shares, blocks=blocks)
