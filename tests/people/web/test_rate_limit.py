"""Who can join, and how many from one address."""

import asyncio
from types import SimpleNamespace

import pytest
from served import experiment, logged, served, visiting
from starlette.datastructures import Headers

from lockprobe.people.web.rate_limit import JoinLimit, whence
from lockprobe.people.web.refusals import RequestRefused

AGREE = {"kind": "agree", "agreed": True}


async def opened(one, platform):
    answer = await one.http.post("/api/open", {"platform": platform})
    return answer, answer.json()


async def joined(one, platform, **agree):
    """The status and the scene, or the code of the refusal, of somebody who agrees at once."""
    answer, said = await opened(one, platform)
    if answer.status_code != 200:
        return answer.status_code, said["error"]
    if said["scene"]["kind"] != "consent":
        return answer.status_code, said["scene"]["why"]
    body = {"lease": said["lease"], "turn": 1, "act": AGREE | agree, "platform": platform}
    answer = await one.http.post("/api/act", body)
    said = answer.json()
    return answer.status_code, said["scene"]["kind"] if "scene" in said else said["error"]


def visits(directory, people, todo):
    async def visit():
        async with served(directory, people=people) as place:
            return await todo(place)

    return asyncio.run(visit())


def test_one_script_cannot_take_all_places_at_once(tmp_path):
    async def todo(place):
        came = []
        for _ in range(3):
            async with visiting(place) as one:
                came.append(await joined(one, {}))
        return came

    page = (200, "page")
    assert visits(tmp_path, experiment(joins_per_minute=2), todo) == [page, page, (429, "busy")]
    assert [line.split(maxsplit=1)[1] for line in logged(tmp_path)] == ["429 busy POST /api/act"]


def test_declining_and_full_studies_use_nothing_up(tmp_path):
    async def todo(place):
        for _ in range(3):
            async with visiting(place) as one:
                assert await joined(one, {}, agreed=False) == (200, "closed")
        async with visiting(place) as one:
            return await joined(one, {})

    assert visits(tmp_path, experiment(joins_per_minute=1), todo) == (200, "page")


def test_addresses_are_counted_apart_and_for_a_minute():
    now = [0.0]
    limit = JoinLimit(1, clock=lambda: now[0])
    limit.reserve("a")
    limit.reserve("b")
    with pytest.raises(RequestRefused):
        limit.reserve("a")
    limit.give_back("b")
    limit.reserve("b")
    now[0] = 60.0
    limit.reserve("a")
    limit.reserve("c")
    assert sorted(limit._joins) == ["a", "c"]


@pytest.mark.parametrize(
    ("peer", "forwarded", "proxied", "expected"),
    [
        ("93.184.216.34", None, False, "93.184.216.34"),
        ("93.184.216.34", "198.51.100.1", False, "93.184.216.34"),  # whoever asks can write that
        ("93.184.216.34", "198.51.100.1", True, "93.184.216.34"),
        ("127.0.0.1", "198.51.100.1", False, "198.51.100.1"),
        ("10.0.0.2", "1.2.3.4, 198.51.100.1", True, "198.51.100.1"),  # the proxy wrote the last
        ("127.0.0.1", "nonsense", True, "127.0.0.1"),
        ("2001:db8::1:2", None, False, "2001:db8::/64"),
        ("::ffff:203.0.113.7", None, False, "203.0.113.7"),
    ],
)
def test_behind_a_proxy_the_address_is_the_one_that_the_proxy_wrote(peer, forwarded, proxied, expected):
    headers = Headers({} if forwarded is None else {"x-forwarded-for": forwarded})
    request = SimpleNamespace(client=SimpleNamespace(host=peer), headers=headers)
    assert whence(request, proxied=proxied) == expected


def test_without_an_id_nobody_joins_where_one_is_required(tmp_path):
    async def todo(place):
        async with visiting(place) as one, visiting(place) as other, visiting(place) as third:
            first = await joined(one, {"STUDY_ID": "s"})
            second = await joined(other, {"PROLIFIC_PID": "ann"})
            _, said = await opened(third, {"PROLIFIC_PID": "bob"})
            body = {"lease": said["lease"], "turn": 1, "act": AGREE, "platform": {}}
            return first, second, (await third.http.post("/api/act", body)).json()["error"]

    first, second, third = visits(tmp_path, experiment(require_id=True), todo)
    assert (first, second, third) == ((400, "incomplete"), (200, "page"), "incomplete")
    assert "PROLIFIC_PID is missing in the URL" in logged(tmp_path)[0]


def test_without_the_code_nobody_joins_where_there_is_one(tmp_path):
    async def todo(place):
        async with visiting(place) as one, visiting(place) as other:
            _, said = await opened(one, {})
            assert said["scene"]["ask_code"]
            assert await joined(one, {}) == (403, "wrong-code")
            assert await joined(one, {}, code="wrong") == (403, "wrong-code")
            assert await joined(one, {}, code=" session-7 ") == (200, "page")
            _, said = await opened(other, {"code": "session-7"})
            assert not said["scene"]["ask_code"]
            assert await joined(other, {"code": "session-7"}) == (200, "page")

    visits(tmp_path, experiment(join_code="session-7"), todo)
    diaries = [path.read_text() for path in (tmp_path / "people").glob("*.jsonl")]
    assert len(diaries) == 2
    assert not any("session-7" in diary for diary in diaries)


def test_guesses_of_the_code_are_counted(tmp_path):
    async def todo(place):
        async with visiting(place) as one:
            return [await joined(one, {}, code=guess) for guess in ("one", "two", "three")]

    said = visits(tmp_path, experiment(join_code="session-7", joins_per_minute=2), todo)
    assert said == [(403, "wrong-code"), (403, "wrong-code"), (429, "busy")]
