"""Sessions at their limit: the one that is needed least ends, as if its client had ended it."""

import asyncio

import pytest

pytest.importorskip("mcp")

from lockprobe.interfaces.mcp.client_sessions import ClientSessions

HOST = (b"host", b"127.0.0.1:1")


class App:
    """Gives sessions their IDs as the library does, without a limit, and records what it was asked."""

    def __init__(self):
        self.open, self.number, self.go_on = set(), 0, asyncio.Event()

    async def __call__(self, scope, receive, send):
        if scope["type"] != "http":
            return
        given = dict(scope["headers"]).get(b"mcp-session-id", b"").decode()
        assert dict(scope["headers"])[b"host"] == b"127.0.0.1:1"
        if scope["path"] == "/wait":
            await self.go_on.wait()
        headers, status = [], 200
        if given:
            status = 200 if given in self.open else 404
            if scope["method"] == "DELETE":
                self.open.discard(given)
        elif scope["path"] == "/refused":
            status = 400
        else:
            self.number += 1
            self.open.add(str(self.number))
            headers = [(b"Mcp-Session-Id", str(self.number).encode())]
        await send({"type": "http.response.start", "status": status, "headers": headers})
        await send({"type": "http.response.body", "body": b""})


class Place:
    def __init__(self, most=3):
        self.app, self.playing = App(), ""
        self.sessions = ClientSessions(self.app, lambda: self.playing, most)

    async def ask(self, session="", method="POST", path="/mcp"):
        answers = []

        async def send(message):
            answers.append(message)

        headers = [HOST, *([(b"mcp-session-id", session.encode())] if session else [])]
        scope = {"type": "http", "method": method, "path": path, "headers": headers}
        await self.sessions(scope, None, send)
        return answers[0]["status"]

    def begin(self, session="", method="POST"):
        """A request that is under way until the application goes on."""
        return asyncio.create_task(self.ask(session, method, "/wait"))


def told(do):
    async def run():
        place = Place()
        await do(place)
        return place

    return asyncio.run(run())


def test_the_longest_unused_session_ends_and_no_other():
    async def do(place):
        for _ in range(3):
            await place.ask()
        assert await place.ask("1") == 200
        await place.ask()
        assert place.app.open == {"1", "3", "4"}
        assert await place.ask("2") == 404

    told(do)


def test_any_number_of_clients_come_and_go():
    async def do(place):
        for _ in range(200):
            assert await place.ask() == 200
        assert place.app.open == {"198", "199", "200"}

    told(do)


def test_requests_that_open_no_session_end_none():
    async def do(place):
        for _ in range(3):
            await place.ask()
        for _ in range(5):
            assert await place.ask(path="/refused") == 400
            assert await place.ask("nobody") == 404
        assert place.app.open == {"1", "2", "3"}

    told(do)


def test_sessions_that_end_themselves_make_room():
    async def do(place):
        for _ in range(3):
            await place.ask()
        await place.ask("2", "DELETE")
        assert await place.ask("2") == 404
        await place.ask()
        assert place.app.open == {"1", "3", "4"}

    told(do)


def test_calls_that_are_being_answered_the_player_and_open_streams_are_spared_in_this_order():
    async def do(place):
        for _ in range(3):
            await place.ask()
        answered, listening = place.begin("1"), place.begin("2", "GET")
        await asyncio.sleep(0)
        place.playing = "3"
        for gone in ("2", "4", "5"):  # the stream, since one plays; then the unused ones
            await place.ask()
            assert gone not in place.app.open
        assert {"1", "3"} < place.app.open
        place.app.go_on.set()
        await asyncio.gather(answered, listening)

    told(do)


def test_at_the_end_open_streams_end_and_calls_are_answered():
    async def do(place):
        for _ in range(3):
            await place.ask()
        answered, listening = place.begin("1"), place.begin("2", "GET")
        await asyncio.sleep(0)
        await place.sessions.close()
        assert place.app.open == {"1"}
        place.app.go_on.set()
        assert await answered == 200
        await listening

    told(do)


def test_what_is_no_request_passes():
    async def do(place):
        await place.sessions({"type": "lifespan"}, None, None)

    told(do)
