"""The replies of hosted models held against the records: every decision is a reply, and every reply is a decision."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

from lockprobe.agents.llm.settings import read_settings
from lockprobe.foundation.errors import UserMistake
from lockprobe.foundation.spec import Spec
from lockprobe.foundation.storage.jsonl import whole_lines
from lockprobe.report.verify.check import Check, also, check_of
from lockprobe.report.verify.replayed_trials import ReplayedTrial, is_hosted
from lockprobe.studies.costs.call_log import kept_replies, read_asked, read_calls, unanswered
from lockprobe.studies.file_names import RECORDS
from lockprobe.studies.records.merge import lasting_facts
from lockprobe.trial.model_call import Call
from lockprobe.trial.plan import Plan
from lockprobe.trial.record import Trial
from lockprobe.trial.trial_json import trial_from_line


@dataclass(frozen=True, slots=True)
class CallEvidence:
    """The calls of a study, each file read once.

    Attributes:
        calls: All calls in chronological order.
        asked: All requests before they were sent, likewise.
        kept: Key of a trial -> its replies, those after the last mark that it is owed anew.
    """

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
        return cls(calls, tuple(read_asked(directory)), kept_replies(calls))


def replies_check(
    directory: Path,
    trials: Iterable[Trial],
    evidence: CallEvidence,
    replayed: Sequence[ReplayedTrial],
    owed: Mapping[str, Plan],
    name: str = "replies",
) -> Iterator[Check]:
    """Whether the decisions of hosted models are the replies in ``calls.jsonl``, and these all decisions.

    Nothing if no hosted model played and none was called.

    Args:
        directory: The directory of the records.
        trials: The trials on record.
        evidence: The calls.
        replayed: What follows of each trial.
        owed: Trials that are planned and not finished, by key.
        name: Name of the check.
    """
    hosted = [one for one in replayed if one.kind == "hosted"]
    if not hosted and not evidence.calls and not evidence.asked:
        return
    on_record = {trial.key: trial for trial in trials}
    known: Mapping[str, Trial | Plan] = {**owed, **on_record}
    waiting = (call.key for call in unanswered(directory) if call.key not in owed)
    failed = [
        *_other_decisions(hosted, evidence),
        *dict.fromkeys(_misplaced(evidence, known)),
        *dict.fromkeys(f"{key}: a request in asked.jsonl has no call" for key in waiting),
        *_not_asked(evidence),
        *_marks(directory, evidence, on_record),
    ]
    kept, words = evidence.kept, sum(one.unplayed for one in hosted)
    before = sum(call.reply is not None for call in evidence.calls) - sum(map(len, kept.values()))
    holds = (
        f"{sum(len(kept.get(one.key, ())) for one in hosted)} replies in calls.jsonl are the decisions of "
        f"{len(hosted)} trials, and all of them"
        f"{also(words, 'of these trials are not played, and held by their words and joints alone')}"
        f"{also(before, 'earlier replies are of trials that were played again on request')}"
    )
    yield check_of(name, failed, holds, "contradictions between calls.jsonl and trials.jsonl")


def _other_decisions(hosted: Iterable[ReplayedTrial], evidence: CallEvidence) -> Iterator[str]:
    """Trials whose decisions are not their replies, or not all of them."""
    for one in hosted:
        if one.choices and not evidence.kept.get(one.key):
            yield f"{one.key}: calls.jsonl has no reply of it"
        elif one.choices:
            yield f"{one.key}: {one.choices}"
        elif one.unused:
            yield f"{one.key}: {one.unused} replies in calls.jsonl are no part of the record"


def _misplaced(evidence: CallEvidence, known: Mapping[str, Trial | Plan]) -> Iterator[str]:
    """Calls and requests of no trial on record or owed, or with another agent or place: costs are counted by agent."""
    for call in (*evidence.calls, *evidence.asked):
        one = known.get(call.key)
        if one is None:
            yield f"{call.key}: calls of no trial on record"
        elif (call.agent, call.condition, call.repetition, call.trial) != (
            one.agent,
            one.name.condition,
            one.repetition,
            one.trial,
        ):
            yield f"{call.key}: its calls name another trial or agent"


def _not_asked(evidence: CallEvidence) -> Iterator[str]:
    """Calls without the request that was written before it was sent, and counts of lost attempts below those there.

    Calls that an import brought have no requests; they come before all others of their trial. A call that broke is made
    again when its trial is resumed: calls of one place have their lost attempts together.
    """
    asked: defaultdict[tuple[str, int, int, str], list[Call]] = defaultdict(list)
    for call in evidence.asked:
        asked[_place(call)].append(call)
    counted = Counter[tuple[str, int, int, str]]()
    for call in evidence.calls:
        counted[_place(call)] += call.unanswered
    for place, requests in asked.items():
        # each call begins to count at 0
        last = [one for one, after in pairwise([*requests, None]) if one and not (after and after.unanswered)]
        lost = sum(one.unanswered for one in last)
        if place in counted and counted[place] < lost:
            yield f"{place[0]}: step {place[1]} had {lost} attempts without an answer, not {counted[place]}"
    begun = set[str]()
    for call in evidence.calls:
        if call.owed_anew:
            continue
        requests = asked[_place(call)]
        if requests:
            begun.add(call.key)
        elif call.key in begun:
            yield f"{call.key}: the call of step {call.step}, turn {call.turn}, is not in asked.jsonl"
        if requests and call.most is not None and call.most not in [one.most for one in requests]:
            yield f"{call.key}: step {call.step} could cost {requests[-1].most}, not {call.most}"


def _place(call: Call) -> tuple[str, int, int, str]:
    return call.key, call.step, call.turn, call.request


def _marks(directory: Path, evidence: CallEvidence, trials: Mapping[str, Trial]) -> Iterator[str]:
    """Trials whose marks in the log of calls are not those of their records: played again on request, or not."""
    marks = Counter(call.key for call in evidence.calls if call.owed_anew)
    if not marks and not any(trial.replays for trial in trials.values()):
        return
    again = Counter[str]()
    for _, line in whole_lines(directory / RECORDS):
        if b'"again":true' in line:
            copy, _ = trial_from_line(line)
            again[copy.key] += copy.error is not None and copy.error.again
    for key in dict.fromkeys([*marks, *again, *trials]):
        trial = trials.get(key)
        replays = 0 if trial is None else trial.replays + (trial.error is not None and trial.error.again)
        if trial is not None and not (marks[key] == again[key] == replays):
            yield (
                f"{key}: owed anew {marks[key]} times in calls.jsonl, {again[key]} times in trials.jsonl, "
                f"and its record counts {replays}"
            )


def agent_check(trials: Iterable[Trial]) -> Check:
    """Whether an agent is the same in all its trials, and a model the one that its spec names."""
    known: dict[tuple[str, str], object] = {}
    failed: dict[str, None] = {}
    for trial in trials:
        for name, value in lasting_facts(trial).items():
            if value is not None and known.setdefault((trial.agent, name), value) != value:
                failed[f"{trial.key}: {name} is {value}, and {known[trial.agent, name]} in other trials"] = None
        if why := _another_model(trial):
            failed[f"{trial.key}: {why}"] = None
    holds = "every agent says the same of itself in all its trials"
    return check_of("agents", list(failed), holds, "trials differ in what they say of their agent")


def _another_model(trial: Trial) -> str:
    """What the facts of a hosted model have otherwise than its spec; empty if nothing."""
    if not is_hosted(trial.agent) or not trial.facts:
        return ""
    try:
        name, _ = read_settings(trial.agent)
    except UserMistake as mistake:
        return str(mistake)
    asked = {"model": name, **Spec.parse(trial.agent).options}
    for fact, value in asked.items():
        there = trial.facts.get(fact)
        if there is not None and str(there) != value and not _equal(there, value):
            return f"{fact} is {there} in its record and {value} in its spec"
    return ""


def _equal(fact: object, text: str) -> bool:
    try:
        return isinstance(fact, int | float) and float(text) == fact
    except ValueError:
        return False
