"""Workers that are actors on the processors of a Ray cluster.

Ray's own retries are off, because Ray may report an actor as lost that has done its work.
"""

from __future__ import annotations

import platform
import socket
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from importlib.metadata import version
from typing import Any, ClassVar, cast

from lockprobe.foundation.errors import Missing, UserMistake
from lockprobe.foundation.terminal_text import readable
from lockprobe.foundation.workers.pool import BatchResult, Begin, Lost, Pool, Ready
from lockprobe.foundation.workers.ray_connection import connected


@dataclass(frozen=True, slots=True, kw_only=True)
class Node:
    """A machine of a cluster.

    Attributes:
        host: Its name.
        processors: Number of jobs that it runs in parallel.
    """

    host: str
    processors: int


class _Actor:
    """A worker on a processor of the cluster. Its only state is the function that ``begin`` returned."""

    def __init__(self, begin: Begin[Any, Any]) -> None:
        self._begin = begin

    def ready(self) -> tuple[str, dict[str, str], str]:
        """Set up; returns the host, its versions, and a message if the user has to fix something."""
        try:
            self._work = self._begin()
        except UserMistake as mistake:
            return socket.gethostname(), _versions(), str(mistake)
        return socket.gethostname(), _versions(), ""

    def work(self, jobs: Sequence[Any]) -> BatchResult:
        return BatchResult.of(self._work, jobs)


class Cluster(Pool):
    """A connection to a Ray cluster. Use :meth:`connect`."""

    losses: ClassVar[int] = 3
    patience: ClassVar[float] = 600.0

    def __init__(self, ray: Any) -> None:
        self._ray = ray
        self.remedy = "do the nodes of the cluster have memory enough? nothing finished is lost; run the command again"

    @classmethod
    @contextmanager
    def connect(cls, address: str) -> Iterator[Cluster]:
        """Connect to a running cluster.

        Args:
            address: ``HOST:PORT`` of its head node, or ``auto`` for the one that runs on this machine.

        Raises:
            BadValue: If it is no such address.
            Missing: If Ray is not installed, the cluster does not answer, refuses the token, or has other versions.
        """
        with connected(address) as ray:
            yield cls(ray)

    @property
    def nodes(self) -> tuple[Node, ...]:
        """The machines of the cluster that are up."""
        alive = [one for one in self._ray.nodes() if one["Alive"]]
        return tuple(
            Node(host=str(one["NodeManagerHostname"]), processors=int(one["Resources"].get("CPU", 0))) for one in alive
        )

    def processors(self) -> int:
        """Those of all nodes that are up."""
        return sum(node.processors for node in self.nodes)

    def hire(self, begin: Begin[Any, Any]) -> tuple[Any, Any]:
        """Create an actor, which starts when a processor is free."""
        actor = self._ray.remote(num_cpus=1, max_restarts=0, max_task_retries=0)(_Actor).remote(begin)
        return actor, actor.ready.remote()

    def send(self, worker: Any, jobs: Sequence[Any]) -> Any:
        """Call an actor."""
        return worker.work.remote(jobs)

    def answered(self, references: Sequence[Any], seconds: float, hear: Callable[[Any], None]) -> list[Any]:
        """The calls that are finished or lost; what actors say meanwhile is not heard."""
        found, _ = self._ray.wait(list(references), num_returns=1, timeout=seconds)
        if found and len(references) > 1:
            found, _ = self._ray.wait(list(references), num_returns=len(references), timeout=0)
        return cast(list[Any], found)

    def answer(self, reference: Any) -> Ready | BatchResult | Lost:
        """The result of a call.

        Raises:
            Missing: If the node has other versions, or lacks something.
            Exception: The exception that the job raised.
        """
        errors = self._ray.exceptions
        try:
            found = self._ray.get(reference, timeout=self.patience)
        except errors.RayTaskError as raised:
            raise (raised.cause or raised) from None
        except errors.RayError as error:  # lost, or unavailable: then it may have done its work all the same
            return Lost(type(error).__name__)
        if isinstance(found, BatchResult):
            return found
        _check_ready(*found)
        return Ready()

    def dismiss(self, worker: Any) -> None:
        """Kill an actor; its pending calls are lost."""
        with suppress(Exception):  # it may be gone
            self._ray.kill(worker)


def _versions() -> dict[str, str]:
    return {"lockprobe": version("lockprobe"), "Ray": version("ray"), "Python": platform.python_version()}


def _check_ready(host: str, there: dict[str, str], mistake: str) -> None:
    """Refuse a node with other versions or a failed set-up.

    Raises:
        Missing: If it has other versions, or lacks something.
    """
    for name, here in _versions().items():
        if there[name] != here:
            found = f"the node {readable(host)} has {name} {readable(there[name])}, this machine {here}"
            raise Missing(found, "install the same on all")
    if mistake:
        raise Missing(f"the node {readable(host)} cannot play: {readable(mistake)}", "install the same on all nodes")
