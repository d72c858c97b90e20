"""What an agent's trials cost: tokens added up, priced where a price is known, never priced as nothing."""

from dataclasses import replace

import pytest
from builders import SOLUTION, make_trial

from lockprobe.agents.llm.model_facts import Price
from lockprobe.report import costs as counted_by
from lockprobe.report.costs import cost_rows, price_asked
from lockprobe.trial.model_call import Usage

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


def spent(trials):
    """What is said of the trials of an agent: quantity, and what part of it -> number."""
    return {" ".join(filter(None, (row.quantity, row.of))): row.value for row in cost_rows(trials, {"agent": "a"})}


TOKENS = ("tokens input", "tokens output", "cached_share")


def test_tokens_of_all_trials_are_added_up_those_that_broke_among_them():
    trials = [trial(), trial((0,), broken="reply", number=2)]
    found = spent(trials)
    assert [found[name] for name in ("calls", *TOKENS)] == [7, 5300, 257, 2000 / 5300]
    assert found["cost"] == pytest.approx((3300 * 2.0 + 2000 * 1.0 + 257 * 10.0) / 1e6)
    assert found["cost per solved trial"] == pytest.approx(found["cost"])
    assert found["answers acme-one-2026"] == 5
    assert price_asked(trials) == PRICE


def test_a_batch_costs_its_share():
    assert spent([trial(batch=True)])["cost"] == pytest.approx(spent([trial()])["cost"] / 2)


def test_without_a_price_nothing_is_priced():
    trials = [trial(model="acme/two")]
    found = spent(trials)
    assert not found.keys() & {"cost", "cost per solved trial"}
    assert price_asked(trials) is None
    assert found["tokens input"] == 4000


def test_without_a_solved_trial_there_is_no_price_of_one():
    found = spent([trial((0,) * 20)])
    assert found["cost"] > 0
    assert "cost per solved trial" not in found


def uncounted(**more):
    """A trial whose provider said of no reply what it read and wrote."""
    made = trial(**more)
    bare = [replace(s, decision=replace(s.decision, usage=Usage(calls=1))) for s in made.steps]
    return replace(made, steps=tuple(bare))


def test_replies_that_nobody_counted_do_not_cost_nothing():
    assert spent([uncounted()]) == {"calls": 4, "calls uncounted": 4, "answers acme-one-2026": 4}


def test_what_was_counted_is_priced_and_the_rest_is_counted_apart():
    found, counted = spent([trial(), uncounted(number=2)]), spent([trial()])
    assert (found["calls"], found["calls uncounted"]) == (8, 4)
    assert [found[name] for name in (*TOKENS, "cost")] == [counted[name] for name in (*TOKENS, "cost")]
    assert (counted["calls"], counted["calls uncounted"]) == (4, 0)


def test_agents_that_count_no_tokens_cost_nothing_that_is_known():
    assert spent([make_trial(SOLUTION, agent="random")]) == {}
