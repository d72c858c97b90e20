"""The addresses of the server: where it listens, which names it answers to, and when it may be reached from outside."""

from __future__ import annotations

import ipaddress
import re
import socket
from collections.abc import Sequence
from dataclasses import dataclass
from urllib.parse import urlsplit

from lockprobe.errors import BadValue, Missing

__all__ = [
    "ADMIN_TOKEN",
    "QUEUE",
    "SHORTEST_TOKEN",
    "Address",
    "check_exposure",
    "check_token",
    "is_loopback",
    "listen",
]

ADMIN_TOKEN = "LOCKPROBE_ADMIN_TOKEN"  # noqa: S105 - its name
"""The variable of the environment that holds the token of the admin page."""

SHORTEST_TOKEN = 16

QUEUE = 2048
"""Connections that wait to be accepted; the operating system may allow fewer."""

LOOPBACK = ("127.0.0.1", "localhost", "[::1]")
"""Names under which a browser on the same machine asks, and a proxy that keeps to its own."""

EVERYWHERE = ("0.0.0.0", "::", "")  # noqa: S104 - nothing is bound here
"""What is listened on where every address of the machine is."""

_NAME = re.compile(r"[A-Za-z0-9_]([A-Za-z0-9_.-]{0,251}[A-Za-z0-9_])?|\[[0-9A-Fa-f:.]{2,45}\]")


@dataclass(frozen=True, slots=True, kw_only=True)
class Address:
    """Where the server listens, and how browsers get there.

    Attributes:
        host: What is listened on, a name or an IP address.
        port: The port.
        public: Origin under which participants come, ``https://name`` or ``http://name:port``; empty where they come
            to ``host`` itself.
        allowed: More names of this machine, without port.

    Raises:
        BadValue: If ``public`` is no origin, or a name is none.
    """

    host: str
    port: int
    public: str = ""
    allowed: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        for name in self.allowed:
            if not _NAME.fullmatch(name):
                raise BadValue("allow-host", name, "a host name or IP address without port, for example lab-pc.local")
        if self.public and not _is_origin(self.public):
            raise BadValue("public-url", self.public, "https://NAME, without a path")

    @property
    def url(self) -> str:
        """Where participants go; it ends with a slash."""
        return (self.public.rstrip("/") or self._origin((*self._own, *self.allowed, *LOOPBACK)[0])) + "/"

    @property
    def secure(self) -> bool:
        """Whether browsers come over TLS, which a proxy in front ends."""
        return self.public.startswith("https://")

    @property
    def origins(self) -> frozenset[str]:
        """The origins whose pages may post here, as browsers write them."""
        names = (*LOOPBACK, *self._own, *self.allowed)
        own = {self._origin(name.lower()) for name in names}
        return frozenset(own | ({_plain_origin(self.public)} if self.public else set()))

    @property
    def hosts(self) -> frozenset[str]:
        """What the Host of a request may be. Another one is a foreign name that leads here (DNS rebinding)."""
        return frozenset(origin.partition("://")[2] for origin in self.origins)

    @property
    def _own(self) -> tuple[str, ...]:
        """The name of what is listened on; everywhere has none."""
        if self.host in EVERYWHERE:
            return ()
        return (f"[{self.host}]",) if ":" in self.host else (self.host,)

    def _origin(self, name: str) -> str:
        return f"http://{name}" + ("" if self.port == 80 else f":{self.port}")


def _is_origin(url: str) -> bool:
    try:
        parts = urlsplit(url)
        port_is_one = parts.port is None or parts.port > 0
    except ValueError:
        return False
    name = f"[{parts.hostname}]" if parts.hostname and ":" in parts.hostname else parts.hostname
    alone = parts.path in ("", "/") and not (parts.query or parts.fragment or "@" in parts.netloc)
    return parts.scheme in ("http", "https") and bool(name and _NAME.fullmatch(name)) and alone and port_is_one


def _plain_origin(url: str) -> str:
    """An origin as browsers write it: in small letters, without the port that its scheme has anyway."""
    parts = urlsplit(url)
    usual = {"http": 80, "https": 443}[parts.scheme]
    name = f"[{parts.hostname}]" if ":" in (parts.hostname or "") else parts.hostname
    return f"{parts.scheme}://{name}" + ("" if parts.port in (None, usual) else f":{parts.port}")


def is_loopback(host: str) -> bool:
    """Whether only this machine can reach what listens there."""
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


def check_token(token: str) -> None:
    """Refuse an admin token that could be guessed, or that no header can hold.

    Raises:
        BadValue: If it is one; the message does not hold it.
    """
    if len(token) < SHORTEST_TOKEN or not re.fullmatch(r"[!-~]+", token):
        expected = f"{SHORTEST_TOKEN} or more of letters, digits and signs, without spaces"
        raise BadValue(ADMIN_TOKEN, f"{len(token)} characters", expected)


def check_exposure(host: str, token: str | None, public: str, allowed: Sequence[str]) -> None:
    """Refuse to be reached from other machines before it was said how.

    Args:
        host: What is to be listened on.
        token: The token of the admin page from the environment; None if there is none.
        public: Origin under which participants come; empty if there is no other.
        allowed: More names by which this machine is asked for.

    Raises:
        Missing: If there is no token, or no name.
    """
    if is_loopback(host):
        return
    if token is None:
        raise Missing(f"--host {host} lets other machines in", f"export {ADMIN_TOKEN}=… ({SHORTEST_TOKEN}+ characters)")
    if host in EVERYWHERE and not (public or allowed):
        remedy = "give --public-url https://NAME, or --allow-host NAME on a local network"
        raise Missing(f"--host {host}: by which name will browsers ask for it", remedy)


def listen(host: str, port: int) -> socket.socket:
    """A socket that listens.

    Args:
        host: A name or an IP address.
        port: The port; 0 for any that is free.

    Raises:
        BadValue: If it cannot be had.
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
        raise BadValue("port", port, f"a port of {host} that can be had ({error.strerror})") from None
    found.setblocking(False)
    return found
