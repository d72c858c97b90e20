"""The replies of hosted models held against the records: every decision is a reply, and every reply is a decision."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from lockprobe.report.verify.check import Check, also
from lockprobe.report.verify.replay import ReplayedTrial
from lockprobe.studies.costs.call_log import kept_replies, logged_calls
from lockprobe.studies.records.trial_rows import replaced_records
from lockprobe.trial.model_call import Call
from lockprobe.trial.plan import Plan
from lockprobe.trial.record import Trial


class LoggedCalls:
    """The calls of a directory, in the order in which they were asked; BadFile if one is damaged.

    ``logged`` has them as they are stored, ``calls`` those that have an outcome. ``kept`` has the replies of each
    trial, those after the last mark that it is owed anew.
    """

    def __init__(self, directory: Path) -> None:
        self.directory = directory
        self.logged = logged_calls(directory)
        self.calls = [one.answer for one in self.logged if one.answer is not None]
        self.kept: Mapping[str, Sequence[Call]] = kept_replies(self.calls)


def replies_held(
    name: str, log: LoggedCalls, trials: Mapping[str, Trial], again: Sequence[ReplayedTrial], owed: Mapping[str, Plan]
) -> Iterator[Check]:
    """Whether decisions of hosted models are the replies in a log, and all of them; no check without model or call.

    ``trials`` are on record, ``again`` is what follows of them, ``owed`` are planned and not finished.
    """
    hosted = [one for one in again if one.kind == "hosted"]
    if not (hosted or log.logged):
        return
    failed = [
        f"{one.key}: {one.choices if log.kept.get(one.key) else 'the log of calls has no reply of it'}"
        for one in hosted
        if one.choices
    ]
    failed += dict.fromkeys(_misplaced(log, {**owed, **trials}))
    waiting = dict.fromkeys(one.asked.key for one in log.logged if one.answer is None and one.asked is not None)
    failed += (f"{key}: a call that was sent has no outcome" for key in waiting if key not in owed)
    failed += (*_not_as_asked(log), *_marks(log, trials))
    before = sum(call.reply is not None for call in log.calls) - sum(map(len, log.kept.values()))
    unplayed = "of these trials are not played, and held by their words and joints alone"
    holds = f"{sum(len(log.kept.get(one.key, ())) for one in hosted)} replies in the log of calls are the decisions of "
    holds += f"{len(hosted)} trials, and all of them{also(sum(one.unplayed for one in hosted), unplayed)}"
    holds += also(before, "earlier replies are of trials that were played again on request")
    yield Check.of(name, failed, "{n} contradictions between the log of calls and the records", holds)


def _misplaced(log: LoggedCalls, known: Mapping[str, Trial | Plan]) -> Iterator[str]:
    """Calls, as sent and with their outcome, of no trial on record or owed, or of another agent or place."""
    for call in (said for one in log.logged for said in (one.asked, one.answer) if said is not None):
        one, place = known.get(call.key), (call.agent, call.condition, call.repetition, call.trial)
        if one is None:
            yield f"{call.key}: calls of no trial on record"
        elif place != (one.agent, one.name.condition, one.repetition, one.trial):
            yield f"{call.key}: its calls name another trial or agent"


def _not_as_asked(log: LoggedCalls) -> Iterator[str]:
    """Calls whose outcome is not one of what was sent, or counts less than what was lost before it.

    Calls that an import brought were sent elsewhere; they come before all others of their trial.
    """
    begun = set[str]()
    for _, asked, call in log.logged:
        if asked is None:
            if call is not None and not call.owed_anew and call.key in begun:
                yield f"{call.key}: the call of step {call.step}, turn {call.turn}, was not written before it was sent"
            continue
        begun.add(asked.key)
        if call is None:
            continue
        if (asked.key, asked.step, asked.turn, asked.request) != (call.key, call.step, call.turn, call.request):
            yield f"{call.key}: the call of step {call.step} is not the one that was sent"
        if lost := call.lacks(asked):
            yield f"{call.key}: step {call.step} had {lost}"
        if (call.unpriced or call.most is not None) and call.most != asked.most:
            yield f"{call.key}: step {call.step} could cost {asked.most}, not {call.most}"


def _marks(log: LoggedCalls, trials: Mapping[str, Trial]) -> Iterator[str]:
    """Trials whose marks in the log of calls are not those of their records: played again on request, or not."""
    marks, again = Counter(call.key for call in log.calls if call.owed_anew), Counter[str]()
    if not marks and not any(trial.replays for trial in trials.values()):
        return
    current = (trial for trial in trials.values() if trial.error is not None and trial.error.again)
    for copy in (*replaced_records(log.directory), *current):
        again[copy.key] += copy.error is not None and copy.error.again
    for key, trial in trials.items():
        replays = trial.replays + (trial.error is not None and trial.error.again)
        if not marks[key] == again[key] == replays:
            yield (
                f"{key}: owed anew {marks[key]} times in the log of calls, {again[key]} times on record, "
                f"and its record counts {replays}"
            )
