"""The page over HTTP: what it gets, what it cannot get, and what is refused."""

import asyncio
import json
import re
import resource
from collections import Counter
from contextlib import AsyncExitStack, suppress
from dataclasses import replace
from urllib.parse import urlsplit

import httpx2 as httpx
import pytest
from seated import as_played, people_study, without_page
from stored import acts, contents
from visitor import STUDY, experiment, logged, served, visiting

from lockprobe import load
from lockprobe.boxes.families import box
from lockprobe.foundation.errors import BadValue, Missing
from lockprobe.interventions.conditions import flips
from lockprobe.people import server_state
from lockprobe.people.diary import read_diaries
from lockprobe.people.experiment import read_words
from lockprobe.people.server_state import ServerState
from lockprobe.people.web import app
from lockprobe.people.web.address import Address
from lockprobe.people.withdrawal import keyed_digest
from lockprobe.plants.catalogue import PlantSource
from lockprobe.studies.records.store import STORE
from lockprobe.studies.running.paused_trial import PausedTrial


async def raw(url, request):
    """The bytes of an answer to the bytes of a request."""
    parts = urlsplit(url)
    reader, writer = await asyncio.open_connection(parts.hostname, parts.port)
    try:
        writer.write(request.replace(b"HOST", parts.netloc.encode()))
        return await asyncio.wait_for(reader.read(), 60)
    finally:
        writer.close()
        await writer.wait_closed()


async def test_a_page_is_opened_with_its_words_and_a_cookie_that_no_script_reads(tmp_path):
    async with served(tmp_path) as place:
        first = await place.http.post("/api/open", json={})
    opened = first.json()
    assert set(opened) == {"turn", "scene", "participant", "progress", "words"}
    assert set(opened["words"]) == {"language", "direction", "title", "page"}
    assert opened["words"]["page"] == read_words("en").page
    assert (opened["scene"]["kind"], opened["participant"]) == ("consent", None)
    cookie = first.headers["set-cookie"].lower()
    assert cookie.startswith("lockprobe=")
    assert {"httponly", "samesite=strict", "path=/"} < {part.strip() for part in cookie.split(";")}
    assert "secure" not in cookie
    assert first.headers["cache-control"] == "no-store"


async def test_nothing_is_written_before_consent_and_nothing_of_who_declines(tmp_path):
    async with served(tmp_path) as place, visiting(place, platform={"PROLIFIC_PID": "p1"}) as one:
        before = contents(tmp_path)
        await one.open()
        await one.act(kind="agree", agreed=False)
        assert (one.scene.kind, one.scene.why) == ("closed", "declined")
        assert contents(tmp_path) == before
        assert not one.http.cookies


async def test_a_preview_shows_all_takes_no_place_and_leaves_nothing(tmp_path):
    """Also where an ID is required, and of somebody in whose browser another participant was before."""
    async with served(tmp_path, people=experiment(require_id=True, practice="chain-2")) as place:
        async with visiting(place, platform={"PROLIFIC_PID": "p1"}) as one:
            await one.to_the_box()
        before = contents(tmp_path)
        for withdraws in (False, True):
            async with visiting(place, platform={"preview": place.preview}) as looks:
                await looks.play(until=("over",) if withdraws else ("debrief", "closed"))
                await looks.open()
                if withdraws:
                    answer = await looks.post("/api/withdraw", {})
                    assert answer.json()["scene"]["why"] == "withdrawn"
                else:
                    assert looks.scene.kind == "debrief"
        assert contents(tmp_path) == before
        for platform in ({"preview": "0" * 16}, {}):
            answer = await place.http.post("/api/open", json={"platform": platform})
            assert (answer.status_code, answer.json()["error"]) == (400, "incomplete")


async def test_an_act_counts_once_however_often_it_is_sent_at_once(tmp_path):
    async def send(place, visitor, turn, **act):
        body = {"turn": turn, "act": act, "platform": visitor.platform}
        cookie = {"cookie": f"lockprobe={visitor.http.cookies['lockprobe']}"}
        return await place.http.post("/api/act", json=body, headers=cookie)

    async with served(tmp_path) as place, AsyncExitStack() as stack:
        who = [{"PROLIFIC_PID": "one"}] * 6 + [{"PROLIFIC_PID": f"p{i}"} for i in range(6)]
        visitors = [await stack.enter_async_context(visiting(place, platform=platform)) for platform in who]
        await asyncio.gather(*(visitor.open() for visitor in visitors))
        agree = {"kind": "agree", "agreed": True}
        replies = await asyncio.gather(*(send(place, one, 1, **agree) for one in visitors for _ in range(3)))
        one = next(one for one, reply in zip(visitors, replies[::3], strict=True) if reply.json()["participant"])
        await one.open()
        await one.to_the_box(2)
        joint = one.scene.panel["joints"][0]["label"]
        act = {"kind": "attempt", "joint": joint, "rt": 9, "claimed": "moved", "claimed_rt": 5}
        answers = await asyncio.gather(*(send(place, one, one.turn, **act) for _ in range(20)))
        assert {answer.status_code for answer in answers} == {200}
        assert len({answer.content for answer in answers}) == 1
        assert (answers[0].json()["turn"], answers[0].json()["scene"]["step"]) == (one.turn + 1, 3)
    replies = [reply.json() for reply in replies]
    joined = {reply["participant"] for reply in replies} - {None}
    assert len(joined) == len(read_diaries(tmp_path)) == 3  # as many as there are boxes for
    why = Counter(reply["scene"].get("why") for reply in replies)
    assert (why["taken"], why["full"]) == (15, 12)


ATTEMPT = {"kind": "attempt", "joint": "A", "rt": 1000}
ASKED = ATTEMPT | {"claimed": "moved", "claimed_rt": 5.5}
MALFORMED, IMPOSSIBLE = (400, "malformed"), (422, "impossible")
STALE, FOREIGN = (409, "stale"), (403, "cross-site")


def act_of(act=ASKED, **more):
    """A body, in which the turn of the visitor is filled in."""
    return {"turn": "TURN", "act": act, **more}


BODIES = [
    b"", b"{", b"null", b"[]", b'"open"', b"[" * 16_000, b'{"platform": {"a": 1}}', b'{"platform": {"a": "\\ud800"}}',
    b'{"platform": ' + b'{"a":' * 2500 + b"1" + b"}" * 2500 + b"}", b'{"platform": {"a": "\xff"}}',
    b'{"platform": {"a": "' + b"x" * 1000 + b'"}}', b'{"platform": {}, "token": "mine"}', b"\x1f\x8b\x08gzip",
    json.dumps({"platform": {str(i): "" for i in range(1000)}}).encode(),
]  # fmt: skip
"""That are none for any path."""

REQUESTS = [
    # acts that are none, or not of this scene
    *(("/api/act", act_of(act), {}, IMPOSSIBLE) for act in (
        ASKED | {"joint": "H"}, ATTEMPT, {"kind": "answers", "answers": ["x"], "rt": 1},
        {"kind": "agree", "agreed": True}, {"kind": "answers", "answers": [], "rt": 1},
    )),
    *(("/api/act", act_of(act), {}, MALFORMED) for act in (
        ASKED | {"joint": "A" * 50}, ASKED | {"joint": 0}, ASKED | {"claimed": "flew"}, {"kind": "solve"},
        ASKED | {"moved": True}, ASKED | {"rt": -1}, ASKED | {"rt": None}, ASKED | {"rt": 1e300}, ASKED | {"rt": "12"},
    )),
    # turns and tokens that were not given out
    *(("/api/act", act_of(turn=turn), {}, MALFORMED) for turn in (-1, True, 10**12, "1", None, 1.5)),
    *(("/api/act", act_of(turn=turn), {}, STALE) for turn in (0, 1, 1000)),
    ("/api/act", {**act_of(ASKED | {"rt": 123456.0}), "turn": "LAST"}, {}, STALE),  # the last act again, but another
    *(("/api/act", act_of(), {"cookie": f"lockprobe={token}"}, MALFORMED) for token in (
        "", "x", "A" * 64, "TOKEN"[:-1], "TOKENA", "../secret", "a" * 4000, '"\\303\\244"',
    )),
    *((path, body, {"cookie": cookie}, MALFORMED) for path, body in (("/api/act", act_of()), ("/api/withdraw", {}))
      for cookie in ("", "lockprobe=forged")),
    ("/api/act", act_of(), {"cookie": f"lockprobe={'0' * 64}"}, STALE),
    # bodies
    *((path, body, {}, MALFORMED) for path in ("/api/open", "/api/act") for body in BODIES),
    *(("/api/act", b'{"turn": ' + turn + b', "act": {"kind": "answers", "answers": [], "rt": 1}}', {}, MALFORMED)
      for turn in (b"1e400", b"9" * 9000)),
    *(("/api/act", b'{"turn": 1, "act": {"kind": "attempt", "joint": "A", "rt": ' + rt + b"}}", {}, MALFORMED)
      for rt in (b"NaN", b"Infinity")),
    ("/api/act", b"x" * 20_000, {}, (413, "too-large")),
    *(("/api/open", {"platform": {"PROLIFIC_PID": value}}, {"cookie": ""}, (400, "incomplete"))
      for value in ("<script>", "", "a b", "../x", "a" * 65, "%00", "é", "a\n")),
    # other people's pages and names
    *(("/api/act", act_of(), {"origin": origin}, FOREIGN) for origin in ("https://evil.example", "null", "http://localhost")),
    *(("/api/act", act_of(), {"sec-fetch-site": site}, FOREIGN) for site in ("cross-site", "same-site", "none")),
    *(("/api/act", act_of(), {"host": host}, FOREIGN) for host in ("", "evil.example", "127.0.0.1", "127.0.0.1:80", "127.0.0.1:PORT@evil")),
    # paths and methods
    ("/", {}, {}, (405, "unknown")), ("/x", {}, {}, (405, "unknown")), ("/api/open/", {}, {}, (405, "unknown")),
]  # fmt: skip
"""Path, body and headers of what a participant in the second step of a box may send -> what is answered."""


async def test_what_cannot_be_done_is_refused_logged_without_what_was_sent_and_changes_nothing(tmp_path, caplog):
    async with served(tmp_path) as place, visiting(place) as one, visiting(place) as other:
        await other.to_the_box()
        await one.to_the_box(2)
        before, _ = contents(tmp_path), logged(caplog)
        token = one.http.cookies["lockprobe"]
        values = {
            b'"TURN"': str(one.turn), b'"LAST"': str(one.turn - 1),
            b'"A"': json.dumps(one.scene.panel["joints"][0]["label"]),
        }  # fmt: skip
        for path, body, headers, (status, code) in REQUESTS:
            content = body if isinstance(body, bytes) else json.dumps(body).encode()
            for name, value in values.items():
                content = content.replace(name, value.encode())
            port = str(urlsplit(place.url).port)
            given = {name: said.replace("TOKEN", token).replace("PORT", port) for name, said in headers.items()}
            answer = await one.http.post(path, content=content, headers=given)
            what = (path, content[:80], given)
            assert (answer.status_code, answer.json()["error"]) == (status, code), what
            assert app.SECURITY_HEADERS.items() <= answer.headers.items(), what
            assert "access-control-allow-origin" not in answer.headers
            assert path != "/api/open" or answer.json()["words"]["page"] == read_words("en").page
            assert "set-cookie" not in answer.headers, what
        assert contents(tmp_path) == before
        why = " PROLIFIC_PID in the URL is not a value of a recruitment platform"
        lines = [(f"{status} {code} POST {path}", code == "incomplete") for path, _, _, (status, code) in REQUESTS]
        assert logged(caplog) == [line + why * incomplete for line, incomplete in lines]
        await one.play()  # the page goes on as if nothing had been
        await other.play()
    assert len(load(tmp_path)) == 4


@pytest.mark.parametrize(
    ("address", "url", "host", "secure"),
    [
        ({}, "http://127.0.0.1:8765/", "localhost:8765", False),
        ({"public": "https://Study.Example.org:443/"}, "https://Study.Example.org:443/", "study.example.org", True),
        ({"public": "http://a.example:8080"}, "http://a.example:8080/", "a.example:8080", False),
        ({"public": "https://[2001:DB8::1]"}, "https://[2001:DB8::1]/", "[2001:db8::1]", True),
        ({"host": "0.0.0.0", "port": 80, "allowed": ("lab-pc.local",)}, "http://lab-pc.local/", "lab-pc.local", False),
        ({"host": "2001:db8::1", "port": 80}, "http://[2001:db8::1]/", "[2001:db8::1]", False),
        ({"host": "0.0.0.0", "public": "https://a.example"}, "https://a.example/", "a.example", True),
    ],
)
def test_a_server_goes_by_the_names_it_was_given(address, url, host, secure):
    found = Address(**address)
    assert (found.url, found.secure) == (url, secure)
    assert host in found.hosts
    assert {origin.partition("://")[2] for origin in found.origins} == found.hosts
    assert "0.0.0.0" not in "".join(found.hosts)


PUBLIC = ["study.example.org", "ftp://a.org", "https://", "https://a/b", "https://a?b", "https://a#b", "https://me@a",
          "https://a:0", "https://a:999999", "https://a b", "https://[::1", "javascript:alert(1)"]  # fmt: skip


@pytest.mark.parametrize(
    ("address", "said"),
    [
        *(({"public": public}, "public-url") for public in PUBLIC),
        *(({"allowed": (name,)}, "allow-host") for name in ("", "a b", "a:80", "https://a", "a/b", "*")),
        ({"host": "0.0.0.0"}, "--public-url"),
    ],
)
def test_what_is_no_name_or_none_at_all_is_refused(address, said):
    with pytest.raises((BadValue, Missing), match=said):
        Address(**address)


def test_the_secret_of_a_study_is_its_owners_and_no_link(tmp_path):
    path = tmp_path / "people" / "secret"
    digest = keyed_digest(tmp_path, "ann")
    assert keyed_digest(tmp_path, "ann") == digest != keyed_digest(tmp_path / "other", "ann")
    assert (path.stat().st_mode & 0o777, path.parent.stat().st_mode & 0o777) == (0o600, 0o700)


PATHS = [
    b"/nothing", b"/static/", b"/nothing.js", b"/../people/secret", b"/..%2f..%2fpeople%2fsecret",
    b"/%2e%2e/%2e%2e/secret", b"//etc/passwd", b"/page.js%00.html",
    b"//evil.example/", b"/people/secret", b"/study.db", b"/study.db-wal", b"/study.json", b"/admin/", b"/api/",
    b"/api/open/", b"/API/OPEN", b"/..\\..\\secret", b"/%ff%fe", b"/%0a/\x1b[31m", b"/" + b"a" * 5000,
]  # fmt: skip
TWO_LENGTHS = (  # whichever is believed, the body is whole and right
    b"POST /api/open HTTP/1.1\r\nHost: HOST\r\nConnection: close\r\nContent-Type: application/json\r\n"
    b"Content-Length: 12\r\nTransfer-Encoding: chunked\r\n\r\n2\r\n{}\r\n0\r\n\r\n"
)
SLOW = b"POST /api/open HTTP/1.1\r\nHost: HOST\r\nConnection: close\r\nContent-Type: application/json\r\nContent-Length: 3\r\n\r\n{"
NO_HTTP = [
    b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03", b"GET / HTTP/1.1\r\n\r\n", b"GET /\r\n\r\n", TWO_LENGTHS, SLOW,
    b"GET / HTTP/1.1\r\nHost: HOST\r\nHost: evil.example\r\n\r\n",
    b"POST /api/open HTTP/1.1\r\nHost: HOST\r\nContent-Length: -1\r\n\r\n",
]  # fmt: skip


async def test_no_more_boxes_with_a_camera_are_open_at_once_than_there_may_be_and_all_are_played(tmp_path, monkeypatch):
    begin, close, open_ = PausedTrial.begin, PausedTrial.close, set()
    monkeypatch.setattr(server_state, "_MOST_WITH_CAMERA", 2)
    monkeypatch.setattr(PlantSource, "has_camera", True)
    monkeypatch.setattr(PausedTrial, "begin", lambda trial, *steps: open_.add(trial) or begin(trial, *steps))
    monkeypatch.setattr(PausedTrial, "close", lambda trial: open_.discard(trial) or close(trial))
    study = people_study(p=(0.0,), trials=3, max_steps=3)
    async with served(tmp_path, study, experiment(questions=())) as place, AsyncExitStack() as stack:
        visitors = [await stack.enter_async_context(visiting(place)) for _ in range(3)]
        for visitor in (*visitors, *visitors):  # a box that was closed is replayed to where its person is
            await visitor.do() if visitor.seen else await visitor.to_the_box(2)
            assert len(open_) <= 2
        for visitor in visitors:
            await visitor.play()
    assert len(load(tmp_path)) == 3


async def test_paths_lead_nowhere_else_and_what_is_no_http_is_refused(tmp_path, monkeypatch, caplog):
    monkeypatch.setattr(app, "SECONDS_FOR_A_BODY", 0.05)

    async def endless():
        for _ in range(5000):
            yield b"x" * 1000

    async with served(tmp_path) as place:
        before = contents(tmp_path)
        for path in PATHS:
            answer = await raw(place.url, b"GET " + path + b" HTTP/1.1\r\nHost: HOST\r\nConnection: close\r\n\r\n")
            head, _, body = answer.partition(b"\r\n\r\n")
            if not head.startswith(b"HTTP/1.1 400 "):
                assert head.startswith(b"HTTP/1.1 404 "), (path, answer)
                assert json.loads(body)["error"] == "unknown"
        for request in NO_HTTP:
            answer = await raw(place.url, request)
            assert answer.startswith((b"HTTP/1.1 400 ", b"HTTP/1.1 413 ")), (request[:40], answer[:200])
            assert b"evil" not in answer
        for content in (b"x" * 5_000_000, endless()):  # of which no more is read, whoever still sends
            with suppress(httpx.TransportError):
                assert (
                    await place.http.post("/api/open", content=content, headers={"content-type": "application/json"})
                ).status_code in (400, 413)
        assert contents(tmp_path) == before
    lines = logged(caplog)
    assert len(lines) >= len(PATHS) + 2  # what is no HTTP reaches no application
    assert all(line.isprintable() and len(line) < 200 for line in lines)


async def test_what_breaks_inside_is_answered_and_logged_without_what_was_sent(tmp_path, monkeypatch, caplog):
    async def breaks(*arguments):
        raise KeyError("what was sent")

    async with served(tmp_path) as place:
        monkeypatch.setattr(ServerState, "enter", breaks)
        answer = await place.http.post("/api/open", json={"platform": {"a": "what was sent"}})
    assert (answer.status_code, answer.json()["error"]) == (500, "broken")
    assert answer.headers["x-content-type-options"] == "nosniff"
    (line,) = logged(caplog)
    assert re.fullmatch(r"500 broken POST /api/open KeyError at web/test_app.py:\d+", line)


def test_what_a_full_disk_takes_in_part_or_not_has_not_been_done(tmp_path):
    async def visit():
        async with served(tmp_path) as place, visiting(place) as one:
            await one.to_the_box(2)
            log, (soft, hard) = tmp_path / f"{STORE}-wal", resource.getrlimit(resource.RLIMIT_FSIZE)
            act = {"kind": "attempt", "joint": "A", "claimed": "moved", "claimed_rt": 1, "rt": 2}
            for room in (0, 20, 4096):
                before = acts(tmp_path, one.identity)
                resource.setrlimit(resource.RLIMIT_FSIZE, (log.stat().st_size + room, hard))
                try:
                    answer = await one.http.post("/api/act", json={"turn": one.turn, "act": act})
                finally:
                    resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
                assert (answer.status_code, answer.json()["error"]) == (500, "broken")
                assert str(tmp_path) not in answer.text
                assert acts(tmp_path, one.identity) == before
                await one.do()
            await one.play()

    asyncio.run(visit())
    for trial in load(tmp_path):
        assert as_played(trial) == as_played(without_page(STUDY, trial, "human-inspired"))


def told_alike():
    """Two boxes that lock differently, one told truly and one always falsely: the same joint seems to move in both."""
    chain = box("chain-4")
    free, locked = chain.names[-1], replace(chain, interlock={chain.names[-1]: ({chain.names[1]: True},)})
    for lockbox, p in ((chain, 0.0), (locked, 1.0)):
        study = replace(STUDY, boxes=(lockbox,), conditions=flips((p,), "outcome-only"), trials=1)
        plan = study.plan("participant", study.conditions[0], 1, 1)
        yield study, plan.names.labels[plan.box.names.index(free)]


def test_what_the_page_gets_hangs_on_what_was_told_alone(tmp_path):
    async def visit(study, label, directory):
        async with served(directory, study) as place, visiting(place) as one:
            await one.to_the_box()
            for _ in range(6):
                said = {"claimed": "moved", "claimed_rt": 2.0} if one.scene.ask else {}
                await one.act(kind="attempt", joint=label, rt=10, **said)
            return [json.loads(reply.replace(one.identity.encode(), b"")) for reply in one.replies]

    first, second = (asyncio.run(visit(*one, tmp_path / str(n))) for n, one in enumerate(told_alike()))
    assert len(first) >= 7
    assert first == second
