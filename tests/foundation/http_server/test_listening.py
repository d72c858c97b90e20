"""Where a server listens, and which addresses are this machine's."""

import socket

import pytest

from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.http_server.listening import is_loopback, listen


@pytest.mark.parametrize(
    ("host", "alone"),
    [
        ("127.0.0.1", True),
        ("127.8.8.8", True),
        ("::1", True),
        ("localhost", True),
        ("0.0.0.0", False),
        ("::", False),
        ("10.0.0.1", False),
        ("example.org", False),
        ("", False),
    ],
)
def test_loopback_is_known(host, alone):
    assert is_loopback(host) is alone


def test_a_port_in_use_and_a_foreign_host_are_said():
    with listen("127.0.0.1", 0) as first:
        port = first.getsockname()[1]
        with pytest.raises(BadValue, match=rf"port: got {port}.*in use"):
            listen("127.0.0.1", port)
    with pytest.raises(BadValue, match="a free port"):
        listen("192.0.2.1", 0)
    with pytest.raises(BadValue, match="host"):
        listen("no such host", 0)
    with listen("localhost", 0) as found:
        assert isinstance(found, socket.socket)
