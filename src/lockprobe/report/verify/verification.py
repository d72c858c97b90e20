"""Verification of a finished study from its records alone: settings, checksums, luck, truth, replies and report.

What a record says of the box and of the reports has to follow from its actions, from the rules of the box and from the
random streams of its seed. So every trial is played again with the recorded choices. Choices are held against what
there is of their agent: strategies are asked again, hosted models have their replies in the log of calls, local models
their probabilities, people and clients the log of their server. The report is made again and compared. No code of a
user or of another package runs, and no model is asked.
"""

from __future__ import annotations

import asyncio
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

from lockprobe.agents.catalogue import is_strategy, resolve
from lockprobe.agents.llm.settings import read_settings
from lockprobe.agents.policy import Policy
from lockprobe.foundation.errors import BadValue, LockprobeError, UserMistake
from lockprobe.foundation.inputs import read_input
from lockprobe.foundation.plugins import no_foreign_code
from lockprobe.foundation.spec import MCP, Spec, spec_kind
from lockprobe.foundation.storage.jsonl import whole_lines, without_checksum
from lockprobe.interventions.catalogue import interventions_of
from lockprobe.people.diary import Diary
from lockprobe.people.responses import Attempt
from lockprobe.people.step_times import key_of, times_of_steps
from lockprobe.report.opened import OpenedStudy, open_study
from lockprobe.report.verify.made_again import MadeAgain, made_again
from lockprobe.report.verify.replay import Replay, ReplayedTrial, is_foreign, kind_of
from lockprobe.report.verify.replies import CallEvidence
from lockprobe.studies.branch import FORKS, fork_plan
from lockprobe.studies.file_names import ASKED, ATTEMPTS, CALLS, PEOPLE_DIRECTORY, RECORDS
from lockprobe.studies.next_choice import next_choice
from lockprobe.studies.options.settings import read_study
from lockprobe.studies.records.attempt_log import AttemptLog
from lockprobe.studies.records.journal import read_timings
from lockprobe.studies.records.merge import lasting_facts
from lockprobe.studies.records.picture_store import ALBUM
from lockprobe.studies.records.results_hash import results_hash
from lockprobe.studies.running.paused_trial import RecordedAttempt
from lockprobe.studies.stopping import due
from lockprobe.trial.pictures.picture import Picture
from lockprobe.trial.plan import Plan
from lockprobe.trial.protocols import InterventionTraits
from lockprobe.trial.record import Trial
from lockprobe.trial.trial_name import ForkName

NOT_SHOWN = (
    "No such check can show that the plan was changed, the seed chosen, or an agent or a person left out before these "
    "records were made, or that all files were made up together (calls.jsonl, answers of people and of local models, "
    "clock readings). To be safe against it: put the hash of the settings, which run prints before the first trial, "
    "under a preregistration, and that of the results under the paper; --settings HASH and --results HASH check them"
)
"""What verification cannot find, and what helps against it."""

_LOGS = (RECORDS, CALLS, ASKED, ATTEMPTS)
"""Files whose every line has a checksum."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Check:
    """One thing that was checked.

    Attributes:
        name: Its name.
        holds: Whether it holds.
        said: What was found, in one line.
        failed: What fails: keys of trials, or fields.
    """

    name: str
    holds: bool
    said: str
    failed: tuple[str, ...] = ()


class _Found(NamedTuple):
    """What fails, what is said if anything does ({n} is how much), and what is said if nothing does."""

    failed: Sequence[str]
    fails: str
    holds: str


@dataclass(frozen=True, kw_only=True)
class _Study:
    """What checks look at; the trials and forks are played again once."""

    opened: OpenedStudy
    settings: str | None = None
    results: str | None = None
    processes: int = 1
    tell: Callable[[int, int], None] = field(default=lambda done, of: None)

    @cached_property
    def calls(self) -> CallEvidence:
        return CallEvidence.of(self.opened.directory)

    @cached_property
    def fork_calls(self) -> CallEvidence:
        return CallEvidence.of(self.opened.directory / FORKS)

    @cached_property
    def again(self) -> tuple[ReplayedTrial, ...]:
        """Every trial, played again."""
        found, study = list[ReplayedTrial](), self.opened.study
        with asyncio.Runner() as runner:
            replay = Replay(runner)
            for done, trial in enumerate(self.opened.trials, 1):
                condition = study.condition_of(trial)
                assert condition is not None  # only trials that the settings ask for are opened
                plan = study.plan(trial.agent, condition, trial.repetition, trial.trial)
                found.append(replay(plan, trial, self.calls.kept.get(trial.key, ())))
                self.tell(done, len(self.opened.trials))
        return tuple(found)

    @cached_property
    def forks(self) -> tuple[ReplayedTrial, ...]:
        """Every fork likewise."""
        found = list[ReplayedTrial]()
        with asyncio.Runner() as runner:
            replay = Replay(runner)
            for fork in self.opened.forks:
                planned = self.planned(fork)
                if isinstance(planned, str):
                    found.append(ReplayedTrial(key=fork.key, kind="own", luck=planned))
                else:
                    name, plan = planned
                    own, parent = self.fork_calls.kept.get(fork.key, ()), self.calls.kept.get(name.parent, ())
                    found.append(replay(plan, fork, own, parent))
        return tuple(found)

    def planned(self, fork: Trial) -> tuple[ForkName, Plan] | str:
        """The name and the plan of a fork, or why it has none."""
        name = fork.fork
        if name is None or name.parent not in self.trials:
            return "it is a fork of no trial on record"
        try:
            return name, fork_plan(self.opened.study, self.trials[name.parent], name)
        except (
            UserMistake,
            ValueError,
            StopIteration,
        ) as error:  # an unknown arm; a trial that is none of its condition
            return f"its trial cannot be forked so ({str(error) or 'its record is another one'})"

    @cached_property
    def trials(self) -> dict[str, Trial]:
        return {trial.key: trial for trial in self.opened.trials}

    @cached_property
    def plans(self) -> dict[str, Plan]:
        study = self.opened.study
        return {plan.key: plan for agent in study.run_agents for plan in study.plans(agent)}

    @cached_property
    def owed(self) -> dict[str, Plan]:
        there = {key for key, trial in self.trials.items() if not trial.owed_again}
        return {key: plan for key, plan in self.plans.items() if key not in there}

    @cached_property
    def report(self) -> MadeAgain | str | None:
        """The report, made again; why it cannot be; None if there is none."""
        try:
            return made_again(self.opened, self.processes)
        except UserMistake as mistake:
            return str(mistake)


def verify(
    directory: Path | str,
    *,
    settings: str | None = None,
    results: str | None = None,
    processes: int = 1,
    tell: Callable[[int, int], None] = lambda done, of: None,
) -> tuple[Check, ...]:
    """Recompute a study from its records, and hold what lies in its directory against that.

    Args:
        directory: The directory of a study.
        settings: The hash of its settings, as it was published; None checks none.
        results: The hash of its records likewise.
        processes: Processes that may work at a large report.
        tell: Called with the number of trials played again, and of all.

    Returns:
        The checks in order. After settings or records that cannot be read there are no others.
    """
    with no_foreign_code():
        try:
            opened = open_study(Path(directory))
            times_of_steps(opened.study, opened.trials, opened.diaries, opened.directory)  # diaries and records agree
            study = _Study(opened=opened, settings=settings, results=results, processes=processes, tell=tell)
            checks = [(name, check(study)) for name, check in _CHECKS.items()]
        except LockprobeError as error:
            return (Check(name="records", holds=False, said=str(error)),)
    return tuple(
        Check(
            name=name,
            holds=not found.failed,
            said=found.fails.replace("{n}", str(len(found.failed))) if found.failed else found.holds,
            failed=tuple(found.failed),
        )
        for name, found in checks
        if found is not None
    )


def _also(count: int, said: str) -> str:
    """A further part of what was found, after its number; empty for none."""
    return f"; {count} {said}" if count else ""


def _records(study: _Study) -> _Found:
    """Every line has its checksum and no trial has two records; how many trials ended as an error."""
    directory, lines, failed = study.opened.directory, 0, list[str]()
    logs = [*(directory / name for name in _LOGS), *(directory / FORKS / name for name in _LOGS)]
    for path in (*logs, *sorted((directory / PEOPLE_DIRECTORY).glob("*.jsonl"))):
        for number, line in whole_lines(path) if path.is_file() else ():
            lines += path == directory / RECORDS
            try:
                without_checksum(line)
            except BadValue as error:
                failed.append(f"{path.relative_to(directory)}, line {number}: {error}")
    if twice := study.opened.journal.contradicted:
        failed.append(f"{RECORDS}: {twice} finished trials have a second record that differs")
    broken = Counter(trial.error.boundary for trial in study.opened.trials if trial.error is not None)
    where = f" ({', '.join(f'{name} {broken[name]}' for name in sorted(broken))})" if broken else ""
    ended = f"{broken.total()} of {len(study.trials)} trials ended as an error{where}"
    holds = f"{lines} lines and {len(study.calls.calls)} calls, unchanged; {ended}"
    return _Found(failed, f"{{n}} lines with a wrong checksum or of a second record; {ended}", holds)


def _settings(study: _Study) -> _Found:
    """All records are of this study: its seed, box, budget, conditions and panels."""
    opened, own = study.opened, study.opened.study
    first = f"; {opened.journal.first_foreign}" if opened.journal.first_foreign else ""
    foreign = opened.foreign + opened.journal.foreign
    failed = [f"{foreign} records are of another seed or of other settings{first}"] if foreign else []
    for condition in own.conditions:
        for spec, doses in condition.acting:
            if not is_foreign("intervention", spec) and (made := _doses_of(spec, doses)) != doses:
                found, said = (", ".join(names) or "none" for names in (made, doses))
                failed.append(f"{condition.label}: the doses of {spec} are {found}, not {said}")
    holds = f"all {len(study.trials)} trials are of seed {own.seed} and these settings, {own.settings_hash}"
    return _Found(failed, "; ".join(failed), holds)


def _doses_of(spec: str, recorded: tuple[str, ...]) -> tuple[str, ...]:
    """The doses of an intervention; the recorded ones where it cannot be made here, as without the file of a prompt."""
    try:
        (made,) = interventions_of(spec)
    except UserMistake:
        return recorded
    return InterventionTraits.of(made).doses


def _complete(study: _Study) -> _Found:
    """Every planned trial of agents is there, and every trial that was timed; participants owe none."""
    opened, own = study.opened, study.opened.study
    owed = study.owed
    if own.until is not None:  # what it has to play before its next look; nothing if it may stop
        owed = {plan.key: plan for agent in own.run_agents for plan in due(own, agent, opened.trials)}
    others = opened.foreign or opened.journal.foreign
    timed = [] if others else [one.key for one in read_timings(opened.directory)]
    unknown = [key for key in timed if key not in owed and key not in study.trials]
    people = f"; of people {sum(bool(one.player) for one in opened.trials)} of {own.invited}, who owe none"
    holds = f"every {f'trial that it needs until {own.until}' if own.until else 'planned trial'} is there"
    fails = f"{len(owed)} planned trials are missing{_also(len(unknown), 'in timings.jsonl are not on record')}"
    return _Found((*owed, *unknown), fails, holds + people * bool(own.invited))


def _hash(what: str, given: str | None, found: str) -> _Found | None:
    if given is None:
        return None
    said = f"these {what} have the hash {found}"
    other = given.strip().lower() != found
    return _Found([given.strip()] if other else [], f"{said}, not {given.strip()}", said)


def _luck(study: _Study) -> _Found:
    """Truth and reports follow from the choices, the box and the seed."""
    again, left = study.again, sum(one.unplayed for one in study.again)
    read = _also(sum(one.read_as_recorded for one in again), "take what a camera read from their records")
    more = "more need a plant or an intervention that does not ship, or a real box, and are not played"
    follow = "follow from their choices, the box and the seed"
    failed = [f"{one.key}: {one.luck}" for one in again if one.luck]
    return _Found(
        failed, f"{{n}} trials do not {follow}", f"all {len(again) - left} trials {follow}{read}{_also(left, more)}"
    )


def _choices(study: _Study) -> _Found:
    """Strategies choose the same again, local models by their probabilities, and nobody the impossible."""
    counts = Counter(one.kind for one in study.again if not one.unplayed or one.kind == "own")
    unasked = sum(one.unplayed and one.kind in ("strategy", "local") for one in study.again)
    failed = [f"{one.key}: {one.choices}" for one in study.again if one.choices and one.kind != "hosted"]
    local = f"; those of {counts['local']} trials of local models follow from their recorded probabilities"
    own = f"; those of {counts['own']} trials of your own agents cannot be recomputed"
    holds = f"{counts['strategy']} trials of strategies are the same when they are asked again"
    holds += (
        local * bool(counts["local"])
        + _also(unasked, "more of both are not asked, since they are not played")
        + own * bool(counts["own"])
    )
    return _Found(failed, "{n} trials differ from what their agents choose", holds)


def _agents(study: _Study) -> _Found:
    """An agent is the same in all its trials, and a model the one that its spec names."""
    known, failed = dict[tuple[str, str], object](), dict[str, None]()
    for trial in study.opened.trials:
        for name, value in lasting_facts(trial).items():
            if value is not None and known.setdefault((trial.agent, name), value) != value:
                failed[f"{trial.key}: {name} is {value}, and {known[trial.agent, name]} in other trials"] = None
        if why := _another_model(trial):
            failed[f"{trial.key}: {why}"] = None
    holds = "every agent says the same of itself in all its trials"
    return _Found([*failed], "{n} trials differ in what they say of their agent", holds)


def _another_model(trial: Trial) -> str:
    """What the facts of a hosted model have otherwise than its spec; empty if nothing."""
    if kind_of(trial.agent) != "hosted" or not trial.facts:
        return ""
    try:
        name, _ = read_settings(trial.agent)
    except UserMistake as mistake:
        return str(mistake)
    for fact, value in {"model": name, **Spec.parse(trial.agent).options}.items():
        there = trial.facts.get(fact)
        if there is not None and str(there) != value and not _equal(there, value):
            return f"{fact} is {there} in its record and {value} in its spec"
    return ""


def _equal(fact: object, text: str) -> bool:
    try:
        return isinstance(fact, int | float) and float(text) == fact
    except ValueError:
        return False


def _replies(study: _Study) -> _Found | None:
    """Decisions of hosted models are the replies in the log of calls, and these are all decisions."""
    return _of_calls(study.calls, study.opened.trials, study.again, study.owed)


def _fork_replies(study: _Study) -> _Found | None:
    return _of_calls(study.fork_calls, study.opened.forks, study.forks, {}) if study.opened.forks else None


def _of_calls(
    calls: CallEvidence, trials: Sequence[Trial], again: Sequence[ReplayedTrial], owed: dict[str, Plan]
) -> _Found | None:
    hosted = [one for one in again if one.kind == "hosted"]
    if not hosted and not calls.calls and not calls.asked:
        return None
    before = sum(call.reply is not None for call in calls.calls) - sum(map(len, calls.kept.values()))
    unplayed = "of these trials are not played, and held by their words and joints alone"
    holds = f"{sum(len(calls.kept.get(one.key, ())) for one in hosted)} replies in calls.jsonl are the decisions of "
    holds += f"{len(hosted)} trials, and all of them{_also(sum(one.unplayed for one in hosted), unplayed)}"
    holds += _also(before, "earlier replies are of trials that were played again on request")
    failed = [*calls.contradictions(trials, hosted, owed)]
    return _Found(failed, "{n} contradictions between calls.jsonl and trials.jsonl", holds)


def _attempts(study: _Study) -> _Found | None:
    """Steps of people and clients are the attempts in their diaries and in ``attempts.jsonl``, and all of them."""
    opened, logged = study.opened, AttemptLog.read(study.opened.directory)
    clients = [trial for trial in opened.trials if spec_kind(trial.agent) == MCP]
    people, diaries = [trial for trial in opened.trials if trial.player], {diary.spec for diary in opened.diaries}
    if not (clients or people or logged or diaries):
        return None
    failed = [
        *(f"{trial.key}: {why}" for trial in clients if (why := _unlike(trial, logged.get(trial.key, ())))),
        *(f"{key}: attempts of no trial of this study" for key in logged.keys() - {*study.trials, *study.plans}),
        *(f"{trial.key}: its player has no diary" for trial in people if diaries and trial.agent not in diaries),
        *(why for diary in opened.diaries for why in _against_diary(study, diary)),
    ]
    held, rest = len(clients) + len(people) * bool(diaries), _also(0 if diaries else len(people), "have no diaries")
    holds = f"{held} trials of clients and people are as their servers wrote them step by step{rest}"
    return _Found(failed, "{n} contradictions between trials.jsonl and the logs of attempts", holds)


def _unlike(trial: Trial, attempts: Sequence[RecordedAttempt]) -> str:
    """The first difference between a trial and the attempts in a log; empty without one."""
    if trial.owed_again:  # its box broke: the log starts anew
        return ""
    if len(attempts) != len(trial.steps):
        return f"{len(trial.steps)} steps, and {len(attempts)} attempts in its log"
    for step, attempt in zip(trial.steps, attempts, strict=True):
        said = step.decision
        if attempt != RecordedAttempt(said.joint, said.claimed, step.told, said.hypothesis):
            return f"step {step.step} is another one in its log"
    return ""


def _against_diary(study: _Study, diary: Diary) -> Iterator[str]:
    """What a diary and the records have differently."""
    for box in range(1, len(diary.joined.slots) + 1):
        acts, key = diary.attempts(box), key_of(study.opened.study, diary, box)
        trial = study.trials.get(key)
        if trial is not None and trial.agent == diary.spec:
            made = [(one.act, one.told) for one in acts]
            attempts = [RecordedAttempt(act.joint, act.claimed, told) for act, told in made if isinstance(act, Attempt)]
            if why := _unlike(trial, attempts):
                yield f"{key}: {why}"
        elif trial is None and acts and acts[-1].ended is not None:
            yield f"{key}: it ended in the diary of {diary.spec} and is not on record"


def _forks(study: _Study) -> _Found | None:
    """Forks follow from the records of their trials, their choices and the seed."""
    opened = study.opened
    if not opened.forks:
        return None
    there, own, failed = read_study(opened.directory / FORKS), opened.study, list[str]()
    if list(map(there.record_identity, there.conditions)) != list(map(own.record_identity, own.conditions)):
        failed.append(f"{FORKS}/study.json: the settings of another study")
    for one in study.forks:  # choices of hosted models have a check of their own
        if why := one.luck or one.choices * (one.kind != "hosted"):
            failed.append(f"{one.key}: {why}")
    by_key = {fork.key: fork for fork in opened.forks}
    for key, chances in opened.choices.items():
        planned = study.planned(by_key[key]) if key in by_key else "no fork on record has it"
        if isinstance(planned, str):
            failed.append(f"{key}: a next choice, but {planned}")
            continue
        (name, plan), agent = planned, by_key[key].agent
        policy = resolve(agent).make() if is_strategy(agent) else None
        if not isinstance(policy, Policy) or asyncio.run(next_choice(plan, policy, name.at)) != chances:
            failed.append(f"{key}: another next choice than its strategy has")
    holds = f"all {len(study.forks)} forks follow from their trials, their choices and the seed"
    return _Found(failed, "{n} forks do not follow from their trials, their choices and the seed", holds)


def _pictures(study: _Study) -> _Found | None:
    """Every picture that is there is the one of its name."""
    names = sorted({name for trial in study.opened.trials for name in trial.picture_names})
    album = study.opened.directory / ALBUM
    there = [name for name in names if (album / name).is_file()]
    failed = [name for name in there if Picture(kind="rgb", png=read_input(album / name)).name != name]
    missing = _also(len(names) - len(there), "are not there")
    holds = f"{len(there)} pictures are those that the records name{missing}"
    return _Found(failed, "{n} pictures are not those that the records name", holds) if names else None


def _results(study: _Study) -> _Found:
    """``results.json`` is what the records give."""
    found = study.report
    if found is None or isinstance(found, str):
        return _Found([found] if found else [], found or "", "there is no report to compare")
    of, packages = found.of_packages, ", ".join(dict.fromkeys(found.of_packages))
    rest = f"; {len(of)} of its rows are not checked: they come from {packages}" if of else ""
    holds = f"results.json is what the records give{rest}"
    return _Found(found.results, f"{{n}} lines of results.json differ{found.advice}", holds)


def _report(study: _Study) -> _Found | None:
    """The page, the tables and the figures are what the records give."""
    found = study.report
    if found is None or isinstance(found, str):
        return None
    holds = f"{found.there} pages, tables and figures are what the records give{_also(found.missing, 'are not there')}"
    fails = f"{{n}} pages, tables and figures are not what the records give{found.advice}"
    return _Found(found.different, fails, holds)


_CHECKS: dict[str, Callable[[_Study], _Found | None]] = {
    "records": _records,
    "settings": _settings,
    "complete": _complete,
    "settings hash": lambda study: _hash("settings", study.settings, study.opened.study.settings_hash),
    "results hash": lambda study: _hash(
        "results", study.results, results_hash(study.opened.study, study.opened.trials)
    ),
    "luck": _luck,
    "choices": _choices,
    "agents": _agents,
    "replies": _replies,
    "attempts": _attempts,
    "forks": _forks,
    "fork replies": _fork_replies,
    "pictures": _pictures,
    "results": _results,
    "report": _report,
}
"""Every check by its name, in the order in which they are made; one that does not apply finds nothing."""
