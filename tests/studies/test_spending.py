"""What a study has cost, by agent, and a budget that it never passes."""

import asyncio
import random
import tempfile
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from prefixes import repeated_prefix

from lockprobe.agents.llm.model_facts import OWN_FACTS, Price
from lockprobe.agents.llm.token_bounds import tokens
from lockprobe.agents.prompt import Message, conversation, repair
from lockprobe.errors import BadValue, BudgetReached, ReplyFault
from lockprobe.model_call import BROKEN_OFF, Call, Usage
from lockprobe.record import Situation
from lockprobe.studies.call_log import Calls, read_calls
from lockprobe.studies.request_sizes import HYPOTHESIS, made_up_steps, reply
from lockprobe.studies.spending import Budget, Ledger, Owners, dollars, most_dollars, price_of
from lockprobe.studies.study_options import StudyOptions
from lockprobe.studies.studyfile import study

PRICES = """
[[model]]
match = ["fake/dear*"]
price = { input = 3, cached = 1, stored = 4, output = 10, batch = 0.5, date = "2026-01-02", source = "made up" }
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


def call(agent=DEAR, trial=1, step=1, reply="said", **more):
    key = f"flips/{agent}/p=0/rep=1/trial={trial}"
    return Call(key=key, step=step, turn=more.pop("turn", 1), request="r", reply=reply, **more)


def usage(read=0, wrote=0, cached=0, stored=0):
    return Usage(calls=1, input_tokens=read, output_tokens=wrote, cached_tokens=cached, stored_tokens=stored)


@pytest.mark.parametrize("agent", ["random", "llm:a/b", "llm:a/b/c", "llm:a/b?images=4&effort=low", "llm:a/b/p=1/x"])
def test_an_agent_is_found_in_a_key_whatever_slashes_it_holds(agent):
    among = study(
        StudyOptions(agent=["random", "llm:a/b", "llm:a/b/c", "llm:a/b?images=4&effort=low", "llm:a/b/p=1/x"])
    )
    assert {Owners(among).of(plan.key) for plan in among.plans(agent)} == {agent}
    shown = study(StudyOptions(study="modalities", agent=[agent], modality=["symbolic", "rgb"], trials=1))
    assert {Owners(shown).of(plan.key) for plan in shown.plans(agent)} == {agent}


def test_an_agent_of_another_study_is_named_as_it_stands():
    plain = planned("llm:a/x")
    shown = study(StudyOptions(study="modalities", agent=["llm:a/x"], modality=["symbolic", "rgb"]))
    for owners, key in (
        (Owners(plain), "flips/llm:a/x/y/p=0/rep=1/trial=1"),
        (Owners(shown), "modalities/llm:a/x/y/rgb/p=0/rep=1/trial=1"),
        (Owners(shown), "modalities/llm:a/x/y/rgbd?depth=height/p=0/rep=1/trial=1"),
    ):
        assert owners.of(key) == "llm:a/x/y"
    assert Owners(shown).of("modalities/llm:a/x/rgbd/p=0/rep=1/trial=1") == "llm:a/x"
    assert Owners(plain).of("of no study") == "of no study"


def test_prices_are_of_hosted_models_only():
    assert price_of(DEAR + "?images=2").date == "2026-01-02"
    assert price_of(FREE) is price_of("random") is price_of("llm:local") is price_of("llm:gguf:/x/y.gguf") is None


def test_every_call_counts_with_what_its_provider_charges():
    ledger = Ledger(planned(DEAR, CHEAP, "random"))
    million = 1_000_000
    ledger.add(call(usage=usage(read=3 * million, wrote=million, cached=million, stored=million)))  # 3 + 1 + 4 + 10
    ledger.add(call(step=2, usage=usage(read=million), batch=True))  # 1.5
    ledger.add(call(CHEAP, usage=usage(wrote=million), retries=2, served="cheap-1", seconds=2.0))
    ledger.add(call(CHEAP, reply=None, error="the provider answered 500"))
    dear, cheap = ledger.by_agent[DEAR], ledger.by_agent[CHEAP]
    assert list(ledger.by_agent) == [DEAR, CHEAP]
    assert dear.dollars == pytest.approx(19.5)
    assert (dear.usage.calls, dear.usage.input_tokens, dear.price.date) == (2, 4 * million, "2026-01-02")
    assert (cheap.usage.calls, cheap.failed, cheap.retries, cheap.served) == (1, 1, 2, (("cheap-1", 1),))
    assert cheap.dollars == pytest.approx(1)
    assert ledger.total.dollars == pytest.approx(20.5)
    assert (ledger.total.usage.calls, ledger.total.failed, ledger.total.seconds) == (3, 1, 2.0)


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
    assert (spent.broken_off, spent.uncounted, spent.failed, spent.usage.calls) == (1, 1, 0, 2)
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
    assert (ledger.unanswered, ledger.uncounted, ledger.broken_off, ledger.failed) == (11, 1, 1, 1)
    assert (ledger.dollars, ledger.dollars_unknown) == (pytest.approx(3), pytest.approx(5 * (2 + 2 + 7 + 2)))
    for one in calls:
        budget.settle(one)
    assert budget.spent == pytest.approx(3 + 5 * 13)


def test_a_call_that_is_made_again_needs_the_money_once_more(tmp_path):
    worst = usage(wrote=100_000)  # $1

    async def made_again():
        with Calls.open(tmp_path) as calls:
            budget = Budget(planned(DEAR), 2.5)
            calls.limit(budget)
            page = calls.of(call().key)
            await page.reserve(worst)
            await page.reserve(worst, 1)
            with pytest.raises(
                BudgetReached, match=r"\$2\.0000 of \$2\.5000 spent; the next calls could cost \$1\.0000"
            ):
                await page.reserve(worst, 2)
            page.write(call(reply=None, error=BROKEN_OFF))
            return budget.spent

    assert asyncio.run(made_again()) == pytest.approx(2)
    assert Ledger(planned(DEAR), read_calls(tmp_path)).total.dollars_unknown == pytest.approx(2)


@pytest.mark.parametrize(("allowed", "ends"), [(3.5, [1, 2]), (2.9, [])])
def test_calls_that_are_made_again_do_not_wait_for_each_other(tmp_path, allowed, ends):
    """Each had money set aside that the other would wait for."""
    worst, done = usage(wrote=100_000), []  # $1

    async def one(calls, trial, both):
        page = calls.of(call(trial=trial).key)
        await page.reserve(worst)
        await both.wait()
        try:
            await page.reserve(worst, 1)
        except BudgetReached:
            calls.write(call(trial=trial, reply=None, error=BROKEN_OFF))
            return
        done.append(trial)
        calls.write(call(trial=trial, unanswered=1, usage=usage(wrote=10_000)))

    async def all_of_them():
        with Calls.open(tmp_path) as calls:
            calls.limit(Budget(planned(DEAR), allowed))
            both = asyncio.Barrier(2)
            await asyncio.wait_for(asyncio.gather(*(one(calls, trial, both) for trial in (1, 2))), 5)

    asyncio.run(all_of_them())
    assert sorted(done) == ends


def test_what_was_sent_before_is_what_the_request_before_held():
    calls = [
        call(usage=usage(read=100)),
        call(step=2, usage=usage(read=150)),  # 100 of it
        call(step=2, turn=2, usage=usage(read=180)),  # a repair: 150
        call(step=3, usage=usage(read=200)),  # of which the repair is no part: 150
        call(trial=2, usage=usage(read=100)),
        call(trial=2, step=2, usage=usage(read=40)),  # no more than it holds
    ]
    assert Ledger(planned(DEAR), calls).total.repeated_tokens == 100 + 150 + 150 + 40


@pytest.mark.parametrize("repairs", [0, 1])
def test_what_was_sent_before_is_that_of_the_requests_themselves(repairs):
    plan = next(planned(DEAR).plans(DEAR))
    whole = made_up_steps(plan, reply(HYPOTHESIS))[-1]
    calls, requests = [], []
    for step in range(1, 21):
        situation = Situation(
            task=whole.task, past=whole.past[: step - 1], percept=[*whole.past, whole][step - 1].percept
        )
        for turn in range(1, 2 + repairs):
            said = [
                Message(role="assistant", text="no"),
                Message(role="user", text=repair(ReplyFault("why"), situation)),
            ]
            requests.append([*conversation(situation), *said * (turn - 1)])
            read = round(sum(tokens(message.text) for message in requests[-1]))
            calls.append(call(step=step, turn=turn, usage=usage(read=read)))
    spent = Ledger(planned(DEAR), calls).total
    assert spent.repeated_tokens / spent.usage.input_tokens == pytest.approx(repeated_prefix(requests), abs=0.01)


def test_what_was_sent_before_is_not_known_where_pictures_leave_the_conversation():
    few, all_of_them = f"{DEAR}?images=4", f"{DEAR}?images=0"
    shown = study(StudyOptions(study="modalities", agent=[few, all_of_them], modality=["symbolic", "rgb"], trials=1))
    for spec, known in ((few, False), (all_of_them, True)):
        key = f"modalities/{spec}/rgb/p=0/rep=1/trial=1"
        calls = [Call(key=key, step=n, turn=1, request="r", reply="said", usage=usage(read=9)) for n in (1, 2)]
        assert Ledger(shown, calls).by_agent[spec].repeated_tokens == (9 if known else None)
        assert Ledger(shown, calls).total.repeated_tokens == (9 if known else None)
    told = Ledger(planned(few), [call(few, usage=usage(read=9)), call(few, step=2, usage=usage(read=9))])
    assert told.total.repeated_tokens == 9  # words stay


@pytest.mark.parametrize("allowed", [0, -1, float("nan"), float("inf")])
def test_a_budget_is_an_amount(allowed):
    with pytest.raises(BadValue, match="budget: got .*, expected US dollars above 0"):
        Budget(planned(DEAR), allowed)


def test_a_budget_needs_the_price_of_every_hosted_agent():
    with pytest.raises(
        BadValue, match=r"no budget with llm:fake/unheard, whose price is not known; .* LOCKPROBE_.*toml"
    ):
        Budget(planned(DEAR, FREE, "random"), 5)


def test_a_call_waits_for_those_on_their_way_and_is_refused_only_if_it_would_not_fit_without_them(tmp_path):
    worst, cost = usage(wrote=100_000), usage(wrote=40_000)  # at most $1; really $0.40
    began = []

    async def one(calls, trial):
        await calls.of(call(trial=trial).key).reserve(worst)
        began.append(trial)
        for _ in range(3):
            await asyncio.sleep(0)
        calls.write(call(trial=trial, usage=cost))

    async def all_of_them():
        with Calls.open(tmp_path) as calls:
            budget = Budget(planned(DEAR), 2.5)
            calls.limit(budget)
            done = await asyncio.gather(*(one(calls, trial) for trial in range(1, 9)), return_exceptions=True)
            return budget, done

    budget, done = asyncio.run(all_of_them())
    assert began == [1, 2, 3, 4]  # two at a time; with $1.60 spent none fits any more
    assert [type(end) for end in done] == [type(None)] * 4 + [BudgetReached] * 4
    assert budget.spent == pytest.approx(1.6)


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
                await calls.of(call(agent, number).key).reserve(worst)
            except BudgetReached:
                return
            used, again = charge(worst, price_of(agent)), 0
            while luck.random() < 0.3:  # it is charged for and never comes
                try:
                    await calls.of(call(agent, number).key).reserve(worst, again + 1)
                except BudgetReached:
                    calls.write(call(agent, number, step, reply=None, error=BROKEN_OFF))
                    return
                used, again = charge(worst, price_of(agent)), again + 1
            for _ in range(luck.randint(0, 4)):
                await asyncio.sleep(0)
            counted = call(agent, number, step, usage=used, unanswered=again)
            uncounted = call(agent, number, step, usage=Usage(calls=1), unanswered=again)
            broken_off = call(agent, number, step, reply=None, error=BROKEN_OFF)
            failed = call(agent, number, step, reply=None, error="no reply within 120 s", unanswered=again + 1)
            calls.write(luck.choice([counted, counted, uncounted, broken_off, failed]))

    async def run(directory):
        with Calls.open(directory) as calls:
            calls.limit(Budget(agents, allowed))
            await asyncio.gather(*(lane(calls, number) for number in range(lanes)))

    with tempfile.TemporaryDirectory() as directory:
        for _ in range(2):  # a second run has what the first left, and no more
            asyncio.run(run(Path(directory)))
        ledger = Ledger(agents, read_calls(directory)).total
        assert charged[0] - 1e-9 <= (ledger.dollars or 0) + (ledger.dollars_unknown or 0) <= allowed + 1e-9


def test_the_most_that_tokens_cost_is_as_if_all_were_put_into_the_cache():
    assert most_dollars(usage(read=1_000_000, cached=1_000_000, wrote=1_000_000), price_of(DEAR)) == pytest.approx(14)
    assert most_dollars(usage(read=1_000_000), price_of(CHEAP)) == pytest.approx(0.5)


@pytest.mark.parametrize(
    ("amount", "said"),
    [(0, "0.00"), (0.1, "0.10"), (1234.5, "1,234.50"), (0.0144, "0.014"), (0.00001, "0.00001"), (0.0996, "0.10")],
)
def test_money_is_written_to_the_cent_or_to_two_digits(amount, said):
    assert dollars(amount) == said
