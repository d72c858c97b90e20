"""Prediction of trials that a model was not fitted to."""

from dataclasses import replace

import numpy as np
import pytest
from fitted_trials import flip_trials

from lockprobe.simulation.fit.candidate_models import RIVALS
from lockprobe.simulation.fit.choices import choices_of, hear
from lockprobe.simulation.fit.held_out import folds_of, held_out, predicted
from lockprobe.simulation.fit.likelihood import Lapse
from lockprobe.simulation.fit.optimise import maximum

TRIALS = flip_trials("cognitive:softmax-memory?position=1.5", seed=2, p=(0.0, 0.5), repetitions=2, trials=6)
HEARD = [hear(trial) for trial in TRIALS]
CHOICES = choices_of(TRIALS, HEARD)
FOLD = folds_of(CHOICES.cluster, 4)


def aside(choices, name):
    versions = RIVALS[name].versions(choices, HEARD)
    return held_out(versions, {key: maximum(model) for key, model in versions.items()}, FOLD, choices.present)


def following(follows):
    return Lapse.of(follows=follows, chosen=CHOICES.chosen, present=CHOICES.present)


def test_trials_that_share_luck_are_left_out_together():
    for cluster in np.unique(CHOICES.cluster):
        assert len(set(FOLD[CHOICES.cluster == cluster].tolist())) == 1
    assert sorted(set(FOLD.tolist())) == [0, 1, 2, 3]
    assert folds_of(np.array([5, 5, 9]), 10).tolist() == [0, 0, 1]


def test_a_prediction_does_not_know_what_it_predicts():
    """Other choices in a part change the predictions of every part but that one."""
    other = replace(CHOICES, chosen=np.where(FOLD == 1, (CHOICES.chosen + 1) % 4, CHOICES.chosen))
    before, after = aside(CHOICES, "favourite-places"), aside(other, "favourite-places")
    assert after[FOLD == 1] == pytest.approx(before[FOLD == 1], abs=1e-4)
    assert np.abs(after[FOLD == 0] - before[FOLD == 0]).max() > 0.01


def test_a_version_is_chosen_without_the_part_left_out():
    """Where one part follows one rule and all others another, the one part is predicted by the other rule."""
    first, second = np.eye(4)[CHOICES.chosen], np.eye(4)[(CHOICES.chosen + 1) % 4]
    versions = {
        "right but for part 2": following(np.where((FOLD == 2)[:, None], second, first)),
        "right in part 2": following(np.where((FOLD == 2)[:, None], first, second)),
    }
    fitted = {name: maximum(one) for name, one in versions.items()}
    found = held_out(versions, fitted, FOLD, CHOICES.present)
    mine = found[np.arange(len(CHOICES)), CHOICES.chosen]
    assert (mine[FOLD == 2] < 0.01).all()
    assert (mine[FOLD != 2] > 0.25).all()


def test_no_surprise_counts_as_infinitely_bad():
    follows = np.where((FOLD == 0)[:, None], np.eye(4)[(CHOICES.chosen + 1) % 4], np.eye(4)[CHOICES.chosen])
    always = {"always": following(follows)}
    found = held_out(always, {"always": maximum(always["always"])}, FOLD, CHOICES.present)
    fitted = int((FOLD != 0).sum())
    assert found[FOLD == 0].min() == pytest.approx(1 / 4 / (fitted + 1))
    assert found.sum(axis=1) == pytest.approx(1)


def test_chance_gains_nothing_and_knowing_gains_all():
    chance = predicted(CHOICES, np.full((len(CHOICES), 4), 0.25))
    assert (chance.gain, chance.low, chance.high) == pytest.approx((0, 0, 0))
    assert (chance.probability, chance.hits) == pytest.approx((0.25, 0.25))
    sure = predicted(CHOICES, np.eye(4)[CHOICES.chosen])
    assert (sure.gain, sure.probability, sure.hits) == pytest.approx((2, 1, 1))


def test_the_interval_is_that_of_a_ratio_of_sums_over_clusters():
    chances = np.where(np.eye(4)[CHOICES.chosen] * (CHOICES.cluster % 2 == 0)[:, None] > 0, 0.7, 0.1)
    chances = chances / chances.sum(axis=1, keepdims=True)
    found = predicted(CHOICES, chances)
    gains = np.log2(chances[np.arange(len(CHOICES)), CHOICES.chosen] * 4)
    sums = [(gains[CHOICES.cluster == k] - gains.mean()).sum() for k in range(12)]
    error = (12 / 11 * sum(one**2 for one in sums)) ** 0.5 / len(CHOICES)
    assert found.high - found.low == pytest.approx(2 * 2.200985 * error)


def test_a_real_preference_is_predicted_and_an_imagined_one_costs():
    assert predicted(CHOICES, aside(CHOICES, "favourite-places")).low > 0
    assert predicted(CHOICES, aside(CHOICES, "favourite-labels")).gain < 0.01
