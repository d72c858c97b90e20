"""The replies of hosted models held against the records: every decision is a reply, and every reply is a decision."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

from lockprobe.foundation.storage.jsonl import whole_lines
from lockprobe.report.verify.replay import ReplayedTrial
from lockprobe.studies.costs.call_log import kept_replies, read_asked, read_calls, unanswered
from lockprobe.studies.file_names import RECORDS
from lockprobe.trial.model_call import Call
from lockprobe.trial.plan import Plan
from lockprobe.trial.record import Trial
from lockprobe.trial.trial_json import trial_from_line

_Place = tuple[str, int, int, str]
"""Key, step, turn and request of a call."""


@dataclass(frozen=True, slots=True)
class CallEvidence:
    """The calls of a directory, each file read once: all calls and all requests in chronological order.

    ``kept`` has the replies of each trial, those after the last mark that it is owed anew.
    """

    directory: Path
    calls: tuple[Call, ...]
    asked: tuple[Call, ...]
    kept: Mapping[str, Sequence[Call]]

    @classmethod
    def of(cls, directory: Path) -> CallEvidence:
        """Read the files of a directory.

        Raises:
            BadFile: If a line is damaged.
        """
        calls = tuple(read_calls(directory))
        return cls(directory, calls, tuple(read_asked(directory)), kept_replies(calls))

    def contradictions(
        self, trials: Sequence[Trial], hosted: Sequence[ReplayedTrial], owed: Mapping[str, Plan]
    ) -> Iterator[str]:
        """Where decisions are no replies, or replies no decisions.

        Args:
            trials: The trials on record.
            hosted: What follows of those of hosted models.
            owed: Trials that are planned and not finished, by key.
        """
        on_record = {trial.key: trial for trial in trials}
        for one in hosted:
            if one.choices and not self.kept.get(one.key):
                yield f"{one.key}: calls.jsonl has no reply of it"
            elif one.choices:
                yield f"{one.key}: {one.choices}"
            elif one.unused:
                yield f"{one.key}: {one.unused} replies in calls.jsonl are no part of the record"
        yield from dict.fromkeys(self._misplaced({**owed, **on_record}))
        waiting = (call.key for call in unanswered(self.directory) if call.key not in owed)
        yield from dict.fromkeys(f"{key}: a request in asked.jsonl has no call" for key in waiting)
        yield from self._not_asked()
        yield from self._marks(on_record)

    def _misplaced(self, known: Mapping[str, Trial | Plan]) -> Iterator[str]:
        """Calls and requests of no trial on record or owed, or of another agent or place: costs go by agent."""
        for call in (*self.calls, *self.asked):
            one, place = known.get(call.key), (call.agent, call.condition, call.repetition, call.trial)
            if one is None:
                yield f"{call.key}: calls of no trial on record"
            elif place != (one.agent, one.name.condition, one.repetition, one.trial):
                yield f"{call.key}: its calls name another trial or agent"

    def _not_asked(self) -> Iterator[str]:
        """Calls without the request that was written before it was sent, and counts of lost attempts below those there.

        Calls that an import brought have no requests; they come before all others of their trial. A call that broke is
        made again when its trial is resumed: calls of one place have their lost attempts together.
        """
        asked, counted, begun = defaultdict[_Place, list[Call]](list), Counter[_Place](), set[str]()
        for call in self.asked:
            asked[_place(call)].append(call)
        for call in self.calls:
            counted[_place(call)] += call.unanswered
        for place, requests in asked.items():
            # each call begins to count at 0
            last = [one for one, after in pairwise([*requests, None]) if one and not (after and after.unanswered)]
            lost = sum(one.unanswered for one in last)
            if place in counted and counted[place] < lost:
                yield f"{place[0]}: step {place[1]} had {lost} attempts without an answer, not {counted[place]}"
        for call in (one for one in self.calls if not one.owed_anew):
            requests = asked[_place(call)]
            if not requests and call.key in begun:
                yield f"{call.key}: the call of step {call.step}, turn {call.turn}, is not in asked.jsonl"
            begun |= {call.key} if requests else set()
            if requests and call.most is not None and call.most not in [one.most for one in requests]:
                yield f"{call.key}: step {call.step} could cost {requests[-1].most}, not {call.most}"

    def _marks(self, trials: Mapping[str, Trial]) -> Iterator[str]:
        """Trials whose marks in the log of calls are not those of their records: played again on request, or not."""
        marks, again = Counter(call.key for call in self.calls if call.owed_anew), Counter[str]()
        if not marks and not any(trial.replays for trial in trials.values()):
            return
        for _, line in whole_lines(self.directory / RECORDS):
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


def _place(call: Call) -> _Place:
    return call.key, call.step, call.turn, call.request
