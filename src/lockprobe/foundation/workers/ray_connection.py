"""The connection to a Ray cluster. This is the only module that imports Ray.

Whoever may submit work to a Ray cluster may run any code there. So a cluster is reached with a token, and only from the
command line or from Python, never because of a file.
"""

from __future__ import annotations

import logging
import os
import socket
import tempfile
from collections.abc import Iterator
from contextlib import chdir, contextmanager
from typing import Any

from lockprobe.foundation.errors import BadValue, Missing
from lockprobe.foundation.terminal_text import readable

_SETTINGS = {
    "RAY_AUTH_MODE": "token",
    "RAY_ENABLE_UV_RUN_RUNTIME_ENV": "0",  # else it packs the working directory and builds an environment on each node
    "RAY_USAGE_STATS_ENABLED": "0",
}
"""Environment variables that Ray reads when it is imported."""

_REACHED = 5.0
"""Seconds in which the cluster's address has to answer."""


@contextmanager
def connected(address: str) -> Iterator[Any]:
    """The module ``ray``, connected to a running cluster, as :meth:`~.cluster.Cluster.connect` has it."""
    _check_reachable(address)
    for name, value in _SETTINGS.items():
        os.environ.setdefault(name, value)
    try:
        import ray
    except ImportError:
        raise Missing("--cluster needs the package ray", "pip install 'lockprobe[cluster]'") from None
    try:
        # workers get the working directory of this process as part of their import path: an empty one
        with _standard_error() as said, tempfile.TemporaryDirectory() as empty, chdir(empty):
            ray.init(address=address, log_to_driver=False, logging_level=logging.ERROR)
    except (OSError, RuntimeError, ValueError, ray.exceptions.RayError) as error:
        raise _unreachable(address, error, said[0]) from None
    from ray._private import worker

    # no events of nodes on standard output, which carries the lines of --json
    worker.print_to_stdstream = lambda *_, **__: None
    try:
        yield ray
    finally:
        ray.shutdown()


def _check_reachable(address: str) -> None:
    """Refuse an invalid address, and one without a listener, for which Ray would wait a minute.

    Raises:
        BadValue: If it is not an address.
        Missing: If nothing answers.
    """
    if address == "auto":
        return
    host, _, port = address.rpartition(":")
    if not host or "/" in address or not port.isascii() or not port.isdigit() or not 0 < int(port) < 65536:
        raise BadValue("cluster", address, "auto, or HOST:PORT of the head node")
    try:
        socket.create_connection((host.strip("[]"), int(port)), timeout=_REACHED).close()
    except (OSError, UnicodeError) as error:
        why = getattr(error, "strerror", None) or "no answer"
        raise Missing(f"no Ray cluster answers at {address} ({why})", "is its head node running?") from None


@contextmanager
def _standard_error() -> Iterator[list[str]]:
    """Capture standard error, including that of C libraries; the text is in the list after the block."""
    said: list[str] = []
    with tempfile.TemporaryFile() as file:
        kept = os.dup(2)
        os.dup2(file.fileno(), 2)
        try:
            yield said
        finally:
            os.dup2(kept, 2)
            os.close(kept)
            file.seek(0)
            said.append(file.read(100_000).decode("utf-8", "replace"))


def _unreachable(address: str, error: Exception, written: str) -> Missing:
    """The reason why Ray could not connect, in one line."""
    said, token = readable(" ".join(str(error).split())), "copy ~/.ray/auth_token from the head node to this machine"
    if "InvalidAuthToken" in written:
        return Missing(f"the Ray cluster at {address} has another token", token)
    if "oken" in said:
        return Missing(f"no token for a Ray cluster is here (--cluster {address})", f"{token}, or set RAY_AUTH_TOKEN")
    if "ersion mismatch" in said:
        return Missing(f"the Ray cluster at {address} has other versions ({said[:300]})", "install the same on all")
    if address == "auto" and isinstance(error, ConnectionError):
        return Missing("no Ray cluster runs on this machine", "ray start --head --port=6399, then the same command")
    return Missing(f"the Ray cluster at {address} cannot be used: {said[:300]}", "see docs/cluster.md")
