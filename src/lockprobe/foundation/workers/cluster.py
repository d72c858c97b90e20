"""Workers that are actors on the processors of a Ray cluster. This is the only module that imports Ray.

Ray's own retries are off, because Ray may report an actor as lost that has done its work. Whoever may submit work to a
Ray cluster may run any code there. So a cluster is reached with a token, and only from the command line or from Python,
never because of a file.
"""

from __future__ import annotations

import logging
import os
import platform
import socket
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import chdir, contextmanager, suppress
from dataclasses import dataclass
from importlib.metadata import version
from typing import Any, ClassVar

from lockprobe.foundation.errors import BadValue, Missing, UserMistake, needing
from lockprobe.foundation.terminal_text import readable
from lockprobe.foundation.workers.pool import Begin, Lost, Pool

_SETTINGS = {
    "RAY_AUTH_MODE": "token",
    "RAY_ENABLE_UV_RUN_RUNTIME_ENV": "0",  # else it packs the working directory and builds an environment on each node
    "RAY_USAGE_STATS_ENABLED": "0",
}
"""Environment variables that Ray reads when it is imported."""

_REACHED = 5.0
"""Seconds in which the cluster's address has to answer; Ray itself would wait a minute."""


class _Actor:
    """A worker on a processor of the cluster. Its only state is the function that ``begin`` returned."""

    def __init__(self, begin: Begin[Any, Any]) -> None:
        self._begin = begin

    def ready(self) -> tuple[str, dict[str, str], str]:
        """Set up; returns the host, its versions, and a message if the user has to fix something."""
        mistake = ""
        try:
            self._work = self._begin()
        except UserMistake as error:
            mistake = str(error)
        return socket.gethostname(), _versions(), mistake

    def work(self, job: Any) -> Any:
        return self._work(job)


@dataclass(slots=True, eq=False)
class _Hired:
    """An actor, its call that has no answer yet, and whether it had been set up before."""

    actor: Any
    call: Any
    ready: bool = False


class Cluster(Pool):
    """A connection to a Ray cluster. Use :meth:`connect`."""

    losses: ClassVar[int] = 3
    remedy = "do the nodes of the cluster have memory enough? nothing finished is lost; run the command again"

    def __init__(self, ray: Any) -> None:
        self._ray = ray

    @classmethod
    @contextmanager
    def connect(cls, address: str) -> Iterator[Cluster]:
        """Connect to a running cluster: ``HOST:PORT`` of its head node, or ``auto`` for the one on this machine."""
        host, _, port = address.rpartition(":")
        if address != "auto":
            if not host or "/" in address or not (port.isascii() and port.isdigit() and 0 < int(port) < 65536):
                raise BadValue("cluster", address, "auto, or HOST:PORT of the head node")
            try:
                socket.create_connection((host.strip("[]"), int(port)), timeout=_REACHED).close()
            except (OSError, UnicodeError) as error:
                why = getattr(error, "strerror", None) or "no answer"
                raise Missing(f"no Ray cluster answers at {address} ({why})", "is its head node running?") from None
        for name, value in _SETTINGS.items():
            os.environ.setdefault(name, value)
        with needing("clusters", "cluster"):
            import ray
        try:
            # workers get the working directory of this process as part of their import path: an empty one
            with tempfile.TemporaryDirectory() as empty, chdir(empty):
                ray.init(address=address, log_to_driver=False, logging_level=logging.ERROR)
        except (OSError, RuntimeError, ValueError, ray.exceptions.RayError) as error:
            said = readable(" ".join(str(error).split()))[:300]
            remedy = (
                "is it started, of the same versions, and its ~/.ray/auth_token on this machine? see docs/cluster.md"
            )
            raise Missing(f"the Ray cluster at {address} cannot be used ({said})", remedy) from None
        from ray._private import worker

        # no events of nodes on standard output, which carries the lines of --json
        worker.print_to_stdstream = lambda *_, **__: None
        try:
            yield cls(ray)
        finally:
            ray.shutdown()

    def processors(self) -> int:
        """Those of all nodes that are up."""
        return sum(int(one["Resources"].get("CPU", 0)) for one in self._ray.nodes() if one["Alive"])

    def hire(self, begin: Begin[Any, Any]) -> _Hired:
        """Create an actor, which starts when a processor is free."""
        actor = self._ray.remote(num_cpus=1, max_restarts=0, max_task_retries=0)(_Actor).remote(begin)
        return _Hired(actor, actor.ready.remote())

    def send(self, worker: _Hired, job: Any) -> None:
        """Call an actor."""
        worker.call = worker.actor.work.remote(job)
        worker.ready = True

    def answers(self, workers: Sequence[_Hired], seconds: float) -> Iterator[tuple[_Hired, Any]]:
        """The results of calls that are finished or lost; ``Missing`` if a node has other versions, or lacks something.

        A lost actor, or one that cannot be reached, may have done its work all the same.
        """
        calls = {worker.call: worker for worker in workers}
        ended, _ = self._ray.wait([*calls], num_returns=1, timeout=seconds)
        for call in ended:
            try:
                found = self._ray.get(call)
            except self._ray.exceptions.RayTaskError as raised:
                raise (raised.cause or raised) from None
            except self._ray.exceptions.RayError as error:
                yield calls[call], Lost(type(error).__name__)
                continue
            if not calls[call].ready:
                host, there, mistake = found
                here = _versions()
                other = [f"{name} {there[name]}, not {here[name]}" for name in here if there[name] != here[name]]
                if other or mistake:
                    why = f"has {' and '.join(other)}" if other else f"cannot play: {mistake}"
                    raise Missing(readable(f"the node {host} {why}"), "install the same on all nodes")
            yield calls[call], found

    def dismiss(self, worker: _Hired, *, idle: bool) -> None:
        """Kill an actor; its pending calls are lost."""
        with suppress(Exception):  # it may be gone
            self._ray.kill(worker.actor)


def _versions() -> dict[str, str]:
    return {"lockprobe": version("lockprobe"), "Ray": version("ray"), "Python": platform.python_version()}
