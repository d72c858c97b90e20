"""Requests on their way at once have pools of their own; those that follow each other share one."""

import asyncio

import pytest

from lockprobe.agents.model_access import Access

httpx = pytest.importorskip("httpx2")
connections = pytest.importorskip("lockprobe.agents.llm.connections")
connect = pytest.importorskip("lockprobe.agents.llm.connect")
MODEL = "openai-api/fake/model"


@pytest.fixture
def sending(monkeypatch):
    """The HTTP client of a model, as it is opened for a study."""
    monkeypatch.setenv("FAKE_BASE_URL", "http://127.0.0.1:9/v1")
    monkeypatch.setenv("FAKE_API_KEY", "none")
    return connect.opened(MODEL, Access(), {}).api.client._client


async def heard(reader):
    """A request, or nothing where the connection was closed."""
    try:
        return await reader.readuntil(b"\r\n\r\n")
    except asyncio.IncompleteReadError:
        return b""


async def serving(reader, writer):
    """Answer every request on a connection with its number on that connection."""
    number = 0
    while await heard(reader):
        number += 1
        await asyncio.sleep(0.02)
        writer.write(b"HTTP/1.1 200 OK\r\ncontent-length: 1\r\n\r\n%d" % number)
    writer.close()


def fared(sending, course):
    """What becomes of a course, a function of the client and a URL, with a server that counts by connection."""

    async def run():
        server = await asyncio.start_server(serving, "127.0.0.1", 0)
        try:
            return await course(sending, f"http://127.0.0.1:{server.sockets[0].getsockname()[1]}/")
        finally:
            await sending.aclose()
            server.close()
            await asyncio.sleep(0.05)  # until the server has noticed

    return asyncio.run(run())


def pools(sending):
    return len(sending._transport._pools)


def test_requests_at_once_have_a_pool_each(sending):
    async def course(client, url):
        first = [answer.text for answer in await asyncio.gather(*(client.get(url) for _ in range(5)))]
        then = [answer.text for answer in await asyncio.gather(*(client.get(url) for _ in range(5)))]
        return first, then

    assert fared(sending, course) == (["1"] * 5, ["2"] * 5)
    assert pools(sending) == 5
    assert {len(pool._kwargs["socket_options"]) > 0 for pool in sending._transport._pools} == {True}


def test_requests_one_after_the_other_share_a_connection(sending):
    async def course(client, url):
        return [(await client.get(url)).text for _ in range(4)]

    assert fared(sending, course) == ["1", "2", "3", "4"]
    assert pools(sending) == 1


def test_a_request_that_fails_or_is_given_up_gives_its_pool_back(sending):
    async def course(client, url):
        with pytest.raises(httpx.ConnectError):
            await client.get("http://127.0.0.1:9/")
        with pytest.raises(TimeoutError):
            async with asyncio.timeout(0.005):
                await client.get(url)
        async with client.stream("GET", url) as unread:
            pass
        return unread.status_code, (await client.get(url)).text

    assert fared(sending, course)[0] == 200
    assert pools(sending) == 1


def test_proxies_go_through_the_pools_as_they_were(monkeypatch):
    monkeypatch.setenv("HTTPS_PROXY", "http://127.0.0.1:9")
    monkeypatch.setenv("FAKE_BASE_URL", "https://models.example/v1")
    monkeypatch.setenv("FAKE_API_KEY", "none")
    sending = connect.opened(MODEL, Access(), {}).api.client._client
    transport = sending._transport_for_url(httpx.URL("https://models.example/v1"))
    assert isinstance(transport, connections.LoopScopedTransport)


@pytest.mark.parametrize("client", [None, object()])
def test_other_clients_are_left_alone(client):
    connections.spread_connections(client)
