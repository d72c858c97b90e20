"""Rates of intervals: false positives at their level, coverage near 95 %, the same on any number of processes."""

from multiprocessing import get_context

import pytest

from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.parallel import Processes
from lockprobe.simulation.montecarlo.interval_rates import interval_rates


@pytest.fixture(scope="module")
def rates():
    return interval_rates((("random", 0.4), ("cognitive:perseverant", 0.3)), trials=80, studies=40, forked=100)


def test_an_agent_that_ignores_reports_has_no_effect_and_seldom_seems_to(rates):
    records, forks = rates[:2]
    assert records.exact == pytest.approx(0, abs=1e-12)
    assert (forks.mean, forks.found, forks.covered) == (0, 0, 40)
    assert records.shown == 40
    assert records.found == records.shown - records.covered  # the interval without 0 is the test that rejects
    assert records.held > 0.95 - 3 * (0.95 * 0.05 / 40) ** 0.5


def test_estimates_of_a_true_effect_are_near_it(rates):
    records, forks = rates[2:]
    assert abs(records.mean - records.exact) < 0.03 < records.mean + 0.03
    assert min(records.held, forks.held) > 0.95 - 3 * (0.95 * 0.05 / 40) ** 0.5
    records, forks = interval_rates((("world:loop-breaker", 0.0),), trials=80, studies=40, forked=250)
    assert (records.shown, records.mean) == (0, None)  # nothing was a coin's choice
    assert forks.exact > 0.2
    assert abs(forks.mean - forks.exact) < 4 * 0.6 / 250**0.5
    assert forks.detected > 0.3


def test_several_processes_count_the_same_and_too_few_studies_are_refused(monkeypatch):
    """Three jobs over two forked workers; ``tests/simulation/audit/test_rates.py`` says where workers start afresh."""
    monkeypatch.setattr("lockprobe.simulation.montecarlo.interval_rates.BATCH", 2)
    monkeypatch.setattr("lockprobe.foundation.parallel.get_context", lambda _: get_context("fork"))
    asked = {"agents": (("cognitive:perseverant", 0.4),), "trials": 30, "studies": 5, "forked": 20}
    assert interval_rates(**asked, workers=Processes(2)) == interval_rates(**asked)
    with pytest.raises(BadValue, match="studies"):
        interval_rates(studies=0)
