"""The socket that a server listens on, and the token of those who may use it."""

from __future__ import annotations

import ipaddress
import re
import socket

from lockprobe.foundation.errors import BadValue

__all__ = ["QUEUE", "SHORTEST_TOKEN", "check_token", "is_loopback", "listen"]

SHORTEST_TOKEN = 16

QUEUE = 2048
"""Connections that wait to be accepted; the operating system may allow fewer."""


def is_loopback(host: str) -> bool:
    """Whether only this machine can reach the host."""
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


def check_token(variable: str, token: str) -> None:
    """Refuse a token that is short or does not fit in a header. The message does not repeat it.

    Args:
        variable: The variable of the environment that holds the token.
        token: The token.

    Raises:
        BadValue: If it is one.
    """
    if len(token) < SHORTEST_TOKEN or not re.fullmatch(r"[!-~]+", token):
        expected = f"{SHORTEST_TOKEN} or more of letters, digits and signs, without spaces"
        raise BadValue(variable, f"{len(token)} characters", expected)


def listen(host: str, port: int) -> socket.socket:
    """A listening socket; port 0 takes any free port.

    Raises:
        BadValue: If the host or the port cannot be used.
    """
    try:
        family, kind, protocol, _, address = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0]
    except (OSError, UnicodeError):
        raise BadValue("host", host, "a name or IP address of this machine") from None
    found = socket.socket(family, kind, protocol)
    try:
        found.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        found.bind(address)
        found.listen(QUEUE)
    except OSError as error:
        found.close()
        raise BadValue("port", port, f"a free port of {host} ({error.strerror})") from None
    found.setblocking(False)
    return found
