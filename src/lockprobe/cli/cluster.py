"""The option ``--cluster``: other machines for a command."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager

from lockprobe.foundation.terminal_text import printable
from lockprobe.foundation.workers import Cluster


@contextmanager
def reached(address: str | None) -> Iterator[Cluster | None]:
    """Connect to the cluster at an address, and print it on standard error; None without an address."""
    if address is None:
        yield None
        return
    with Cluster.connect(address) as cluster:
        nodes = [(host, processors) for host, processors in cluster.nodes if processors]
        said = ", ".join(f"{printable(host)} {processors}" for host, processors in nodes[:8]) or "none yet"
        more = f" and {len(nodes) - 8} more" if len(nodes) > 8 else ""
        print(f"Cluster: processors of {said}{more}", file=sys.stderr)
        yield cluster
