"""The permutation test against all permutations, its level under shared luck; the bootstrap of the best p."""

import itertools
import json
from dataclasses import asdict

import numpy as np
import pytest

from lockprobe.analysis.inference.peak import any_difference, peak
from lockprobe.analysis.outcomes import Outcomes

TRUTH = np.array([7, 12, 16, 19, 20, 18, 15]) / 30


def study(solved, p=None):
    """Outcomes from an array (p, repetition, trial) of solved or not."""
    solved = np.asarray(solved, dtype=bool)
    i, r, t = np.indices(solved.shape).reshape(3, -1)
    p = np.arange(len(solved)) / 10 if p is None else np.asarray(p)
    return Outcomes(
        p=p[i],
        repetition=r + 1,
        trial=t + 1,
        length=np.full(i.size, 20),
        solved=solved.reshape(-1),
        onset=np.zeros(i.size, dtype=np.int64),
    )


def drawn(rng, success=0.5, shape=(7, 3, 10), shared=0.0):
    """Solved or not: with the given chance all values of p of a cluster share one draw, else each has its own."""
    luck = np.where(rng.random((1, *shape[1:])) < shared, rng.random((1, *shape[1:])), rng.random(shape))
    return luck < np.broadcast_to(success, shape[:1])[:, None, None]


def rng(seed=1):
    return np.random.default_rng(seed)


def everything(solved):
    """Exact p-values over all permutations inside clusters: the largest difference, each difference, the omnibus."""
    table = np.asarray(solved, dtype=float).reshape(len(solved), -1).T
    each = [set(itertools.permutations(row)) for row in table]
    weights = [[1 / len(options)] * len(options) for options in each]
    found = []
    for rows, chances in zip(itertools.product(*each), itertools.product(*weights), strict=True):
        success = np.mean(rows, axis=0)
        away = np.abs(success[1:] - success[0])
        found.append((np.prod(chances), away.max(), len(rows) * np.sum((success - success.mean()) ** 2)))
    chance, largest, spread = np.array(found).T
    seen = table.mean(axis=0)
    away = np.abs(seen[1:] - seen[0])
    at = [chance[largest >= value - 1e-9].sum() for value in away]
    omnibus = chance[spread >= len(table) * np.sum((seen - seen.mean()) ** 2) - 1e-9].sum()
    return at, omnibus


@pytest.mark.parametrize("seed", range(4))
def test_the_permutation_test_is_what_all_permutations_give(seed):
    solved = drawn(rng(seed), success=np.array([0.2, 0.5, 0.8]), shape=(3, 1, 6))
    at, omnibus = everything(solved)
    found = any_difference(study(solved), rng(9), permutations=20000)
    assert [difference.p_value for difference in found.at] == pytest.approx(at, abs=0.015)
    assert found.p_value == min(difference.p_value for difference in found.at)
    assert found.omnibus == pytest.approx(omnibus, abs=0.015)


def test_differences_are_from_the_lowest_p():
    solved = drawn(rng(), TRUTH)
    found = any_difference(study(solved), rng())
    success = solved.mean(axis=(1, 2))
    assert found.lowest == 0.0
    assert [difference.p for difference in found.at] == pytest.approx(np.arange(1, 7) / 10)
    assert [difference.value for difference in found.at] == pytest.approx(success[1:] - success[0])


@pytest.mark.parametrize("shared", [0.0, 0.5, 1.0])
def test_the_level_holds_whatever_luck_is_shared(shared):
    rejected = []
    for seed in range(300):
        found = any_difference(study(drawn(rng(seed), shared=shared)), rng(seed), permutations=199)
        rejected.append((found.p_value <= 0.05, found.omnibus <= 0.05))
    assert (np.mean(rejected, axis=0) <= 0.05 + 2.5 * np.sqrt(0.05 * 0.95 / 300)).all()


def test_one_luck_for_all_p_leaves_nothing_to_find():
    found = any_difference(study(drawn(rng(), shared=1.0)), rng())
    assert (found.p_value, found.omnibus) == (1.0, 1.0)
    assert {difference.value for difference in found.at} == {0.0}


def test_shared_luck_makes_a_difference_surer():
    """Six clusters rescued, none harmed: found among clusters that are else alike, not among unlike ones."""
    alike = np.zeros((2, 1, 30), dtype=bool)
    alike[:, 0, :15] = True
    alike[1, 0, 15:21] = True
    unlike = alike.copy()
    unlike[1] = np.roll(alike[1], 12)
    assert any_difference(study(alike), rng()).p_value < 0.05
    assert any_difference(study(unlike), rng()).p_value > 0.1


def test_the_effect_of_the_paper_is_found():
    found = [any_difference(study(drawn(rng(seed), TRUTH)), rng(seed), permutations=199) for seed in range(60)]
    assert np.mean([one.p_value <= 0.05 for one in found]) > 0.7


def test_missing_trials_are_left_where_they_are():
    whole = study(drawn(rng(), 0.5))
    rejected = []
    for seed in range(200):
        missing = rng(seed).random(len(whole)) < np.where(whole.p == 0, 0.1, 0.4)
        some = study(drawn(rng(seed + 1000), 0.3)).at(~missing)
        rejected.append(any_difference(some, rng(seed), permutations=99).p_value <= 0.05)
    assert np.mean(rejected) <= 0.05 + 2.5 * np.sqrt(0.05 * 0.95 / 200)


def test_nothing_to_compare():
    one = any_difference(study(np.ones((1, 3, 10))), rng())
    assert (one.p_value, one.at, one.lowest) == (None, (), 0.0)
    assert "No test" in one.note
    apart = study(drawn(rng()))
    assert any_difference(apart.at((apart.trial % 7) == np.round(apart.p * 10)), rng()).p_value is None
    assert any_difference(apart.at(apart.p < 0), rng()).lowest is None


def test_the_best_of_several_is_seen_too_high_and_the_honest_estimate_less_so():
    found = [peak(study(drawn(rng(seed))), rng(seed), resamples=200) for seed in range(100)]
    seen, honest = np.mean([(one.success, one.honest) for one in found], axis=0)
    assert seen - 0.5 > 0.1
    assert abs(honest - 0.5) < 0.5 * (seen - 0.5)
    assert all(one.honest == pytest.approx(one.success - one.curse) for one in found)


@pytest.mark.parametrize("truth", [np.full(7, 0.5), TRUTH], ids=["flat", "inverted U"])
def test_the_set_holds_the_best_and_the_interval_the_turn_about_as_often_as_they_say(truth):
    found = [peak(study(drawn(rng(seed), truth)), rng(seed), resamples=200) for seed in range(200)]
    assert np.mean([one.candidates[4].in_set for one in found]) > 0.95 - 2.5 * np.sqrt(0.05 * 0.95 / 200)
    if truth is TRUTH:
        _, slope, bend = np.polynomial.polynomial.polyfit(np.arange(7) / 10, truth, 2)
        assert np.mean([one.turning_low <= -slope / (2 * bend) <= one.turning_high for one in found]) > 0.9


def test_a_plain_best_is_alone_in_its_set():
    solved = drawn(rng(), np.array([0.1, 0.1, 0.1, 0.95, 0.1, 0.1, 0.1]))
    found = peak(study(solved), rng())
    assert (found.best, found.success) == (0.3, solved[3].mean())
    assert [one.p for one in found.candidates if one.in_set] == [0.3]
    assert abs(found.curse) < 0.02


def test_shares_add_up_and_ties_are_split():
    found = peak(study(drawn(rng(), TRUTH)), rng())
    assert sum(one.share for one in found.candidates) == pytest.approx(1)
    alike = peak(study(drawn(rng(), shared=1.0)), rng())
    assert [one.share for one in alike.candidates] == pytest.approx([1 / 7] * 7)
    assert (alike.best, alike.curse) == (0.0, pytest.approx(0, abs=0.01))


def test_clusters_are_drawn_whole_and_within_their_repetition():
    """Repetition 1 all solved, repetition 2 none: no resample can differ from the study."""
    solved = np.zeros((3, 2, 10))
    solved[:, 0] = 1
    found = peak(study(solved), rng())
    assert (found.curse, found.turning_low, found.turning_high) == (pytest.approx(0), 0.0, 0.0)


@pytest.mark.parametrize(("rising", "where"), [((1, 2, 3, 4), 0.3), ((4, 3, 2, 1), 0.0), ((4, 1, 1, 5), 0.3)])
def test_a_curve_that_does_not_turn_is_highest_at_an_end(rising, where):
    solved = np.arange(10)[None, None, :] < np.array(rising)[:, None, None]
    assert peak(study(solved), rng()).turning == pytest.approx(where)


def test_few_trials():
    nothing = study(np.empty((1, 1, 0)))
    assert (peak(nothing, rng()).best, peak(nothing, rng()).candidates) == (None, ())
    single = peak(study(np.ones((3, 2, 1))), rng())
    assert (single.best, single.honest, single.candidates[0].share) == (0.0, None, None)
    assert "No resamples" in single.note
    assert peak(study(drawn(rng(), shape=(2, 3, 10))), rng()).turning is None


def test_same_seed_same_numbers_and_all_of_them_are_plain():
    data = study(drawn(rng(), TRUTH))
    for test in (any_difference, peak):
        assert test(data, rng(5)) == test(data, rng(5))
        assert test(data, rng(5)) != test(data, rng(6))
        assert json.loads(json.dumps(asdict(test(data, rng())), allow_nan=False))
