"""What a study has cost, by agent, and a budget that it never passes."""

import pytest
from made_up_prices import CHEAP, DEAR, FREE, call, planned, prices, usage  # noqa: F401 - a fixture

from lockprobe.studies.costs.spending import Budget, Ledger, price_of
from lockprobe.trial.model_call import BROKEN_OFF


def test_prices_are_of_hosted_models_only():
    assert price_of(DEAR + "?images=2").date == "2026-01-02"
    assert price_of(FREE) is price_of("random") is price_of("llm:local") is price_of("llm:gguf:/x/y.gguf") is None


def test_money_that_is_not_known_is_none_and_never_nothing():
    ledger = Ledger(planned(DEAR, FREE), [call(usage=usage(read=1000)), call(FREE, usage=usage(read=1000))])
    assert ledger.by_agent[FREE].dollars is None
    assert ledger.by_agent[DEAR].dollars == pytest.approx(0.003)
    assert ledger.total.dollars is None
    assert Ledger(planned("random")).total.dollars is None


def test_calls_whose_cost_nobody_said_stand_apart():
    worst = usage(read=1_000_000, wrote=100_000)
    ledger = Ledger(
        planned(DEAR),
        [call(usage=usage(read=1_000_000)), call(reply=None, error=BROKEN_OFF, most=worst), call(step=2, most=worst)],
    )
    spent = ledger.by_agent[DEAR]
    assert (spent.broken_off, spent.unpriced, spent.failed, spent.usage.calls) == (1, 2, 0, 2)
    assert spent.dollars == pytest.approx(3)
    assert spent.dollars_unknown == pytest.approx(2 * (4 + 1))  # as if all of it had been put into the cache


def test_every_attempt_whose_cost_nobody_said_counts_as_the_most_that_it_can_have_cost():
    worst = usage(read=1_000_000, wrote=100_000)  # $5
    calls = [
        call(usage=usage(read=1_000_000), unanswered=2, most=worst),  # $3 and twice $5
        call(step=2, unanswered=1, most=worst),
        call(step=3, reply=None, error="no reply within 120 s", unanswered=7, most=worst),
        call(step=4, reply=None, error=BROKEN_OFF, unanswered=1, most=worst),
    ]
    ledger, budget = Ledger(planned(DEAR), calls).by_agent[DEAR], Budget(planned(DEAR), 1000)
    assert (ledger.unpriced, ledger.broken_off, ledger.failed) == (13, 1, 1)
    assert (ledger.dollars, ledger.dollars_unknown) == (pytest.approx(3), pytest.approx(5 * (2 + 2 + 7 + 2)))
    for one in calls:
        budget.settle(one)
    assert budget.spent == pytest.approx(3 + 5 * 13)
