"""Calls on disk: looked up instead of made again, accounted for whatever happens, and never beyond a budget."""

import asyncio
import json

import pytest
from builders import SOLUTION, make_trial

from lockprobe.errors import BadFile
from lockprobe.model_call import BROKEN_OFF, Call, Usage
from lockprobe.storage.jsonl import without_checksum
from lockprobe.studies.call_log import ASKED, CALLS, Calls, read_calls, unanswered
from lockprobe.studies.journal import Journal, Timing
from lockprobe.studies.study_options import StudyOptions
from lockprobe.studies.studyfile import study

KEY = "flips/llm:a/b/truth/rep=1/trial=1"
WORST = Usage(calls=1, input_tokens=100, output_tokens=10)


def replied(step=1, turn=1, request="r", key=KEY, **more):
    usage = Usage(calls=1, input_tokens=7, output_tokens=3)
    return Call(key=key, step=step, turn=turn, request=request, reply="said", usage=usage, **more)


def ask(calls, call, worst=WORST):
    """One call as an agent makes it."""
    page = calls.of(call.key)
    assert page.recall(call.step, call.turn, call.request) is None
    asyncio.run(page.reserve(worst))
    page.write(call)


def test_what_was_replied_is_looked_up_by_place_and_request(tmp_path):
    with Calls.open(tmp_path) as calls:
        ask(calls, replied())
    with Calls.open(tmp_path) as calls:
        page = calls.of(KEY)
        assert page.recall(1, 1, "r") == replied()
        assert page.recall(1, 1, "another") is None
        assert page.recall(2, 1, "r") is None
        assert calls.of("another").recall(1, 1, "r") is None
    assert list(read_calls(tmp_path)) == [replied()]


def test_equal_requests_of_an_agent_that_forgets_have_their_own_replies_in_the_order_in_which_they_came(tmp_path):
    """What it remembers says how many steps there were: two steps can stand at one place with one request."""
    first, second, other = replied(seconds=1.0), replied(seconds=2.0), replied(request="another")
    with Calls.open(tmp_path) as calls:
        for call in (first, other, second):
            asyncio.run(calls.of(KEY).reserve(WORST))
            calls.of(KEY).write(call)
    with Calls.open(tmp_path) as calls:
        page = calls.of(KEY)
        assert [page.recall(1, 1, request) for request in ("r", "another", "r", "r")] == [first, other, second, None]
        assert calls.of(KEY).recall(1, 1, "r") == first


def test_a_call_without_a_reply_is_made_again(tmp_path):
    with Calls.open(tmp_path) as calls:
        ask(calls, Call(key=KEY, step=1, turn=1, request="r", reply=None, error="429"))
        assert calls.of(KEY).recall(1, 1, "r") is None
        ask(calls, replied())
        assert calls.of(KEY).recall(1, 1, "r") == replied()


def test_no_file_is_made_where_nobody_asks(tmp_path):
    with Calls.open(tmp_path):
        pass
    assert list(tmp_path.iterdir()) == []
    assert list(read_calls(tmp_path)) == unanswered(tmp_path) == []


def test_what_was_on_its_way_at_a_kill_is_noted_as_broken_off_with_its_worst_case(tmp_path):
    with Calls.open(tmp_path) as calls:
        ask(calls, replied(step=1))
        page = calls.of(KEY)
        page.recall(2, 1, "next")
        asyncio.run(page.reserve(WORST))
        assert calls.on_their_way == 1
        on_its_way = [(call.key, call.step, call.turn, call.request, call.most) for call in unanswered(tmp_path)]
        assert on_its_way == [(KEY, 2, 1, "next", WORST)]
        # and here the process is killed: nothing more is written
    with Calls.open(tmp_path) as calls:
        assert unanswered(tmp_path) == []
        assert calls.of(KEY).recall(2, 1, "next") is None
        ask(calls, replied(step=2, request="next"))
    first, lost, again = read_calls(tmp_path)
    assert (first, again) == (replied(), replied(step=2, request="next"))
    assert (lost.step, lost.reply, lost.error, lost.most, lost.broken_off) == (2, None, BROKEN_OFF, WORST, True)
    with Calls.open(tmp_path):
        pass
    assert len(list(read_calls(tmp_path))) == 3  # it is noted once


def test_a_call_of_unknown_cost_keeps_its_worst_case_and_one_that_was_counted_does_not(tmp_path):
    broken = Call(key=KEY, step=1, turn=1, request="r", reply=None, error=BROKEN_OFF)
    uncounted = Call(key=KEY, step=1, turn=1, request="r", reply="said", usage=Usage(calls=1))
    refused = Call(key=KEY, step=1, turn=1, request="s", reply=None, error="the provider answered 401")
    with Calls.open(tmp_path) as calls:
        for call in (broken, refused, uncounted):
            ask(calls, call)
        ask(calls, replied(step=2))
    assert [call.most for call in read_calls(tmp_path)] == [WORST, None, WORST, None]


def test_a_call_that_is_made_again_is_one_call_and_each_of_its_attempts_can_have_cost_something(tmp_path):
    with Calls.open(tmp_path) as calls:
        page = calls.of(KEY)
        page.recall(1, 1, "r")
        asyncio.run(page.reserve(WORST))
        asyncio.run(page.reserve(WORST, 1))
        page.write(replied(unanswered=1, retries=1))
        page.recall(2, 1, "next")
        asyncio.run(page.reserve(WORST))
        asyncio.run(page.reserve(WORST, 2))
        assert calls.on_their_way == 1
        (on_its_way,) = unanswered(tmp_path)
        assert (on_its_way.step, on_its_way.unanswered, on_its_way.most) == (2, 2, WORST)
        # and here the process is killed: nothing more is written
    with Calls.open(tmp_path):
        pass
    answered, lost = read_calls(tmp_path)
    assert (answered.unpriced, answered.most) == (1, WORST)
    assert (lost.broken_off, lost.unanswered, lost.unpriced, lost.most) == (True, 2, 3, WORST)
    assert unanswered(tmp_path) == []


def test_a_call_that_is_broken_off_here_keeps_the_attempts_before(tmp_path):
    with Calls.open(tmp_path) as calls:
        page = calls.of(KEY)
        page.recall(1, 1, "r")
        asyncio.run(page.reserve(WORST))
        asyncio.run(page.reserve(WORST, 1))
        page.write(Call(key=KEY, step=1, turn=1, request="r", reply=None, error=BROKEN_OFF))
    (lost,) = read_calls(tmp_path)
    assert (lost.unanswered, lost.unpriced, lost.most) == (1, 2, WORST)


def test_torn_tails_are_cut_off_and_their_calls_are_made_again(tmp_path):
    with Calls.open(tmp_path) as calls:
        ask(calls, replied())
        ask(calls, replied(step=2))
    for name in (CALLS, ASKED):
        whole = (tmp_path / name).read_bytes()
        (tmp_path / name).write_bytes(whole[:-9])
    with Calls.open(tmp_path) as calls:
        assert calls.of(KEY).recall(1, 1, "r") == replied()
        ask(calls, replied(step=2))
        ask(calls, replied(step=3))
    assert [call.step for call in read_calls(tmp_path)] == [1, 2, 3]
    assert unanswered(tmp_path) == []


@pytest.mark.parametrize(
    "line",
    [b"no json", b"{}", b'{"key":1,"step":1,"turn":1,"request":"r","reply":null}', b"[]",
     b'{"key":"k","step":1,"turn":1,"request":"r","reply":null,"more":1}'],
)  # fmt: skip
@pytest.mark.parametrize("name", [CALLS, ASKED])
def test_a_damaged_line_is_named(tmp_path, line, name):
    with Calls.open(tmp_path) as calls:
        ask(calls, replied())
    with (tmp_path / name).open("ab") as file:
        file.write(line + b"\n")
    with pytest.raises(BadFile, match=f"{name}: line 2: "), Calls.open(tmp_path):
        pass


@pytest.mark.parametrize("name", [CALLS, ASKED])
def test_a_changed_line_is_refused_and_one_of_an_earlier_release_is_read(tmp_path, name):
    with Calls.open(tmp_path) as calls:
        ask(calls, replied())
    line = (tmp_path / name).read_bytes()
    (tmp_path / name).write_bytes(without_checksum(line) + b"\n")
    with Calls.open(tmp_path) as calls:
        assert calls.of(KEY).recall(1, 1, "r") == replied()
    (tmp_path / name).write_bytes(line.replace(b'"step":1', b'"step":3'))
    with pytest.raises(BadFile, match=f"{name}: line 1: checksum: .* the line was changed"), Calls.open(tmp_path):
        pass


def test_listeners_get_every_call(tmp_path):
    heard = []
    with Calls.open(tmp_path) as calls:
        calls.listen(heard.append)
        ask(calls, replied())
        ask(calls, replied(step=2))
    assert [call.step for call in heard] == [1, 2]


def test_how_long_the_oldest_call_has_been_on_its_way(tmp_path, monkeypatch):
    now = [100.0]
    monkeypatch.setattr("lockprobe.studies.call_log.time.monotonic", lambda: now[0])
    with Calls.open(tmp_path) as calls:
        assert (calls.on_their_way, calls.longest_wait) == (0, 0)
        for key in ("one", "two"):
            asyncio.run(calls.of(key).reserve(WORST))
            now[0] += 5
        assert (calls.on_their_way, calls.longest_wait) == (2, 10)
        calls.write(replied(key="one"))
        assert (calls.on_their_way, calls.longest_wait) == (1, 5)


def test_a_finished_trial_is_forgotten_but_stays_on_disk(tmp_path):
    planned = study(StudyOptions(agent=["random"], trials=1, p=[0], repetitions=1))
    trial = make_trial(SOLUTION)
    with Journal.open(tmp_path, planned) as journal:
        ask(journal.calls, replied(key=trial.key))
        journal.append(trial, Timing(key=trial.key, seconds=1, steps=4))
        assert journal.calls.of(trial.key).recall(1, 1, "r") is None
    with Journal.open(tmp_path, planned) as journal:
        assert journal.calls.of(trial.key).recall(1, 1, "r") is None
    assert [json.loads(line)["key"] for line in (tmp_path / CALLS).read_text().splitlines()] == [trial.key]


@pytest.mark.parametrize("seconds", [b"1e999", b"1e300", b"1e12", b"-1", b"NaN"])
def test_a_duration_that_is_none_is_refused(tmp_path, seconds):
    line = b'{"key":"k","step":1,"turn":1,"request":"a","reply":"x","seconds":%s}\n' % seconds
    (tmp_path / CALLS).write_bytes(line)
    with pytest.raises(BadFile, match="line 1"):
        list(read_calls(tmp_path))
