"""Closed testing by averages: against all sets of hypotheses."""

from itertools import combinations

import numpy as np
import pytest

from lockprobe.statistics.sequential.closed import adjusted, log_thresholds


def sets_with(i, many):
    others = [j for j in range(many) if j != i]
    return [part for size in range(many) for part in combinations(others, size)]


def drawn(many, looks=12):
    return np.random.default_rng(many).normal(1.5, 2.5, (looks, many))


@pytest.mark.parametrize("many", [1, 2, 3, 5])
def test_an_adjusted_e_value_is_the_smallest_mean_of_all_sets_with_it(many):
    log_e = drawn(many)
    found = np.exp(adjusted(log_e))
    for row, e in zip(found, np.exp(log_e), strict=True):
        for i in range(many):
            assert row[i] == pytest.approx(min(np.mean([e[i], *e[list(part)]]) for part in sets_with(i, many)))


@pytest.mark.parametrize("many", [1, 2, 3, 5])
def test_a_threshold_is_what_the_hardest_of_all_sets_asks_for(many):
    log_e = drawn(many)
    found = np.exp(log_thresholds(log_e, 0.05))
    for row, e in zip(found, np.exp(log_e), strict=True):
        for i in range(many):
            needed = max(20 * (1 + len(part)) - e[list(part)].sum() for part in sets_with(i, many))
            assert row[i] == pytest.approx(needed)


@pytest.mark.parametrize("level", [0.05, 0.01])
def test_a_threshold_is_reached_exactly_where_closed_testing_rejects(level):
    log_e = drawn(4, looks=400)
    rejected = adjusted(log_e) >= np.log(1 / level)
    assert (rejected == (log_e >= log_thresholds(log_e, level))).all()
    assert 0.02 < rejected.mean() < 0.98
    assert (log_thresholds(log_e, level) >= np.log(1 / level) - 1e-12).all()


def test_one_hypothesis_alone_is_not_adjusted_and_others_of_much_evidence_cost_nothing():
    assert adjusted(np.array([[2.0]])) == pytest.approx(2.0)
    assert adjusted(np.array([[4.0, 900.0, 1200.0]])) == pytest.approx(np.array([[4.0, 600.0, 600.0]]), abs=1.2)


def test_hypotheses_may_change_places():
    log_e, turned = drawn(4), [2, 0, 3, 1]
    assert adjusted(log_e[:, turned]) == pytest.approx(adjusted(log_e)[:, turned])
    assert log_thresholds(log_e[:, turned], 0.05) == pytest.approx(log_thresholds(log_e, 0.05)[:, turned])
