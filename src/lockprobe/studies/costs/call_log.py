"""The write-ahead log of provider calls (``asked.jsonl`` and ``calls.jsonl``), one line per call.

A reply that was paid for is never lost. A trial that was interrupted by a fault, a kill or the budget resumes at the
same point: its earlier calls are looked up, not repeated. The cost of a study is the sum of its calls, including those
of broken trials. Each request is written to ``asked.jsonl`` before it is sent, so that a kill hides no cost. The next
run records requests without a reply as broken off.
"""

from __future__ import annotations

import asyncio
import time
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter

from lockprobe.foundation.errors import Missing
from lockprobe.foundation.inputs import is_there
from lockprobe.foundation.storage.jsonl import LineFile, read_values, with_checksum
from lockprobe.studies.costs.budget import Budget
from lockprobe.studies.file_names import ASKED, CALLS
from lockprobe.trial.model_call import BROKEN_OFF, Call, Usage
from lockprobe.trial.plan import Plan

_adapter: TypeAdapter[Call] = TypeAdapter(Call)


def read_calls(directory: Path | str) -> Iterator[Call]:
    """The calls of a study in chronological order; empty if no provider was asked.

    Raises:
        BadFile: If a line is damaged.
    """
    yield from _read(Path(directory) / CALLS)


def read_asked(directory: Path | str) -> Iterator[Call]:
    """The requests of a study as they were written before they were sent, in chronological order.

    Raises:
        BadFile: If a line is damaged.
    """
    yield from _read(Path(directory) / ASKED)


def unanswered(directory: Path | str) -> list[Call]:
    """Requests without a recorded reply: in flight now, or when their run was killed.

    Raises:
        BadFile: If a line is damaged.
    """
    asked: defaultdict[str, list[Call]] = defaultdict(list)
    for call in read_asked(directory):  # before the calls, so that one asked meanwhile is in neither
        if call.unanswered and asked[call.key]:  # the same call, made again
            asked[call.key].pop()
        asked[call.key].append(call)
    came = (call.key for call in read_calls(directory) if not call.owed_anew) if asked else ()
    answered = Counter(came)
    return [call for key, calls in asked.items() for call in calls[answered[key] :]]


def _read(path: Path) -> Iterator[Call]:
    if is_there(path):
        yield from read_values(path, _adapter)


class KeptReplies:
    """The replies to one trial that are kept, in the order in which they came. Each is given out once.

    Two steps can have the same request, for example if an agent remembers nothing: then the first reply is that of the
    first step.
    """

    def __init__(self, replies: Iterable[Call] = ()) -> None:
        self.left = list(replies)

    def take(self, step: int, turn: int, request: str) -> Call | None:
        """The next reply to this request at this step and turn; None without one."""
        for i, call in enumerate(self.left):
            if (call.step, call.turn, call.request) == (step, turn, request):
                return self.left.pop(i)
        return None


def kept_replies(calls: Iterable[Call]) -> dict[str, list[Call]]:
    """The replies that trials still have, by key: those after the last mark that a trial is owed anew."""
    kept: dict[str, list[Call]] = {}
    for call in calls:
        if call.owed_anew:
            kept.pop(call.key, None)
        elif call.reply is not None:
            kept.setdefault(call.key, []).append(call)
    return kept


class Calls:
    """The open log of calls of a study. Use :meth:`open`."""

    def __init__(self, directory: Path) -> None:
        self._directory = directory
        self._files: dict[str, LineFile] = {}
        self._on_their_way: dict[str, tuple[Call, float]] = {}
        self._budget: Budget | None = None
        self._claimed: Call | None = None
        self._waiting: list[asyncio.Future[None]] = []
        self._listeners: list[Callable[[Call], None]] = []
        self._kept = kept_replies(read_calls(directory))

    @classmethod
    @contextmanager
    def open(cls, directory: Path) -> Iterator[Calls]:
        """Open the log of a directory, which the caller has locked. The first call creates the files.

        Raises:
            BadFile: If they cannot be read or written.
        """
        calls = cls(directory)
        try:
            for call in unanswered(directory):
                calls.write(replace(call, error=BROKEN_OFF))
            yield calls
        finally:
            for file in calls._files.values():
                file.close()

    def limit(self, budget: Budget) -> None:
        """Set the budget that no further call may exceed; calls of earlier runs count."""
        for call in read_calls(self._directory):
            budget.settle(call)
        self._budget = budget

    def listen(self, listener: Callable[[Call], None]) -> None:
        """Register a listener for every call that is written from now on."""
        self._listeners.append(listener)

    def has_replies(self, key: str) -> bool:
        """Whether a trial that is not finished has replies already, from which it goes on."""
        return bool(self._kept.get(key))

    def of(self, plan: Plan) -> _TrialCalls:
        """The calls of one trial; a fork also finds those of its parent trial (:meth:`adopt`)."""
        keys = [plan.key, *([plan.fork.name.parent] if plan.fork else [])]
        return _TrialCalls(self, plan, [KeptReplies(self._kept.get(key, ())) for key in keys])

    def adopt(self, calls: Iterable[Call]) -> None:
        """Also look up calls of another log, those of forked trials. They are not written and cost nothing."""
        calls = list(calls)
        for key, replies in kept_replies(calls).items():
            self._kept.setdefault(key, []).extend(replies)
        if self._budget is not None:
            for call in calls:
                self._budget.learn(call)

    @property
    def on_their_way(self) -> int:
        """Number of calls in flight."""
        return len(self._on_their_way)

    @property
    def longest_wait(self) -> float:
        """Age of the oldest call in flight, seconds; 0 without one."""
        return time.monotonic() - min((began for _, began in self._on_their_way.values()), default=time.monotonic())

    def admit(self, plan: Plan) -> bool:
        """Open a trial; False if open ones have to end first, because the budget does not cover it beside them.

        Raises:
            BudgetReached: If no trial is open and the budget does not cover this one.
        """
        return self._budget is None or self._budget.admit(plan)

    def end(self, key: str) -> None:
        """Close a trial that was admitted."""
        if self._budget is not None:
            self._budget.end(key)
            self._wake()

    async def turn(self, key: str, worst: Usage) -> None:
        """Wait until a trial may make its next call: earlier trials could need what the budget has left."""
        while self._budget is not None and not self._budget.has_turn(key, worst):
            await self._news()

    async def reserve(self, call: Call) -> None:
        """Write a call to disk before each attempt, and reserve the maximum cost of the attempt.

        If the budget is exceeded only because of calls in flight, wait for their replies.

        Raises:
            Missing: If a provider has reported an impossible count of tokens in this run.
            BudgetReached: If the budget does not cover the call.
            BadFile: If it cannot be written.
        """
        if self._claimed is not None:
            raise _incredible(self._claimed)
        while self._budget is not None and not self._budget.reserve(call):
            await self._news()
        self._append(ASKED, call)
        _, began = self._on_their_way.get(call.key, (call, time.monotonic()))
        self._on_their_way[call.key] = call, began

    def write(self, call: Call) -> None:
        """Write a call to disk, with or without a reply. A call of unknown cost keeps its maximum cost.

        Raises:
            BadFile: If it cannot be written.
        """
        asked, _ = self._on_their_way.pop(call.key, (call, 0.0))
        if call.broken_off:
            call = replace(call, unanswered=asked.unanswered)
        if call.unpriced:
            call = replace(call, most=asked.most)
        self._append(CALLS, call)
        if call.owed_anew:
            self.forget(call.key)
        elif call.reply is not None:
            self._kept.setdefault(call.key, []).append(call)
        self._claimed = self._claimed or (call if call.claimed is not None else None)
        if self._budget is not None:
            self._budget.settle(call)
        self._wake()
        for listener in self._listeners:
            listener(call)

    async def _news(self) -> None:
        """Wait until a call has returned or a trial has ended."""
        news = asyncio.get_running_loop().create_future()
        self._waiting.append(news)
        await news

    def _wake(self) -> None:
        waiting, self._waiting = self._waiting, []
        for news in waiting:
            if not news.done():
                news.set_result(None)

    def _append(self, name: str, call: Call) -> None:
        if name not in self._files:
            self._files[name] = LineFile(self._directory / name)
            self._files[name].cut_torn_tail()
        self._files[name].append(with_checksum(_adapter.dump_json(call, exclude_defaults=True)))

    @property
    def used(self) -> bool:
        """Whether any call was written since the log was opened."""
        return bool(self._files)

    def sync(self) -> None:
        """Flush to the disk (fsync)."""
        for file in self._files.values():
            file.sync()

    def forget(self, key: str) -> None:
        """Drop the calls of a finished trial from memory; they stay on disk."""
        self._kept.pop(key, None)


def _incredible(call: Call) -> Missing:
    """The error for an impossible count of tokens."""
    claimed = call.claimed or Usage()
    return Missing(
        f"{call.key}: its provider claims {claimed.input_tokens:,} tokens in and {claimed.output_tokens:,} out for a "
        f"call of at most {call.usage.input_tokens:,} and {call.usage.output_tokens:,}",
        "no more is asked; look at its count, then the same command goes on",
    )


class _TrialCalls:
    """The calls of one trial: those that it has, of itself and of its parent, and new ones."""

    def __init__(self, calls: Calls, plan: Plan, kept: Sequence[KeptReplies]) -> None:
        self._calls, self._kept, self._key, name = calls, kept, plan.key, plan.name
        self._place: dict[str, Any] = {
            "agent": plan.agent,
            "condition": name.condition,
            "repetition": name.repetition,
            "trial": name.trial,
        }

    def recall(self, step: int, turn: int, request: str) -> Call | None:
        return next((call for kept in self._kept if (call := kept.take(step, turn, request))), None)

    async def turn(self, worst: Usage) -> None:
        await self._calls.turn(self._key, worst)

    async def reserve(self, call: Call) -> None:
        await self._calls.reserve(self._placed(call))

    def write(self, call: Call) -> None:
        self._calls.write(self._placed(call))

    def _placed(self, call: Call) -> Call:
        return replace(call, **self._place)
