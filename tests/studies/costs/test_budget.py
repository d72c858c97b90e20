"""Money: what a study has cost by agent, and a budget that no call passes, whatever is replied and when."""

import asyncio
import random
import tempfile
from functools import cache
from pathlib import Path

import pytest
from builders import call_of
from hypothesis import given, settings
from hypothesis import strategies as st
from stored import call_log

from lockprobe.agents.llm.model_facts import OWN_FACTS, Price
from lockprobe.foundation.errors import BadValue, BudgetReached
from lockprobe.studies.costs.call_log import read_calls
from lockprobe.studies.costs.spending import Budget, agent_price, spent_by_agent, total
from lockprobe.studies.options.study_options import StudyOptions
from lockprobe.studies.options.studyfile import study
from lockprobe.trial.model_call import BROKEN_OFF, Usage

PRICES = """
[[model]]
match = ["fake/dear*"]
price = { input = 3, cached = 1, stored = 4, output = 10, date = "2026-01-02", source = "made up" }
[[model]]
match = ["fake/cheap"]
price = { input = 0.5, cached = 0.5, output = 1, date = "2026-01-03", source = "made up" }
"""
DEAR, CHEAP, FREE = "llm:fake/dear", "llm:fake/cheap", "llm:fake/unheard"


@pytest.fixture(autouse=True, scope="module")
def prices(tmp_path_factory):
    path = tmp_path_factory.mktemp("prices") / "models.toml"
    path.write_text(PRICES)
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(OWN_FACTS, str(path))
        yield


def planned(*agents):
    return study(StudyOptions(agent=list(agents), trials=9, p=[0], repetitions=1))


@cache
def plans(agent):
    return list(planned(agent).plans(agent))


def call(agent=DEAR, trial=1, step=1, reply="said", **more):
    return call_of(plans(agent)[trial - 1], step, reply, **more)


def usage(read=0, wrote=0, cached=0, stored=0):
    return Usage(calls=1, input_tokens=read, output_tokens=wrote, cached_tokens=cached, stored_tokens=stored)


async def reserve(calls, most, agent=DEAR, trial=1, unanswered=0):
    """Announce the next call of a trial, as its agent does."""
    announced = call(agent, trial, reply=None, most=most, unanswered=unanswered)
    await calls.of(plans(agent)[trial - 1]).reserve(announced)


@pytest.mark.parametrize("allowed", [0, -1, float("nan"), float("inf")])
def test_a_budget_is_an_amount(allowed):
    with pytest.raises(BadValue, match="budget: got .*, expected US dollars above 0"):
        Budget(planned(DEAR), allowed)


def test_a_budget_needs_the_price_of_every_hosted_agent():
    with pytest.raises(BadValue, match="none with llm:fake/unheard, whose price is not known; --estimate prints"):
        Budget(planned(DEAR, FREE, "random"), 5)


def test_a_call_waits_for_those_on_their_way_and_is_refused_only_if_it_would_not_fit_without_them(tmp_path):
    worst, cost = usage(wrote=100_000), usage(wrote=40_000)  # at most $1; really $0.40
    began = []

    async def one(calls, trial):
        await reserve(calls, worst, trial=trial)
        began.append(trial)
        for _ in range(3):
            await asyncio.sleep(0)
        await calls.write(call(trial=trial, usage=cost))

    async def all_of_them():
        with call_log(tmp_path) as calls:
            calls.budget = Budget(planned(DEAR), 2.6)
            done = await asyncio.gather(*(one(calls, trial) for trial in range(1, 9)), return_exceptions=True)
            return calls.most, done

    spent, done = asyncio.run(all_of_them())
    assert began == [1, 2, 3, 4, 5]  # two at a time; the last fits exactly; with $2 spent none fits any more
    assert [type(end) for end in done] == [type(None)] * 5 + [BudgetReached] * 3
    assert spent == pytest.approx(2)


def test_a_call_that_was_cancelled_before_it_was_sent_leaves_nothing_and_holds_up_nobody(tmp_path):
    worst = usage(wrote=100_000)  # all that is allowed

    async def cancelled(calls):
        asked, waiting = (asyncio.create_task(reserve(calls, worst, trial=trial)) for trial in (1, 2))
        await asyncio.sleep(0)
        asked.cancel()
        await asyncio.wait([asked, waiting])

    with call_log(tmp_path) as calls:
        calls.budget = Budget(planned(DEAR), 1)
        asyncio.run(asyncio.wait_for(cancelled(calls), 10))
        assert calls.most == 0
    assert [call.key for call in read_calls(tmp_path)] == [plans(DEAR)[1].key]


@settings(max_examples=40, deadline=None)
@given(seed=st.integers(0, 2**32), allowed=st.floats(0.05, 3), lanes=st.integers(1, 8))
def test_spending_never_passes_the_budget_whatever_is_replied_and_when(seed, allowed, lanes):
    luck, agents = random.Random(seed), planned(DEAR, CHEAP)
    charged = [0.0]

    def charge(most: Usage, rates: Price) -> Usage:
        """What the provider really charges for, at the moment at which it is asked."""
        read = luck.randint(0, most.input_tokens)
        cached = luck.randint(0, read)
        used = usage(read, luck.randint(0, most.output_tokens), cached, luck.randint(0, read - cached))
        charged[0] += rates.of(used)
        assert charged[0] <= allowed + 1e-9
        return used

    async def lane(calls, number):
        agent = luck.choice([DEAR, CHEAP])
        for step in range(1, 15):
            worst = usage(luck.randint(0, 60_000), luck.randint(0, 60_000))
            try:
                await reserve(calls, worst, agent, number)
            except BudgetReached:
                return
            used, again = charge(worst, agent_price(agent)), 0
            while luck.random() < 0.3:  # it is charged for and never comes
                try:
                    await reserve(calls, worst, agent, number, unanswered=again + 1)
                except BudgetReached:
                    await calls.write(call(agent, number, step, reply=None, error=BROKEN_OFF))
                    return
                used, again = charge(worst, agent_price(agent)), again + 1
            for _ in range(luck.randint(0, 4)):
                await asyncio.sleep(0)
            counted = call(agent, number, step, usage=used, unanswered=again)
            uncounted = call(agent, number, step, usage=Usage(calls=1), unanswered=again)
            broken_off = call(agent, number, step, reply=None, error=BROKEN_OFF)
            failed = call(agent, number, step, reply=None, error="no reply within 120 s", unanswered=again + 1)
            await calls.write(luck.choice([counted, counted, uncounted, broken_off, failed]))

    async def run(directory):
        with call_log(directory) as calls:
            calls.budget = Budget(agents, allowed)
            await asyncio.gather(*(lane(calls, number) for number in range(1, lanes + 1)))

    with tempfile.TemporaryDirectory() as directory:
        for _ in range(2):  # a second run has what the first left, and no more
            asyncio.run(run(Path(directory)))
        spent = total(spent_by_agent(read_calls(directory)).values())
        assert charged[0] - 1e-9 <= (spent.dollars or 0) + (spent.dollars_unknown or 0) <= allowed + 1e-9


def test_every_attempt_whose_cost_nobody_said_counts_as_the_most_that_it_can_have_cost():
    worst = usage(read=1_000_000, wrote=100_000)  # $5
    calls = [
        call(usage=usage(read=1_000_000), unanswered=2, most=worst),  # $3 and twice $5
        call(step=2, unanswered=1, most=worst),
        call(step=3, reply=None, error="no reply within 120 s", unanswered=7, most=worst),
        call(step=4, reply=None, error=BROKEN_OFF, unanswered=1, most=worst),
        call(step=5, usage=usage(read=1_000_000)),
    ]
    spent = spent_by_agent(calls)[DEAR]
    assert (spent.usage.calls, spent.unpriced, spent.broken_off, spent.failed) == (3, 13, 1, 1)
    assert (spent.dollars, spent.dollars_unknown) == (pytest.approx(6), pytest.approx(5 * (2 + 2 + 7 + 2)))
    assert spent.most == pytest.approx(6 + 5 * 13)
