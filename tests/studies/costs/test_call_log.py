"""Calls on disk: looked up instead of made again, accounted for whatever happens, and never beyond a budget."""

import asyncio
from dataclasses import replace

import pytest
from builders import call_of, small_study
from stored import call_log, contents, sql

from lockprobe.foundation.storage.database import Damaged, Database
from lockprobe.studies.costs.call_log import read_calls
from lockprobe.trial.model_call import BROKEN_OFF, Usage

STUDY = small_study(["llm:a/b"], p=(0.0,))
PLAN, OTHER = list(STUDY.plans("llm:a/b"))[:2]
WORST = Usage(calls=1, input_tokens=100, output_tokens=10)


def replied(step=1, trial=PLAN, **more):
    return call_of(trial, step, usage=Usage(calls=1, input_tokens=7, output_tokens=3), **more)


def about(call, unanswered=0):
    """A call as an agent announces it: without its place in the study, and with what it can cost."""
    return replace(
        call, agent="", reply=None, error="", usage=Usage(), seconds=0.0,
        retries=0, unanswered=unanswered, most=WORST,
    )  # fmt: skip


def ask(calls, call, plan=PLAN):
    """One call as an agent makes it."""
    page = calls.of(plan)
    assert page.recall(call.step, call.turn, call.request) is None
    asyncio.run(page.reserve(about(call)))
    asyncio.run(page.write(call))


def test_what_was_replied_is_looked_up_by_place_and_request(tmp_path):
    with call_log(tmp_path) as calls:
        ask(calls, replied())
    with call_log(tmp_path) as calls:
        page = calls.of(PLAN)
        assert page.recall(1, 1, "r") == replied()
        assert page.recall(1, 1, "another") is None
        assert page.recall(2, 1, "r") is None
        assert calls.of(OTHER).recall(1, 1, "r") is None
    assert list(read_calls(tmp_path)) == [replied()]


def test_what_was_on_its_way_at_a_kill_is_noted_as_broken_off_with_its_worst_case(tmp_path):
    with call_log(tmp_path) as calls:
        ask(calls, replied(step=1))
        asyncio.run(calls.of(PLAN).reserve(about(replied(step=2, request="next"))))
        assert calls.on_their_way[0] == 1
        # and here the process is killed: nothing more is written
    with call_log(tmp_path) as calls:
        assert calls.of(PLAN).recall(2, 1, "next") is None
        ask(calls, replied(step=2, request="next"))
    first, lost, again = read_calls(tmp_path)
    assert (first, again) == (replied(), replied(step=2, request="next"))
    assert (lost.step, lost.reply, lost.error, lost.most, lost.broken_off) == (2, None, BROKEN_OFF, WORST, True)


def test_a_request_and_its_attempts_are_on_the_disk_itself_before_they_are_sent_and_all_that_wait_share_a_commit(
    tmp_path, monkeypatch
):
    plain, commits = Database.transaction, []

    async def lane(calls, step):
        for attempt in range(2):
            await calls.of(PLAN).reserve(about(replace(replied(step), key=f"{step}"), unanswered=attempt))
            assert [call.unanswered for call in read_calls(tmp_path) if call.step == step] == [attempt]
        await calls.of(PLAN).write(replace(replied(step), key=f"{step}"))
        await calls.of(PLAN).reserve(about(replace(replied(step, request="next"), key=f"{step}")))

    async def all_of_them(calls):
        lanes = [asyncio.create_task(lane(calls, step)) for step in range(1, 9)]
        await asyncio.sleep(0)
        lanes[0].cancel()
        return await asyncio.gather(*lanes, return_exceptions=True)

    with call_log(tmp_path) as calls:
        monkeypatch.setattr(Database, "transaction", lambda store, **how: commits.append(how) or plain(store, **how))
        (cancelled, *ended) = asyncio.run(all_of_them(calls))
    assert (type(cancelled), ended) == (asyncio.CancelledError, [None] * 7)
    assert commits == [{"sync": True}, {}, {"sync": True}, {"sync": True}]  # a reply and what follows from it in one
    said = [(call.step, call.request, call.broken_off) for call in read_calls(tmp_path)]
    assert said == [*((n, "r", False) for n in range(2, 9)), *((n, "next", True) for n in range(2, 9))]


@pytest.mark.parametrize("turns", range(10))
def test_a_reply_that_came_before_its_run_was_ended_is_on_disk(tmp_path, turns):
    """Whether by Ctrl-C or by a fault of another trial: others are cancelled, some of them twice, at any moment."""
    came, first = [], asyncio.Event()

    async def lane(calls, step):
        done = about(call := replace(replied(step), key=f"{step}"))
        await calls.of(PLAN).reserve(done)
        try:
            await asyncio.sleep(0.001 * step)
            done = call
            came.append(step)
            first.set()
        finally:
            await calls.of(PLAN).write(done)

    async def ended(calls):
        lanes = [asyncio.create_task(lane(calls, step)) for step in range(1, 5)]
        await first.wait()
        for _ in range(turns):
            await asyncio.sleep(0)
        for _ in range(2):
            for one in lanes:
                one.cancel()
            await asyncio.sleep(0)
        await asyncio.gather(*lanes, return_exceptions=True)

    with call_log(tmp_path) as calls:
        asyncio.run(ended(calls))
    assert came == [call.step for call in read_calls(tmp_path) if call.reply]


@pytest.mark.parametrize(
    "change",
    [
        "call = 'no json'",
        "call = '{}'",
        "key = 'another'",
        "call = json_set(call, '$.key', 'another')",
        *(
            f"call = json_set(call, '$.{field}', json('{value}'))"
            for field, value in (
                ("key", "1"),
                ("step", "1.5"),
                ("step", "1" + "0" * 400),
                ("step", "true"),
                ("reply", "1"),
                ("seconds", "-1"),
                ("seconds", "1e12"),
                ("usage", "null"),
                ("usage", '{"input_tokens": -1}'),
                ("usage", '{"input_tokens": 1e30}'),
                ("surprise", "1"),
            )
        ),
    ],
)
def test_a_damaged_call_is_named_in_one_line_and_nothing_is_overwritten(tmp_path, change):
    with call_log(tmp_path) as calls:
        ask(calls, replied())
    sql(tmp_path, f"update call set {change}")
    sql(tmp_path, "update call set crc = checksum(key, call)")  # by somebody who knows the file
    before = contents(tmp_path)
    for use in (call_log, read_calls):
        with pytest.raises(Damaged, match=r"study.db: call 1.*`lockprobe import") as named, use(tmp_path):
            pass
        assert "\n" not in str(named.value)
        assert len(str(named.value)) < 1000
    assert contents(tmp_path) == before
