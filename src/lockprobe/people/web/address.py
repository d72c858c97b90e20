"""The server's address, the host names it accepts, and access from other machines."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from urllib.parse import urlsplit

from lockprobe.foundation.errors import BadValue, Missing

LOOPBACK = ("127.0.0.1", "localhost", "[::1]")
"""Names under which a browser on the same machine asks, and a proxy that keeps to its own."""

EVERYWHERE = ("0.0.0.0", "::", "")  # noqa: S104 - nothing is bound here
"""The addresses that mean every address of the machine."""

_NAME = re.compile(r"[A-Za-z0-9_]([A-Za-z0-9_.-]{0,251}[A-Za-z0-9_])?|\[[0-9A-Fa-f:.]{2,45}\]")


@dataclass(frozen=True, slots=True, kw_only=True)
class Address:
    """Where the server listens, and how browsers reach it.

    Attributes:
        host: The name or IP address to listen on.
        port: The port.
        public: The origin that participants use, ``https://name`` or ``http://name:port``; empty for ``host``.
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
        """The address for participants; it ends with a slash."""
        return (self.public.rstrip("/") or self._origin((*self._own, *self.allowed, *LOOPBACK)[0])) + "/"

    @property
    def secure(self) -> bool:
        """Whether browsers connect over TLS, which a proxy terminates."""
        return self.public.startswith("https://")

    @property
    def origins(self) -> frozenset[str]:
        """The origins whose pages may post here, as browsers write them."""
        names = (*LOOPBACK, *self._own, *self.allowed)
        own = {self._origin(name.lower()) for name in names}
        return frozenset(own | ({_plain_origin(self.public)} if self.public else set()))

    @property
    def hosts(self) -> frozenset[str]:
        """The accepted Host headers. Any other name is a foreign one that leads here (DNS rebinding)."""
        return frozenset(origin.partition("://")[2] for origin in self.origins)

    @property
    def _own(self) -> tuple[str, ...]:
        """The name of ``host``; none where the server listens everywhere."""
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
    """An origin as browsers write it: lower case, without the default port of its scheme."""
    parts = urlsplit(url)
    usual = {"http": 80, "https": 443}[parts.scheme]
    name = f"[{parts.hostname}]" if ":" in (parts.hostname or "") else parts.hostname
    return f"{parts.scheme}://{name}" + ("" if parts.port in (None, usual) else f":{parts.port}")


def check_exposure(host: str, public: str, allowed: Sequence[str]) -> None:
    """Refuse access from other machines without a name of the server.

    Raises:
        Missing: If the server listens everywhere, and there is neither a public origin nor another name.
    """
    if host in EVERYWHERE and not (public or allowed):
        remedy = "give --public-url https://NAME, or --allow-host NAME on a local network"
        raise Missing(f"--host {host}: which name will browsers use", remedy)
