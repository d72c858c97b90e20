"""What passes the guard, and what every answer carries. Raw ASGI: what no client would send is sent too."""

import asyncio
import io
import json

import pytest

from lockprobe.people.web.address import Address
from lockprobe.people.web.guard import LARGEST_BODY, SECURITY_HEADERS, Guard
from lockprobe.people.web.log import ServerLog

ADDRESS = Address(host="127.0.0.1", port=8765, public="https://study.example.org", allowed=("lab-pc",))
JSON = {"content-type": "application/json"}


def ask(method="POST", path="/api/act", headers=None, body=(b"{}",), host="127.0.0.1:8765", guard_log=None):
    """What the guard answers, and the bodies that it let through."""
    passed, sent = [], []
    chunks = list(body)

    async def app(scope, receive, send):
        passed.append((await receive())["body"])
        await send({"type": "http.response.start", "status": 200, "headers": []})
        await send({"type": "http.response.body", "body": b"fine"})

    async def receive():
        if not chunks:
            return {"type": "http.disconnect"}
        chunk = chunks.pop(0)
        if chunk is None:
            await asyncio.sleep(3600)
        return {"type": "http.request", "body": chunk, "more_body": bool(chunks)}

    async def send(message):
        sent.append(message)

    given = [*({} if host is None else {"host": host}).items(), *(JSON if headers is None else headers).items()]
    scope = {
        "type": "http",
        "method": method,
        "path": path,
        "raw_path": path.encode(),
        "headers": [(name.encode(), value.encode()) for name, value in given],
    }
    asyncio.run(Guard(app, ADDRESS, guard_log or ServerLog(io.BytesIO()))(scope, receive, send))
    start, text = sent[0], b"".join(message.get("body", b"") for message in sent)
    return start["status"], {name.decode(): value.decode() for name, value in start["headers"]}, text, passed


@pytest.mark.parametrize(
    "host",
    ["127.0.0.1:8765", "localhost:8765", "[::1]:8765", "LOCALHOST:8765", "study.example.org", "lab-pc:8765"],
)
def test_its_own_names_pass(host):
    assert ask(host=host)[0] == 200


@pytest.mark.parametrize(
    "host",
    [None, "", "evil.example", "127.0.0.1", "127.0.0.1:80", "study.example.org.evil.example", "localhost:8765@evil"],
)
def test_other_names_are_foreign(host):
    status, _, text, passed = ask(host=host)
    assert (status, json.loads(text)["error"], passed) == (403, "cross-site", [])


@pytest.mark.parametrize(
    "headers",
    [
        {},
        {"origin": "https://study.example.org", "sec-fetch-site": "same-origin"},
        {"origin": "http://localhost:8765"},
        {"content-type": "application/json; charset=UTF-8"},
    ],
)
def test_its_own_page_can_post(headers):
    assert ask(headers=JSON | headers)[0] == 200


@pytest.mark.parametrize(
    "headers",
    [
        {"origin": "https://evil.example"},
        {"origin": "null"},
        {"origin": "http://study.example.org"},
        {"origin": "https://study.example.org:8443"},
        {"sec-fetch-site": "cross-site"},
        {"sec-fetch-site": "same-site"},
        {"sec-fetch-site": "none"},
        {"origin": "https://study.example.org", "sec-fetch-site": "cross-site"},
    ],
)
@pytest.mark.parametrize("method", ["POST", "DELETE"])
def test_other_pages_cannot_post(headers, method):
    status, _, text, passed = ask(headers=JSON | headers, method=method)
    assert (status, json.loads(text)["error"], passed) == (403, "cross-site", [])


def test_other_pages_may_link_to_it_and_cannot_read_it():
    foreign = {"sec-fetch-site": "cross-site"}
    assert ask("GET", "/", foreign, (b"",))[0] == 200
    assert ask("GET", "/api/open", foreign, (b"",))[0] == 403


@pytest.mark.parametrize(
    "headers",
    [
        {},
        {"content-type": "text/plain"},
        {"content-type": "application/x-www-form-urlencoded"},
        {"content-type": "multipart/form-data; boundary=x"},
        {"content-type": "application/json; charset=utf-16"},
        {"content-type": "application/json", "content-encoding": "gzip"},
    ],
)
def test_a_body_is_json(headers):
    status, _, text, passed = ask(headers=headers)
    assert (status, json.loads(text)["error"], passed) == (415, "not-json", [])


def test_a_body_comes_whole_and_once():
    assert ask(body=(b'{"a"', b": 1", b"}"))[3] == [b'{"a": 1}']
    assert ask(body=(b"x" * LARGEST_BODY,))[3] == [b"x" * LARGEST_BODY]


@pytest.mark.parametrize(
    ("headers", "body"),
    [
        ({}, (b"x" * (LARGEST_BODY + 1),)),
        ({}, (b"x" * 4096,) * 5),
        ({"content-length": str(LARGEST_BODY + 1)}, (None,)),
        ({"content-length": "9" * 400}, (None,)),
    ],
)
def test_a_large_body_is_refused_while_it_comes(headers, body):
    status, _, text, passed = ask(headers=JSON | headers, body=body)
    assert (status, json.loads(text)["error"], passed) == (413, "too-large", [])


def test_a_body_that_does_not_come_is_not_waited_for(monkeypatch):
    monkeypatch.setattr("lockprobe.people.web.guard.SECONDS_FOR_A_BODY", 0.05)
    status, _, text, passed = ask(body=(b"{", None, b"}"))
    assert (status, json.loads(text)["error"], passed) == (400, "malformed", [])


def test_too_many_bodies_at_once_are_refused(monkeypatch):
    monkeypatch.setattr("lockprobe.people.web.guard.AT_ONCE", 0)
    status, _, text, passed = ask()
    assert (status, json.loads(text)["error"], passed) == (429, "busy", [])


@pytest.mark.parametrize("path", ["/", "/api/act", "/nowhere"])
@pytest.mark.parametrize("host", ["localhost:8765", "evil.example"])
def test_every_answer_carries_the_headers(path, host):
    headers = ask(path=path, host=host)[1]
    assert SECURITY_HEADERS.items() <= headers.items()
    assert headers["cache-control"] == "no-store"
    assert "unsafe" not in headers["content-security-policy"]
    assert "access-control-allow-origin" not in headers


def test_refusals_are_logged_without_what_was_sent(capsys):
    file = io.BytesIO()
    ask(
        path="/api/act",
        headers=JSON | {"origin": "https://evil.example", "cookie": "lockprobe=secret"},
        body=(b'{"secret": 1}',),
        guard_log=ServerLog(file, clock=lambda: 0.0),
    )
    assert file.getvalue() == b"1970-01-01T00:00:00Z 403 cross-site POST /api/act\n"
    assert capsys.readouterr().err == file.getvalue().decode()


def test_a_large_head_is_refused():
    for headers in ({"x": "a" * 20_000}, {f"x{i}": "a" * 20 for i in range(1000)}):
        assert ask(headers=JSON | headers)[0] == 413
    assert ask(path="/" + "a" * 20_000)[0] == 413


def test_a_body_of_two_lengths_is_refused():
    status, _, text, passed = ask(headers=JSON | {"content-length": "2", "transfer-encoding": "chunked"})
    assert (status, json.loads(text)["error"], passed) == (400, "malformed", [])
