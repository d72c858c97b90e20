"""What an agent's trials cost: tokens added up, priced where a price is known, never priced as nothing."""

from dataclasses import replace

import pytest
from builders import SOLUTION, make_trial

from lockprobe.agents.llm.model_facts import Price
from lockprobe.model_call import Usage
from lockprobe.report import costs as counted_by
from lockprobe.report.costs import money

PRICE = Price(input=2.0, cached=1.0, output=10.0, batch=0.5, date="2026-01-02", source="the test")


def trial(joints=SOLUTION, *, broken=None, model="acme/one", served="acme-one-2026", number=1, **facts):
    """A trial of which every decision read 1000 tokens, 400 of them from a cache, and wrote 50."""
    made = make_trial(joints, agent="llm:acme/one", trial=number, broken=broken, facts={"model": model, **facts})
    usage = Usage(calls=1, input_tokens=1000, cached_tokens=400, output_tokens=50)
    steps = tuple(replace(s, decision=replace(s.decision, usage=usage, served=served)) for s in made.steps)
    error = replace(made.error, usage=Usage(calls=2, input_tokens=300, output_tokens=7)) if made.error else None
    return replace(made, steps=steps, error=error)


@pytest.fixture(autouse=True)
def _priced(monkeypatch):
    known = counted_by.facts_of
    monkeypatch.setattr(
        counted_by, "facts_of", lambda name: replace(known("acme/one"), price=PRICE if name == "acme/one" else None)
    )


def test_tokens_of_all_trials_are_added_up_those_that_broke_among_them():
    found = money([trial(), trial((0,), broken="reply", number=2)])
    assert found.usage == Usage(calls=7, input_tokens=5300, cached_tokens=2000, output_tokens=257)
    assert found.dollars == pytest.approx((3300 * 2.0 + 2000 * 1.0 + 257 * 10.0) / 1e6)
    assert found.per_solved == pytest.approx(found.dollars)
    assert found.served == (("acme-one-2026", 5),)
    assert found.price == PRICE


def test_a_batch_costs_its_share():
    assert money([trial(batch=True)]).dollars == pytest.approx(money([trial()]).dollars / 2)


def test_without_a_price_nothing_is_priced():
    found = money([trial(model="acme/two")])
    assert (found.dollars, found.per_solved, found.price) == (None, None, None)
    assert found.usage.input_tokens == 4000


def test_without_a_solved_trial_there_is_no_price_of_one():
    found = money([trial((0,) * 20)])
    assert found.dollars > 0
    assert found.per_solved is None


def uncounted(**more):
    """A trial whose provider said of no reply what it read and wrote."""
    made = trial(**more)
    bare = [replace(s, decision=replace(s.decision, usage=Usage(calls=1))) for s in made.steps]
    return replace(made, steps=tuple(bare))


def test_replies_that_nobody_counted_do_not_cost_nothing():
    found = money([uncounted()])
    assert (found.calls, found.uncounted) == (4, 4)
    assert (found.usage, found.dollars, found.per_solved) == (None, None, None)


def test_what_was_counted_is_priced_and_the_rest_is_counted_apart():
    found, counted = money([trial(), uncounted(number=2)]), money([trial()])
    assert (found.calls, found.uncounted, found.usage) == (8, 4, counted.usage)
    assert found.dollars == counted.dollars
    assert (counted.calls, counted.uncounted) == (4, 0)


def test_agents_that_count_no_tokens_cost_nothing_that_is_known():
    found = money([make_trial(SOLUTION, agent="random")])
    assert (found.calls, found.uncounted) == (None, 0)
    assert (found.usage, found.dollars, found.served) == (None, None, ())
