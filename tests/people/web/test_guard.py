"""By which names a server is asked for, what passes its guard, and what every answer carries.

Raw ASGI: what no client would send is sent too.
"""

import asyncio
import io
import json

import pytest

from lockprobe.foundation.errors import BadValue, Missing
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
    asyncio.run(Guard(app, ADDRESS, (guard_log or ServerLog(io.BytesIO())).refused)(scope, receive, send))
    start, text = sent[0], b"".join(message.get("body", b"") for message in sent)
    return start["status"], {name.decode(): value.decode() for name, value in start["headers"]}, text, passed


@pytest.mark.parametrize(
    ("address", "url", "host", "secure"),
    [
        ({}, "http://127.0.0.1:8765/", "localhost:8765", False),
        ({"public": "https://Study.Example.org:443/"}, "https://Study.Example.org:443/", "study.example.org", True),
        ({"host": "0.0.0.0", "port": 80, "allowed": ("lab-pc.local",)}, "http://lab-pc.local/", "lab-pc.local", False),
        ({"host": "192.168.1.5", "port": 80}, "http://192.168.1.5/", "192.168.1.5", False),
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
          "https://a:0", "https://a:99999", "https://a b", "https://[::1", "javascript:alert(1)"]  # fmt: skip


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


PASSES = [
    *(
        {"host": host}
        for host in ("localhost:8765", "[::1]:8765", "LOCALHOST:8765", "study.example.org", "lab-pc:8765")
    ),
    {"headers": JSON | {"origin": "https://study.example.org", "sec-fetch-site": "same-origin"}},
    {"headers": JSON | {"origin": "http://localhost:8765"}},
    {"headers": {"content-type": "application/json; charset=UTF-8"}},
    {"method": "GET", "path": "/", "headers": {"sec-fetch-site": "cross-site"}, "body": (b"",)},  # a link of others
]


@pytest.mark.parametrize("request_", PASSES)
def test_its_own_page_and_names_pass(request_):
    status, _, _, passed = ask(**request_)
    assert (status, len(passed)) == (200, 1)


def test_a_body_comes_whole_and_once():
    assert ask(body=(b'{"a"', b": 1", b"}"))[3] == [b'{"a": 1}']
    assert ask(body=(b"x" * LARGEST_BODY,))[3] == [b"x" * LARGEST_BODY]


HOSTS = (None, "", "evil.example", "127.0.0.1", "127.0.0.1:80", "study.example.org.evil.example", "localhost:8765@evil")
FOREIGN = [
    *({"origin": origin} for origin in ("https://evil.example", "null", "http://study.example.org",
                                        "https://study.example.org:8443")),
    *({"sec-fetch-site": site} for site in ("cross-site", "same-site", "none")),
    {"origin": "https://study.example.org", "sec-fetch-site": "cross-site"},
]  # fmt: skip
NO_JSON = ("text/plain", "application/x-www-form-urlencoded", "multipart/form-data; boundary=x",
           "application/json; charset=utf-16")  # fmt: skip
REFUSED = [
    *(({"host": host}, 403, "cross-site") for host in HOSTS),
    *(
        ({"headers": JSON | one, "method": method}, 403, "cross-site")
        for one in FOREIGN
        for method in ("POST", "DELETE")
    ),
    ({"method": "GET", "path": "/api/open", "headers": {"sec-fetch-site": "cross-site"}}, 403, "cross-site"),
    ({"headers": {}}, 415, "not-json"),
    *(({"headers": {"content-type": kind}}, 415, "not-json") for kind in NO_JSON),
    ({"headers": JSON | {"content-encoding": "gzip"}}, 415, "not-json"),
    ({"headers": JSON | {"content-length": "2", "transfer-encoding": "chunked"}}, 400, "malformed"),
    ({"body": (b"x" * (LARGEST_BODY + 1),)}, 413, "too-large"),
    ({"body": (b"x" * 4096,) * 5}, 413, "too-large"),
    ({"headers": JSON | {"content-length": str(LARGEST_BODY + 1)}, "body": (None,)}, 413, "too-large"),
    ({"headers": JSON | {"content-length": "9" * 400}, "body": (None,)}, 413, "too-large"),
    ({"body": (b"{", None, b"}")}, 400, "malformed"),
]


@pytest.mark.parametrize(("request_", "status", "code"), REFUSED)
def test_anything_else_is_refused_and_passes_nothing_on(monkeypatch, request_, status, code):
    monkeypatch.setattr("lockprobe.people.web.guard.SECONDS_FOR_A_BODY", 0.05)
    found, headers, text, passed = ask(**request_)
    assert (found, json.loads(text)["error"], passed) == (status, code, [])
    assert SECURITY_HEADERS.items() <= headers.items()
    assert headers["cache-control"] == "no-store"
    assert "access-control-allow-origin" not in headers


def test_too_many_bodies_at_once_are_refused(monkeypatch):
    monkeypatch.setattr("lockprobe.people.web.guard.AT_ONCE", 0)
    assert ask()[0] == 429


def test_refusals_are_logged_without_what_was_sent(capsys):
    file = io.BytesIO()
    sent = JSON | {"origin": "https://evil.example", "cookie": "lockprobe=secret"}
    ask(headers=sent, body=(b'{"secret": 1}',), guard_log=ServerLog(file, clock=lambda: 0.0))
    assert file.getvalue() == b"1970-01-01T00:00:00Z 403 cross-site POST /api/act\n"
    assert capsys.readouterr().err == file.getvalue().decode()
