"""The socket that a server listens on."""

from __future__ import annotations

import ipaddress
import socket

from lockprobe.foundation.errors import BadValue

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
