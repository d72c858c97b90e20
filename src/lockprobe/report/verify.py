"""Verification of a study from its records alone: settings, checksums, luck, truth, replies and report.

What a record says of the box and of the reports has to follow from its actions, from the rules of the box and from the
random streams of its seed. So every trial is played again (:mod:`lockprobe.report.replay`). Choices are held against
what there is of their agent: strategies are asked again, hosted models have their replies in the log of calls, local
models their probabilities, people and clients the log of their server. The report is made again and compared. No code
of a user or of another package runs, and no model is asked.
"""

from __future__ import annotations

import asyncio
import re
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, replace
from pathlib import Path

from pydantic import ValidationError

from lockprobe.agents.llm.settings import Model
from lockprobe.foundation.errors import LockprobeError, UserMistake
from lockprobe.foundation.inputs import is_there, read_input
from lockprobe.foundation.plugins import no_foreign_code
from lockprobe.foundation.spec import MCP, Spec, spec_kind
from lockprobe.interventions.conditions import interventions_of
from lockprobe.people.diary import acts_of_steps
from lockprobe.report.opened import OpenedStudy, open_study
from lockprobe.report.replay import AgentKind, ReplayedTrial, kind_of, played_again
from lockprobe.report.rows import MEASURES, Estimate, Fact, Results
from lockprobe.studies import FORKS, PAGE, RESULTS
from lockprobe.studies.branch import fork_plan
from lockprobe.studies.costs.call_log import kept_replies, read_calls
from lockprobe.studies.decisions import due
from lockprobe.studies.records.attempt_log import AttemptLog
from lockprobe.studies.records.directory import read_study
from lockprobe.studies.records.journal import Facts, facts_said, note
from lockprobe.studies.records.read_records import miscounted, rows_and_records
from lockprobe.studies.records.store import ALBUM, STORE, read
from lockprobe.studies.running.paused_trial import RecordedAttempt
from lockprobe.trial.pictures.picture import Picture
from lockprobe.trial.plan import Plan
from lockprobe.trial.protocols import InterventionTraits
from lockprobe.trial.record import Trial

NOT_SHOWN = (
    "No such check can show that the plan was changed, the seed chosen, or an agent or a person left out before these "
    "records were made, or that all of it was made up together (replies, answers of people and of local models, "
    "clock readings). To be safe against it: put the hash of the settings, which run prints before the first trial, "
    "under a preregistration, and that of the results under the paper; --settings HASH and --results HASH check them"
)
"""What verification cannot find, and what helps against it."""


_TIME = re.compile(rb"Made at \d\d:\d\d on \d{1,2} [A-Z][a-z]+ \d{4};")
"""When a page was made, of a study with open trials."""


@dataclass(frozen=True, slots=True)
class Check:
    """One thing that was checked: its name, what is so if it holds, and what is not: keys of trials, or lines.

    Without what is so, the one line that is not says all.
    """

    name: str
    said: str
    failed: Sequence[str] = ()

    @property
    def holds(self) -> bool:
        """Whether nothing fails."""
        return not self.failed


def verify(
    directory: Path | str,
    *,
    settings: str | None = None,
    results: str | None = None,
    tell: Callable[[int, int], None] = lambda done, of: None,
) -> tuple[Check, ...]:
    """Recompute a study from its records, and hold what lies in its directory against that.

    Args:
        directory: The directory of a study.
        settings: The hash of its settings, as it was published; None checks none.
        results: The hash of its records likewise.
        tell: Called with the number of trials played again, and of all.

    Returns:
        The checks in order. After settings or records that cannot be read there are no others.
    """
    with no_foreign_code():
        try:
            opened = open_study(Path(directory))
            acts_of_steps(opened.study, {one.key: one for one in opened.trials}, opened.diaries, opened.directory)
            found = _PlayedAgain(opened, {"settings": settings, "results": results}, tell)
            return tuple(one for check in _CHECKS for one in check(found))
        except LockprobeError as error:
            return (Check("records", "settings and records can be read", (str(error),)),)


class _PlayedAgain:
    """A study whose trials are played again, and its published hashes."""

    def __init__(
        self, opened: OpenedStudy, published: Mapping[str, str | None], tell: Callable[[int, int], None]
    ) -> None:
        self.opened, self.published, self.directory, self.study = opened, published, opened.directory, opened.study
        self.trials = {trial.key: trial for trial in opened.trials}
        finished = {key for key, trial in self.trials.items() if not trial.owed_again}
        plans = (plan for agent in self.study.run_agents for plan in self.study.plans(agent))
        self.owed = {plan.key: plan for plan in plans if plan.key not in finished}
        self.again, self.contradictions = list[ReplayedTrial](), list[str]()
        asyncio.run(self._play(tell))

    async def _play(self, tell: Callable[[int, int], None]) -> None:
        """Read every record, once: it is held against its row, and played again if it counts."""
        kept = kept_replies(read_calls(self.directory))
        with read(self.directory) as store:
            for trial, counts, said in rows_and_records(store):
                self.contradictions += [said] * bool(said)
                if counts:
                    condition = self.study.labelled(trial.condition)
                    plan = self.study.plan(trial.agent, condition, trial.repetition, trial.trial)
                    self.again.append(await played_again(plan, trial, kept.get(trial.key, ())))
                    tell(len(self.again), len(self.trials))
                    await asyncio.sleep(0)  # here Ctrl-C is heard


def _also(count: int, said: str) -> str:
    """A further part of what was found, after its number; empty for none."""
    return f"; {count} {said}" if count else ""


def _records(of: _PlayedAgain) -> Iterator[Check]:
    """The store is sound and says what its records say."""
    failed = list[str]()
    for folder in (of.directory, of.directory / FORKS):
        if is_there(folder / STORE):
            with read(folder) as store:
                damage = [said for (said,) in store.rows("pragma quick_check") if said != "ok"]
                path = store.path.relative_to(of.directory)
                rows = of.contradictions if folder == of.directory else [said for *_, said in rows_and_records(store)]
                failed += (f"{path}: {said}" for said in damage or [*filter(None, rows), *miscounted(store)])
    broken = Counter(trial.error.boundary for trial in of.opened.trials if trial.error is not None)
    where = f" ({', '.join(f'{name} {broken[name]}' for name in sorted(broken))})" if broken else ""
    ended = f"{broken.total()} of {len(of.trials)} trials ended as an error{where}"
    yield Check("records", f"{len(of.trials)} records are unchanged; {ended}", failed)


def _settings(of: _PlayedAgain) -> Iterator[Check]:
    """The doses of the conditions are those of what acts in them; the hashes are the published ones."""
    failed, own = list[str](), of.study
    for condition in own.conditions:
        for spec, doses in condition.acting:
            try:
                (made,) = interventions_of(str(spec))
            except UserMistake:  # it cannot be made here: it is code of others, or the file of its prompt is missing
                continue
            if (found := InterventionTraits.of(made).doses) != doses:
                failed.append(f"{condition.label}: the doses of {spec} are {found}, not {doses}")
    yield Check("settings", f"all {len(of.trials)} trials are of seed {own.seed} and of these settings", failed)
    earlier = [replace(own, **asdict(size), earlier=()).settings_hash for size in own.earlier]
    hashes = {"settings": own.settings_hash, "results": of.opened.results_hash}
    for what, published in of.published.items():
        if published is not None:
            same = published.strip().lower() == hashes[what]
            said = f"these {what} have the hash {published.strip()}"
            other = f"these {what} have the hash {hashes[what]}, not {published.strip()}"
            if what == "settings" and published.strip().lower() in earlier:
                other += ", which they had before the study was extended"
            yield Check(f"{what} hash", said if same else "", [] if same else [other])


def _complete(of: _PlayedAgain) -> Iterator[Check]:
    """Every planned trial of agents is there; participants owe none."""
    own, owed = of.study, list(of.owed)
    if own.until is not None:  # what it has to play before its next look; nothing if it may stop
        owed = [plan.key for agent in own.run_agents for plan in due(own, agent, of.opened.trials)]
    people = f"; of people {sum(bool(one.player) for one in of.opened.trials)} of {own.invited}, who owe none"
    which = f"trial that it needs until {own.until}" if own.until else "planned trial"
    yield Check("complete", f"every {which} is there{people * bool(own.invited)}", owed)


_ASKED: Mapping[AgentKind, str] = {
    "strategy": "of strategies, which are asked again",
    "local": "of local models, by their recorded probabilities",
    "own": "of your own agents cannot be held against anything",
}
"""Kind of agent -> how its choices are held."""


def _luck(of: _PlayedAgain) -> Iterator[Check]:
    """Truth and reports follow from the choices, the box and the seed.

    Strategies choose the same again, local models by their probabilities, and nobody the impossible.
    """
    left = Counter(one.unplayed for one in of.again if one.unplayed)
    more = "".join(_also(count, f"more {why}") for why, count in left.items())
    said = f"all {len(of.again) - left.total()} trials follow from their choices, the box and the seed{more}"
    yield Check("luck", said, [f"{one.key}: {one.luck}" for one in of.again if one.luck])
    counts = Counter(one.kind for one in of.again if not one.unplayed or one.kind == "own")
    held = [f"{counts[kind]} trials {said}" for kind, said in _ASKED.items() if counts[kind]]
    which = "those that can be recomputed" if counts["own"] else "all"
    said = f"{which} are as their agents make them: {', '.join(held) or 'none is of such an agent'}"
    other = [f"{one.key}: {one.choices}" for one in of.again if one.choices and one.kind != "hosted"]
    yield Check("choices", said, other)


def _agents(of: _PlayedAgain) -> Iterator[Check]:
    """An agent is the same in all its trials, and a model the one that its spec names."""
    known, failed = Facts(), list[str]()
    for trial in of.opened.trials:
        for (_, name), (before, now) in note(known, facts_said(trial)).items():
            failed.append(f"{trial.key}: {name} is {now}, and {before} in other trials")
        if kind_of(trial.agent) == "hosted":
            model = Model.parse(trial.agent)
            asked = {name: getattr(model.settings, name) for name in Spec.parse(trial.agent).options}
            for name, value in {"model": model.name, **asked}.items():
                if trial.facts.get(name) not in (None, value):
                    failed.append(f"{trial.key}: {name} is {trial.facts[name]} in its record and {value} in its spec")
    yield Check("agents", "every agent says the same of itself in all its trials", failed)


def _replies(of: _PlayedAgain) -> Iterator[Check]:
    yield from _replies_held("replies", of.directory, {**of.owed, **of.trials}, of.again)


def _replies_held(
    name: str, directory: Path, known: Mapping[str, Trial | Plan], again: Sequence[ReplayedTrial]
) -> Iterator[Check]:
    """Whether decisions of hosted models are the replies in a log, and all of them; no check without model or call.

    ``known`` are the trials on record, and those that are owed; ``again`` is what follows of the records.
    """
    logged, hosted = read_calls(directory), [one for one in again if one.kind == "hosted"]
    if not (hosted or logged):
        return
    kept = kept_replies(logged)
    failed = [
        f"{one.key}: {one.choices if kept.get(one.key) else 'the log of calls has no reply of it'}"
        for one in hosted
        if one.choices
    ]
    for call in logged:
        one = known.get(call.key)
        if one is None or call.agent != one.agent:
            failed.append(f"{call.key}: its calls name no trial on record, or another agent")
    unplayed = "of these are not played, and held by their words alone"
    said = f"{sum(len(kept.get(one.key, ())) for one in hosted)} replies in the log of calls are the decisions of "
    said += f"{len(hosted)} trials, and all of them{_also(sum(bool(one.unplayed) for one in hosted), unplayed)}"
    yield Check(name, said, [*dict.fromkeys(failed)])


def _attempts(of: _PlayedAgain) -> Iterator[Check]:
    """Steps of people and clients are the attempts in their diaries and in the log of attempts, and all of them."""
    diaries, logged = of.opened.diaries, dict(AttemptLog.read(of.directory))
    for diary in diaries:
        for box in range(1, len(diary.joined.slots) + 1):
            key, steps = diary.plan(of.study, box).key, diary.steps.get(box)
            if key in of.trials or (steps and steps[-1].ended is not None):
                logged[key] = diary.attempts(box)
    held = [one for one in of.opened.trials if spec_kind(one.agent) == MCP or (one.player and diaries)]
    if held or logged or diaries:
        failed = list[str]()
        for one in of.opened.records(held):
            pairs = [(step.told, step.decision) for step in one.steps]
            done = [RecordedAttempt(said.joint, said.claimed, told, said.hypothesis) for told, said in pairs]
            if done != [*logged.pop(one.key, ())] and not one.owed_again:  # of a box that broke the log starts anew
                failed.append(f"{one.key}: its steps are not the attempts in its log")
        failed += [f"{key}: it is not on record" for key in logged if key not in of.owed]
        said = f"{len(held)} trials of clients and people are as their servers wrote them step by step"
        yield Check("attempts", said, failed)


def _forks(of: _PlayedAgain) -> Iterator[Check]:
    """Forks follow from the records of their trials, their choices and the seed."""
    opened, own, directory = of.opened, of.study, of.directory / FORKS
    if not opened.forks:
        return
    there, failed = read_study(directory), list[str]()
    if list(map(there.record_identity, there.conditions)) != list(map(own.record_identity, own.conditions)):
        failed.append(f"{FORKS}/study.json: the settings of another study")
    again = list[ReplayedTrial]()
    kept, kept_before = (kept_replies(read_calls(one)) for one in (directory, of.directory))
    with asyncio.Runner() as runner:
        for fork in opened.forks:
            name = fork.fork
            try:
                assert name is not None
                (parent,) = opened.records([of.trials[name.parent]])
                plan = fork_plan(own, parent, name)
            except (UserMistake, ValueError, KeyError, StopIteration):  # an unknown arm; a trial of another condition
                failed.append(f"{fork.key}: it is a fork of no trial on record")
                continue
            replies = kept.get(fork.key, ()), kept_before.get(name.parent, ())
            again.append(one := runner.run(played_again(plan, fork, *replies)))
            if why := one.luck or one.choices * (one.kind != "hosted"):  # those have a check of their own
                failed.append(f"{one.key}: {why}")
    yield Check("forks", f"all {len(opened.forks)} forks follow from their trials, their choices and the seed", failed)
    yield from _replies_held("fork replies", directory, {one.key: one for one in opened.forks}, again)


def _pictures(of: _PlayedAgain) -> Iterator[Check]:
    """Every picture that is there is the one of its name."""
    album, names = of.directory / ALBUM, {name for one in of.opened.trials for name in one.picture_names}
    there = [name for name in sorted(names) if (album / name).is_file()]
    failed = [name for name in there if Picture(kind="rgb", png=read_input(album / name)).name != name]
    if names:
        missing = _also(len(names) - len(there), "are not there")
        yield Check("pictures", f"{len(there)} pictures are those that the records name{missing}", failed)


def _report(of: _PlayedAgain) -> Iterator[Check]:
    """Results, page, tables and figures are those of a report that is made again, byte by byte.

    It is made without code of packages: the rows that they measured are taken from the file, and named.
    """
    if not any((of.directory / name).exists() for name in (RESULTS, PAGE)):
        yield Check("results", "there is no report to compare")
        return
    from lockprobe.report.page import report_files

    def written(name: str) -> bytes:
        try:
            return read_input(of.directory / name)
        except LockprobeError:
            return b""

    here, measured = written(RESULTS), list[Estimate | Fact]()
    with suppress(ValidationError):  # what is wrong with it is named below
        found = Results.model_validate_json(here)
        measured += (row for row in found.measures if row.source)
        measured += (fact for fact in found.facts if fact.about == MEASURES and fact.source)
    files = report_files(replace(of.opened, measured=measured), tell=lambda said: None)
    made = {name: one.encode() if isinstance(one, str) else one for name, one in files if one is not None}
    there = {name: written(name) for name in made if (of.directory / name).exists()}
    lines, now = (dict.fromkeys(line.strip(b" ,\r") for line in text.split(b"\n")) for text in (here, made[RESULTS]))
    failed = [f"written: {line[:300].decode(errors='replace')}" for line in lines if line not in now]
    failed += [f"computed: {line[:300].decode(errors='replace')}" for line in now if line not in lines]
    if here != made[RESULTS] and not failed:
        failed = ["lines in another order"]
    unchecked = f"of its rows are not checked: they come from {', '.join({row.source: None for row in measured})}"
    said = f"{RESULTS} is what this release makes of the records{_also(len(measured), unchecked)}"
    yield Check("results", said, failed) if RESULTS in there else Check("results", f"{RESULTS} is not there")
    there.pop(RESULTS, None)
    different = [name for name, one in there.items() if _TIME.sub(b"", one) != _TIME.sub(b"", made[name])]
    missing = _also(len(made) - 1 - len(there), "are not there")
    said = f"{len(there)} pages, tables and figures are what this release makes of the records{missing}"
    yield Check("report", said, different)


_CHECKS = (
    _records, _settings, _complete, _luck, _agents, _replies, _attempts, _forks, _pictures, _report,
)  # fmt: skip
"""What is checked, in order."""
