"""The replies of hosted models held against the records: every decision is a reply, and every reply is a decision."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from itertools import zip_longest
from pathlib import Path

from lockprobe.foundation.grouping import grouped
from lockprobe.foundation.storage.jsonl import whole_lines
from lockprobe.report.verify.check import Check, also
from lockprobe.report.verify.replay import ReplayedTrial
from lockprobe.studies.costs.call_log import kept_replies, read_asked, read_calls, unanswered
from lockprobe.studies.file_names import RECORDS
from lockprobe.trial.model_call import Call
from lockprobe.trial.plan import Plan
from lockprobe.trial.record import Trial
from lockprobe.trial.trial_json import trial_from_line


class LoggedCalls:
    """The calls of a directory and its requests, in chronological order.

    ``kept`` has the replies of each trial, those after the last mark that it is owed anew.

    Raises:
        BadFile: If a line is damaged.
    """

    def __init__(self, directory: Path) -> None:
        self.directory = directory
        self.calls, self.asked = tuple(read_calls(directory)), tuple(read_asked(directory))
        self.kept: Mapping[str, Sequence[Call]] = kept_replies(self.calls)


def replies_held(
    name: str, log: LoggedCalls, trials: Mapping[str, Trial], again: Sequence[ReplayedTrial], owed: Mapping[str, Plan]
) -> Iterator[Check]:
    """Whether decisions of hosted models are the replies in a log, and all of them; no check without model or call.

    Args:
        name: The name of the check.
        log: The log.
        trials: The trials on record, by key.
        again: What follows of them.
        owed: Trials that are planned and not finished, by key.
    """
    hosted = [one for one in again if one.kind == "hosted"]
    if not (hosted or log.calls or log.asked):
        return
    failed = [
        f"{one.key}: {one.choices if log.kept.get(one.key) else 'calls.jsonl has no reply of it'}"
        for one in hosted
        if one.choices
    ]
    failed += dict.fromkeys(_misplaced(log, {**owed, **trials}))
    waiting = dict.fromkeys(call.key for call in unanswered(log.directory) if call.key not in owed)
    failed += (f"{key}: a request in asked.jsonl has no call" for key in waiting)
    failed += (*_not_asked(log), *_marks(log, trials))
    before = sum(call.reply is not None for call in log.calls) - sum(map(len, log.kept.values()))
    unplayed = "of these trials are not played, and held by their words and joints alone"
    holds = f"{sum(len(log.kept.get(one.key, ())) for one in hosted)} replies in calls.jsonl are the decisions of "
    holds += f"{len(hosted)} trials, and all of them{also(sum(one.unplayed for one in hosted), unplayed)}"
    holds += also(before, "earlier replies are of trials that were played again on request")
    yield Check.of(name, failed, "{n} contradictions between calls.jsonl and trials.jsonl", holds)


def _misplaced(log: LoggedCalls, known: Mapping[str, Trial | Plan]) -> Iterator[str]:
    """Calls and requests of no trial on record or owed, or of another agent or place: costs go by agent."""
    for call in (*log.calls, *log.asked):
        one, place = known.get(call.key), (call.agent, call.condition, call.repetition, call.trial)
        if one is None:
            yield f"{call.key}: calls of no trial on record"
        elif place != (one.agent, one.name.condition, one.repetition, one.trial):
            yield f"{call.key}: its calls name another trial or agent"


def _not_asked(log: LoggedCalls) -> Iterator[str]:
    """Calls without the request that was written before it was sent, and counts of lost attempts below those there.

    Calls that an import brought have no requests; they come before all others of their trial. A call that broke is
    made again when its trial is resumed: calls of one place have their lost attempts together.
    """
    asked, made, begun = grouped(log.asked, _place), grouped(log.calls, _place), set[str]()
    for place, requests in asked.items():
        # each call begins to count at 0
        ends = (one for one, after in zip_longest(requests, requests[1:]) if not (after and after.unanswered))
        lost, counted = sum(one.unanswered for one in ends), sum(call.unanswered for call in made.get(place, ()))
        if place in made and counted < lost:
            yield f"{place[0]}: step {place[1]} had {lost} attempts without an answer, not {counted}"
    for call in (one for one in log.calls if not one.owed_anew):
        if requests := asked.get(_place(call), []):
            begun.add(call.key)
            if call.most is not None and call.most not in [one.most for one in requests]:
                yield f"{call.key}: step {call.step} could cost {requests[-1].most}, not {call.most}"
        elif call.key in begun:
            yield f"{call.key}: the call of step {call.step}, turn {call.turn}, is not in asked.jsonl"


def _place(call: Call) -> tuple[str, int, int, str]:
    return call.key, call.step, call.turn, call.request


def _marks(log: LoggedCalls, trials: Mapping[str, Trial]) -> Iterator[str]:
    """Trials whose marks in the log of calls are not those of their records: played again on request, or not."""
    marks, again = Counter(call.key for call in log.calls if call.owed_anew), Counter[str]()
    if not marks and not any(trial.replays for trial in trials.values()):
        return
    for _, line in whole_lines(log.directory / RECORDS):
        if b'"again":true' in line:
            copy, _ = trial_from_line(line)
            again[copy.key] += copy.error is not None and copy.error.again
    for key, trial in trials.items():
        replays = trial.replays + (trial.error is not None and trial.error.again)
        if not marks[key] == again[key] == replays:
            yield (
                f"{key}: owed anew {marks[key]} times in calls.jsonl, {again[key]} times in trials.jsonl, "
                f"and its record counts {replays}"
            )
