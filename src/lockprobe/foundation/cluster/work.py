"""Jobs on the processors of a Ray cluster.

This process, the driver, hands out jobs and collects their results. On every processor of the cluster, an actor sets
itself up once and then works on the jobs that it receives. Ray's own retries are off, because Ray may report an actor
as lost that has done its work. Instead the driver requeues the jobs of a lost actor and ignores its results, so every
job has exactly one result. Losing actors is normal. The work ends only if actors are lost three times in a row with
nothing finished in between.
"""

from __future__ import annotations

import math
import platform
import socket
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from importlib.metadata import version
from typing import Any, Generic, TypeVar, cast

from lockprobe.foundation.cluster.connection import connected
from lockprobe.foundation.errors import Missing, UserMistake
from lockprobe.foundation.terminal_text import readable

_J = TypeVar("_J")
_R = TypeVar("_R")

_LOSSES = 3
"""Attempts of a job before it counts as lost; also the most losses of actors in a row."""

_PATIENCE = 600.0
"""Seconds after which a silent actor is given up, or 20 times the longest answer so far if that is longer."""

_AT_ONCE = 0.25
"""Seconds of work that are sent at once. A call takes the driver and the network some milliseconds."""

_LOOK = 1.0
"""Seconds after which the driver looks for new processors and for actors that do not answer."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Node:
    """A machine of a cluster.

    Attributes:
        host: Its name.
        processors: Number of jobs that it runs in parallel.
    """

    host: str
    processors: int


@dataclass(frozen=True, slots=True)
class Lost:
    """The result of a job whose actors were all lost.

    Attributes:
        why: The reason why the last actor was lost.
    """

    why: str


@dataclass(frozen=True, slots=True)
class _BatchResult(Generic[_R]):
    results: list[_R]
    seconds: float


@dataclass(slots=True)
class _QueuedJob(Generic[_J]):
    value: _J
    losses: int = 0


@dataclass(slots=True)
class _ActorCall(Generic[_J]):
    """A pending call of an actor; its first call has no jobs and sets the actor up."""

    actor: Any
    jobs: list[_QueuedJob[_J]] = field(default_factory=list)
    since: float = field(default_factory=time.monotonic)


class _Actor:
    """A worker on a processor of the cluster. Its only state is the function that ``begin`` returned."""

    def __init__(self, begin: Callable[[], Callable[[Any], Any]]) -> None:
        self._begin = begin

    def ready(self) -> tuple[str, dict[str, str], str]:
        """Set up; returns the host, its versions, and a message if the user has to fix something."""
        try:
            self._work = self._begin()
        except UserMistake as mistake:
            return socket.gethostname(), _versions(), str(mistake)
        return socket.gethostname(), _versions(), ""

    def work(self, jobs: list[Any]) -> _BatchResult[Any]:
        began = time.perf_counter()
        return _BatchResult([self._work(job) for job in jobs], time.perf_counter() - began)


class Cluster:
    """A connection to a Ray cluster. Use :meth:`connect`."""

    def __init__(self, ray: Any) -> None:
        self._ray = ray

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

    def map(self, work: Callable[[_J], _R], jobs: Sequence[_J], /) -> Iterator[_R]:
        """Yield the results in the order of the jobs; see :class:`lockprobe.foundation.parallel.Pool`.

        Raises:
            Missing: If actors keep being lost.
        """
        kept: dict[int, _R] = {}
        following = 0
        for (number, _), result in self.each(_NumberedWork(work), list(enumerate(jobs))):
            if isinstance(result, Lost):
                raise Missing(f"a part of the work was lost on {_LOSSES} processors ({result.why})", "is there memory?")
            kept[number] = result
            while following in kept:
                yield kept.pop(following)
                following += 1

    def each(self, begin: Callable[[], Callable[[_J], _R]], jobs: Iterable[_J]) -> Iterator[tuple[_J, _R | Lost]]:
        """Yield each job with its one result, in the order in which results arrive.

        Args:
            begin: Called once in every actor; returns the function that works on a job. It is sent by name, so it has
                to be part of an installed package.
            jobs: The jobs.

        Raises:
            UserMistake: As ``begin`` raises it.
            Missing: If nodes have other versions, or actors keep being lost with nothing finished in between.
        """
        work = _Driver(self, begin, jobs)
        try:
            yield from work.results()
        finally:
            work.stop()

    def hire(self, begin: Callable[[], Callable[[Any], Any]]) -> Any:
        """Create an actor, which starts when a processor is free."""
        kind = self._ray.remote(num_cpus=1, max_restarts=0, max_task_retries=0)(_Actor)
        return kind.remote(begin)

    def dismiss(self, actor: Any) -> None:
        """Kill an actor; its pending calls are lost."""
        with suppress(Exception):  # it may be gone
            self._ray.kill(actor)

    def answered(self, calls: Sequence[Any], seconds: float) -> list[Any]:
        """The calls that are finished or lost; waits up to this many seconds for the first of them."""
        found, _ = self._ray.wait(list(calls), num_returns=1, timeout=seconds)
        if found and len(calls) > 1:
            found, _ = self._ray.wait(list(calls), num_returns=len(calls), timeout=0)
        return cast(list[Any], found)

    def answer(self, call: Any) -> Any:
        """The result of a call, or :class:`Lost`.

        Raises:
            Exception: The exception that the job raised.
        """
        errors = self._ray.exceptions
        try:
            return self._ray.get(call, timeout=_PATIENCE)
        except errors.RayTaskError as raised:
            raise (raised.cause or raised) from None
        except errors.RayError as error:  # lost, or unavailable: then it may have done its work all the same
            return Lost(type(error).__name__)


@dataclass(frozen=True, slots=True)
class _NumberedWork(Generic[_J, _R]):
    """A stateless function applied to numbered jobs, for :meth:`Cluster.map`."""

    work: Callable[[_J], _R]

    def __call__(self) -> Callable[[tuple[int, _J]], _R]:
        return lambda job: self.work(job[1])


class _Driver(Generic[_J, _R]):
    """The driver's side of :meth:`Cluster.each`."""

    def __init__(self, cluster: Cluster, begin: Callable[[], Callable[[_J], _R]], jobs: Iterable[_J]) -> None:
        self._cluster = cluster
        self._begin = begin
        self._queue = deque(_QueuedJob(job) for job in jobs)
        self._calls: dict[Any, _ActorCall[_J]] = {}
        self._lost_in_a_row = 0
        self._counted = -math.inf
        self._seconds = _AT_ONCE  # of one job, as measured
        self._longest = 0.0
        self._processors = 0
        self._looked = -_LOOK

    def results(self) -> Iterator[tuple[_J, _R | Lost]]:
        while self._queue or any(call.jobs for call in self._calls.values()):
            self._hire_actors()
            for reference in self._cluster.answered(list(self._calls), _LOOK):
                yield from self._receive(reference)
            patience = max(_PATIENCE, 20 * self._longest)
            late = [one for one, call in self._calls.items() if call.jobs and time.monotonic() - call.since > patience]
            for reference in late:
                yield from self._requeue_lost(reference, "it did not answer")

    def stop(self) -> None:
        for call in self._calls.values():
            self._cluster.dismiss(call.actor)
        self._calls.clear()

    def _hire_actors(self) -> None:
        """Create actors up to the number of processors or jobs; processors may join and leave."""
        if time.monotonic() - self._looked >= _LOOK:
            self._looked = time.monotonic()
            self._processors = max(1, sum(node.processors for node in self._cluster.nodes))
        busy = sum(bool(call.jobs) for call in self._calls.values())
        wanted = min(self._processors, busy + len(self._queue))
        for _ in range(wanted - len(self._calls)):
            actor = self._cluster.hire(self._begin)
            self._calls[actor.ready.remote()] = _ActorCall(actor)

    def _receive(self, reference: Any) -> Iterator[tuple[_J, _R | Lost]]:
        call = self._calls[reference]
        answer = self._cluster.answer(reference)
        if isinstance(answer, Lost):
            yield from self._requeue_lost(reference, answer.why)
            return
        if not isinstance(answer, _BatchResult):
            _check_ready(*answer)
            self._send(reference)
            return
        self._lost_in_a_row, self._counted = 0, time.monotonic()
        self._longest = max(self._longest, time.monotonic() - call.since)
        self._seconds = (self._seconds + answer.seconds / len(call.jobs)) / 2
        self._send(reference)  # so that it works while its results are written down
        for job, result in zip(call.jobs, answer.results, strict=True):
            yield job.value, result

    def _send(self, reference: Any) -> None:
        """Send an idle actor its next jobs; dismiss it if there are none."""
        actor, jobs = self._calls.pop(reference).actor, self._next_batch()
        if not jobs:
            self._cluster.dismiss(actor)
            return
        reference = actor.work.remote([job.value for job in jobs])
        self._calls[reference] = _ActorCall(actor, jobs)

    def _next_batch(self) -> list[_QueuedJob[_J]]:
        """The next batch: jobs for about a quarter of a second, fewer at the end; a lost job goes alone."""
        most = min(_AT_ONCE / max(self._seconds, 1e-6), len(self._queue) / (2 * max(1, self._processors)))
        jobs: list[_QueuedJob[_J]] = []
        while self._queue and len(jobs) < max(1, most) and not (jobs and self._queue[0].losses):
            jobs.append(self._queue.popleft())
            if jobs[0].losses:
                break
        return jobs

    def _requeue_lost(self, reference: Any, why: str) -> Iterator[tuple[_J, Lost]]:
        """Requeue the jobs of a lost actor at the end; yield those that were lost too often."""
        call = self._calls.pop(reference)
        self._cluster.dismiss(call.actor)
        if call.since > self._counted:  # what is lost together, as with its node, is one loss
            self._lost_in_a_row, self._counted = self._lost_in_a_row + 1, time.monotonic()
        for job in call.jobs:
            job.losses += 1
            if job.losses >= _LOSSES:
                yield job.value, Lost(why)
            else:
                self._queue.append(job)
        if self._lost_in_a_row >= _LOSSES:
            raise Missing(
                f"the cluster lost its workers {_LOSSES} times in a row, with nothing finished in between ({why})",
                "do its nodes have memory enough? nothing finished is lost; run the same command again",
            )


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
