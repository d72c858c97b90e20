"""The server's address, the host names it accepts, and access from other machines."""

from __future__ import annotations

import re
from dataclasses import dataclass

from lockprobe.foundation.errors import BadValue, Missing

LOOPBACK = ("127.0.0.1", "localhost", "[::1]")
"""Names under which a browser on the same machine asks, and a proxy that keeps to its own."""

EVERYWHERE = ("0.0.0.0", "::", "")  # noqa: S104 - nothing is bound here
"""The addresses that mean every address of the machine."""

_NAME = re.compile(r"[A-Za-z0-9_]([A-Za-z0-9_.-]{0,251}[A-Za-z0-9_])?|\[[0-9A-Fa-f:.]{2,45}\]")


@dataclass(frozen=True, slots=True, kw_only=True)
class Address:
    """Where the server listens (port 0: any free one), and how browsers reach it.

    Attributes:
        public: The origin that participants use through a proxy, ``https://name`` or ``http://name:port``; empty
            without one.
        allowed: More names of this machine, without port.

    Raises:
        BadValue: If ``public`` is no origin, or a name is none.
        Missing: If the server listens everywhere, and there is neither a public origin nor another name.
    """

    host: str = "127.0.0.1"
    port: int = 8765
    public: str = ""
    allowed: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        for name in self.allowed:
            if not _NAME.fullmatch(name):
                raise BadValue("allow-host", name, "a host name or IP address without port, for example lab-pc.local")
        if self.public and not _origin_of(self.public):
            raise BadValue("public-url", self.public, "https://NAME, without a path")
        if self.host in EVERYWHERE and not (self.public or self.allowed):
            remedy = "give --public-url https://NAME, or --allow-host NAME on a local network"
            raise Missing(f"--host {self.host}: which name will browsers use", remedy)

    @property
    def url(self) -> str:
        """The address for participants; it ends with a slash."""
        return (self.public.rstrip("/") or self._origins[0]) + "/"

    @property
    def secure(self) -> bool:
        """Whether browsers connect over TLS, which a proxy terminates."""
        return self.public.startswith("https://")

    @property
    def origins(self) -> frozenset[str]:
        """The origins whose pages may post here, as browsers write them."""
        return frozenset({origin.lower() for origin in self._origins} | ({_origin_of(self.public)} - {""}))

    @property
    def hosts(self) -> frozenset[str]:
        """The accepted Host headers. Any other name is a foreign one that leads here (DNS rebinding)."""
        return frozenset(origin.partition("://")[2] for origin in self.origins)

    @property
    def _origins(self) -> list[str]:
        """Those without a proxy, that for participants first."""
        own = [] if self.host in EVERYWHERE else [f"[{self.host}]" if ":" in self.host else self.host]
        port = "" if self.port == 80 else f":{self.port}"
        return [f"http://{name}{port}" for name in (*own, *self.allowed, *LOOPBACK)]


def _origin_of(url: str) -> str:
    """An origin as browsers write it, in lower case and without the usual port; empty if the URL is none."""
    found = re.fullmatch(rf"(https?)://({_NAME.pattern})(?::([1-9][0-9]{{0,4}}))?/?", url.lower())
    if found is None:
        return ""
    scheme, name, port = found[1], found[2], found[4]
    usual = port in (None, {"http": "80", "https": "443"}[scheme])
    return f"{scheme}://{name}" + ("" if usual else f":{port}")
