"""The log of calls to providers: each is on disk before it is sent, and its reply as soon as it arrives.

A reply that was paid for is never lost. A trial that was interrupted by a fault, a kill or the budget resumes at the
same point: its earlier calls are looked up, not repeated. The cost of a study is the sum of its calls, including those
of broken trials. A call is written as broken off, with its maximum cost, until it has an outcome: so a kill leaves it.
Calls that come at the same time share one commit, and so do a reply and the call that follows from it.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from itertools import count
from pathlib import Path

from pydantic import TypeAdapter, ValidationError

from lockprobe.foundation.errors import Missing
from lockprobe.foundation.grouping import grouped
from lockprobe.foundation.inputs import is_there
from lockprobe.foundation.storage.database import Damaged, Database
from lockprobe.studies.costs.spending import Budget, spent_by_agent
from lockprobe.studies.records.store import STORE, check_row, checksum, read
from lockprobe.trial.model_call import BROKEN_OFF, Call
from lockprobe.trial.plan import Plan

_adapter: TypeAdapter[Call] = TypeAdapter(Call)

_TURNS = 8
"""Turns of the event loop, less than a millisecond, in which others that are ready come to a commit too."""


def read_calls(directory: Path | str) -> list[Call]:
    """The calls of a study in the order in which they were asked; empty if no provider was asked.

    One that is on its way, or was when its run was killed, is broken off.
    """
    if not is_there(Path(directory) / STORE):
        return []
    with read(directory) as store:
        return [*_calls_in(store)]


def _calls_in(store: Database) -> Iterator[Call]:
    for number, key, said, crc in store.rows("select * from call order by id"):
        check_row(store, f"call {number}, {key}", crc, key, said)
        try:
            call = _adapter.validate_json(said, strict=True, extra="forbid")
        except ValidationError as error:
            raise Damaged(store.path, f"call {number}, {key}: {error.errors()[0]['msg']}") from None
        if call.key != key:
            raise Damaged(store.path, f"call {number} is not one of {key}")
        yield call


def kept_replies(calls: Iterable[Call]) -> dict[str, list[Call]]:
    """The replies of each trial by key."""
    return grouped((call for call in calls if call.reply is not None), lambda call: call.key)


def take(kept: Iterable[list[Call]], step: int, turn: int, request: str) -> Call | None:
    """The first reply to this request at this step and turn, which is then no longer among those kept; None without.

    Two steps can have the same request, for example if an agent remembers nothing: then the first reply is that of the
    first step.
    """
    for calls in kept:
        for i, call in enumerate(calls):
            if (call.step, call.turn, call.request) == (step, turn, request):
                return calls.pop(i)
    return None


class Calls:
    """The open log of calls of a study.

    Attributes:
        spent: Agent -> the cost of its calls that have an outcome, in earlier runs too.
        budget: What no further call may exceed.
    """

    def __init__(self, store: Database) -> None:
        self._store = store
        self._on_their_way: dict[str, tuple[int, Call, float]] = {}
        self.budget: Budget | None = None
        self._claimed: Call | None = None
        self._news = asyncio.Event()
        self._numbers = count(store.one("select coalesce(max(id), 0) from call")[0] + 1)
        self._rows: list[tuple[int, str, str, int]] = []
        self._commit: asyncio.Task[None] | None = None
        logged = [*_calls_in(store)]
        self.spent, self._kept = spent_by_agent(logged), kept_replies(logged)
        for (key,) in store.rows("select key from trial where current and not owed") if self._kept else ():
            self.forget(key)

    def has_replies(self, key: str) -> bool:
        """Whether a trial that is not finished has replies already, from which it goes on."""
        return bool(self._kept.get(key))

    def of(self, plan: Plan) -> TrialCalls:
        """The calls of one trial; a fork also finds those of its parent trial (:meth:`adopt`)."""
        keys = [plan.key, *([plan.fork.name.parent] if plan.fork else [])]
        return TrialCalls(self, plan.agent, [[*self._kept.get(key, ())] for key in keys])

    def adopt(self, calls: Iterable[Call]) -> None:
        """Also look up calls of another log, those of forked trials. They are not written and cost nothing."""
        for key, replies in kept_replies(calls).items():
            self._kept.setdefault(key, []).extend(replies)

    def forget(self, key: str) -> None:
        """Drop the calls of a finished trial from memory; they stay on disk."""
        self._kept.pop(key, None)

    @property
    def most(self) -> float:
        """What these have cost at most, US dollars."""
        return sum(one.most for one in self.spent.values())

    @property
    def on_their_way(self) -> tuple[int, float]:
        """Number of calls in flight, and the age of the oldest in seconds, 0 without one."""
        now, began = time.monotonic(), [began for *_, began in self._on_their_way.values()]
        return len(began), now - min(began, default=now)

    async def reserve(self, call: Call) -> None:
        """Write a call to disk before each attempt, and reserve the maximum cost of the attempt.

        If the budget is exceeded only because of calls in flight, wait for their replies.

        Raises:
            Missing: If a provider has reported an impossible count of tokens in this run.
            BudgetReached: If the budget does not cover the call.
            BadFile: If it cannot be written.
        """
        if (one := self._claimed) is not None and one.claimed is not None:
            raise Missing(
                f"{one.key}: its provider claims {one.claimed.input_tokens:,} tokens in and "
                f"{one.claimed.output_tokens:,} out for a call of at most {one.usage.input_tokens:,} and "
                f"{one.usage.output_tokens:,}",
                "no more is asked; look at its count, then the same command goes on",
            )
        while self.budget is not None and not self.budget.reserve(call, self.most):
            await self._news.wait()
        known = self._on_their_way.get(call.key)
        number, began = (next(self._numbers), time.monotonic()) if known is None else (known[0], known[2])
        self._on_their_way[call.key] = number, call, began
        try:
            await self._put(number, call)
        except BaseException:  # it is not sent, and leaves nothing; of one that was before, its caller writes what came
            if known is None:
                del self._on_their_way[call.key]
                self._settle(call)
                self._rows = [row for row in self._rows if row[0] != number]
                with self._store.transaction() as writing:
                    writing.execute("delete from call where id = ?", (number,))
            raise

    async def write(self, call: Call) -> None:
        """Write a call to disk, with or without a reply. A call of unknown cost keeps its maximum cost."""
        number, asked, _ = self._on_their_way.pop(call.key, None) or (next(self._numbers), call, 0.0)
        if call.broken_off:
            call = replace(call, retries=asked.retries, unanswered=asked.unanswered, usage=asked.usage)
        if call.unpriced:
            call = replace(call, most=asked.most)
        if call.reply is not None:
            self._kept.setdefault(call.key, []).append(call)
        self._claimed = self._claimed or (call if call.claimed is not None else None)
        self.spent = spent_by_agent([call], self.spent)
        self._settle(call)
        # from its reply a trial goes on meanwhile, but alone, where its plant might hold up the commit
        await self._put(number, call, wait=call.reply is None or not self._on_their_way)

    def _settle(self, call: Call) -> None:
        """What was reserved for a call is free, and whoever waits asks the budget again."""
        if self.budget is not None:
            self.budget.release(call)
        self._news.set()
        self._news = asyncio.Event()

    async def _put(self, number: int, call: Call, *, wait: bool = True) -> None:
        """Write a row with all others that are to be written before the next commit, and wait for the disk."""
        said = _adapter.dump_json(call, exclude_defaults=True).decode()
        self._rows.append((number, call.key, said, checksum(call.key, said)))
        if self._commit is None or self._commit.done():
            self._commit = asyncio.create_task(self._written())
            self._commit.add_done_callback(lambda it: it.cancelled() or it.exception())  # which the next commit repeats
        if wait:
            await self.committed()

    async def committed(self) -> None:
        """Wait until all calls so far are on disk."""
        if self._rows and self._commit is not None:
            try:
                await asyncio.shield(self._commit)  # which others wait for
            except asyncio.CancelledError:  # nobody may be left to wait for it
                self._write_rows()
                raise

    async def _written(self) -> None:
        for _ in range(_TURNS):
            await asyncio.sleep(0)
        self._write_rows()

    def _write_rows(self) -> None:
        if self._rows:
            with self._store.transaction(sync=True) as writing:
                writing.executemany("insert or replace into call values (?, ?, ?, ?)", self._rows)
            self._rows = []


class TrialCalls:
    """The calls of one trial: those that it has, of itself and of its parent, and new ones."""

    def __init__(self, calls: Calls, agent: str, kept: Sequence[list[Call]]) -> None:
        self._calls, self._agent, self._kept = calls, agent, kept

    def recall(self, step: int, turn: int, request: str) -> Call | None:
        """A reply to this request that is kept; None without one."""
        return take(self._kept, step, turn, request)

    async def reserve(self, call: Call) -> None:
        """See :meth:`Calls.reserve`."""
        await self._calls.reserve(replace(call, agent=self._agent, error=BROKEN_OFF))

    async def write(self, call: Call) -> None:
        """See :meth:`Calls.write`."""
        await self._calls.write(replace(call, agent=self._agent, most=None))
