"""The rate limit on joining, per address: no script can take all places of a study at once."""

from __future__ import annotations

import ipaddress
import time
from collections import deque
from collections.abc import Callable

from starlette.requests import Request

from lockprobe.people.web.refusals import RequestRefused

__all__ = ["JoinLimit", "whence"]

_WINDOW = 60.0
"""Seconds over which joins are counted."""

_NETWORK = 64
"""Bits of an IPv6 address that one household or laboratory has; the rest anybody there can choose."""


class JoinLimit:
    """At most ``most`` joins per minute from one address. Addresses stay in memory for that minute only.

    ``clock`` is monotonic, in seconds.
    """

    def __init__(self, most: int, clock: Callable[[], float] = time.monotonic) -> None:
        self._most, self._clock = most, clock
        self._joins: dict[str, deque[float]] = {}

    def reserve(self, address: str) -> None:
        """Count a person who is about to join.

        Raises:
            RequestRefused: As ``busy``; the page retries by itself.
        """
        now = self._clock()
        self._forget(now)
        joins = self._joins.setdefault(address, deque())
        while joins and joins[0] <= now - _WINDOW:
            joins.popleft()
        if len(joins) >= self._most:
            raise RequestRefused("busy", "too many join from this address; try again in a minute")
        joins.append(now)
        self._joins[address] = self._joins.pop(address)  # the latest last

    def give_back(self, address: str) -> None:
        """Uncount the last person, who has not joined."""
        if joins := self._joins.get(address):
            joins.pop()

    def _forget(self, now: float) -> None:
        """Drop addresses from which nobody joined for a minute."""
        while self._joins:
            address, joins = next(iter(self._joins.items()))
            if joins and joins[-1] > now - _WINDOW:
                break
            del self._joins[address]


def whence(request: Request, *, proxied: bool) -> str:
    """The address of a request, for counting only.

    Behind a proxy (``proxied``) it is the last address of ``X-Forwarded-For``, which the proxy itself writes. It is
    read only from a proxy on this machine or, with ``--public-url``, on the local network. IPv6 addresses count by
    network.
    """
    peer = request.client.host if request.client else ""
    last = request.headers.get("x-forwarded-for", "").rpartition(",")[2].strip()
    return _network(last) or _network(peer) if _is_proxy(peer, proxied=proxied) else _network(peer)


def _is_proxy(peer: str, *, proxied: bool) -> bool:
    try:
        address = ipaddress.ip_address(peer)
    except ValueError:
        return proxied
    return address.is_loopback or (proxied and address.is_private)


def _network(text: str) -> str:
    """An IPv4 address, or the network of an IPv6 one; empty for anything else."""
    try:
        address = ipaddress.ip_address(text)
    except ValueError:
        return ""
    if isinstance(address, ipaddress.IPv6Address) and address.ipv4_mapped is None:
        return str(ipaddress.ip_network((address, _NETWORK), strict=False))
    return str(getattr(address, "ipv4_mapped", None) or address)
