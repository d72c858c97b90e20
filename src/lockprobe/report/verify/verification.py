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
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path

from lockprobe.foundation.errors import BadValue, LockprobeError, UserMistake
from lockprobe.foundation.inputs import read_input
from lockprobe.foundation.plugins import no_foreign_code
from lockprobe.foundation.storage.jsonl import whole_lines, without_checksum
from lockprobe.interventions.catalogue import interventions_of
from lockprobe.people.step_times import times_of_steps
from lockprobe.report.opened import OpenedStudy, open_study
from lockprobe.report.verify.check import Check, also, check_of
from lockprobe.report.verify.checked_attempts import attempts_check
from lockprobe.report.verify.checked_forks import fork_checks
from lockprobe.report.verify.checked_replies import CallEvidence, agent_check, replies_check
from lockprobe.report.verify.checked_report import report_checks
from lockprobe.report.verify.replayed_trials import UNPLAYED, Replay, ReplayedTrial, is_foreign
from lockprobe.studies.branch import FORKS
from lockprobe.studies.file_names import ASKED, ATTEMPTS, CALLS, PEOPLE_DIRECTORY, RECORDS
from lockprobe.studies.records.journal import read_timings
from lockprobe.studies.records.picture_store import ALBUM
from lockprobe.studies.records.results_hash import results_hash
from lockprobe.studies.stopping import due
from lockprobe.trial.condition import Condition
from lockprobe.trial.pictures.picture import Picture
from lockprobe.trial.plan import Plan
from lockprobe.trial.protocols import InterventionTraits

NOT_SHOWN = (
    "No such check can show that the plan was changed, the seed chosen, or an agent or a person left out before these "
    "records were made, or that all files were made up together (calls.jsonl, answers of people and of local models, "
    "clock readings). To be safe against it: put the hash of the settings, which run prints before the first trial, "
    "under a preregistration, and that of the results under the paper; --settings HASH and --results HASH check them"
)
"""What verification cannot find, and what helps against it."""

_LOGS = (RECORDS, CALLS, ASKED, ATTEMPTS)
"""Files whose every line has a checksum."""


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
            checks = list(_of_records(opened, settings, results, tell))
        except LockprobeError as error:
            return (Check(name="records", holds=False, said=str(error)),)
        return (*checks, *report_checks(opened, processes=processes))


def _of_records(
    opened: OpenedStudy, settings: str | None, results: str | None, tell: Callable[[int, int], None]
) -> Iterator[Check]:
    """The checks of all but the report."""
    times_of_steps(opened.study, opened.trials, opened.diaries, opened.directory)  # diaries and records agree
    evidence = CallEvidence.of(opened.directory)
    again = tuple(_replayed(opened, evidence, tell))
    there = {trial.key for trial in opened.trials if not trial.owed_again}
    planned = (plan for agent in opened.study.run_agents for plan in opened.study.plans(agent))
    owed = {plan.key: plan for plan in planned if plan.key not in there}
    yield _records(opened, evidence)
    yield _settings(opened)
    yield _complete(opened, owed if opened.study.until is None else _due(opened))
    yield from _of_hashes(opened, settings, results)
    yield _luck(again)
    yield _choices(again)
    yield agent_check(opened.trials)
    yield from replies_check(opened.directory, opened.trials, evidence, again, owed)
    yield from attempts_check(opened)
    yield from fork_checks(opened, evidence)
    yield from _pictures(opened)


def _records(opened: OpenedStudy, evidence: CallEvidence) -> Check:
    """Whether every line has its checksum and no trial has two records; how many trials ended as an error."""
    directory, lines = opened.directory, 0
    logs = [*(directory / name for name in _LOGS), *(directory / FORKS / name for name in _LOGS)]
    failed = list[str]()
    for path in (*logs, *sorted((directory / PEOPLE_DIRECTORY).glob("*.jsonl"))):
        for number, line in whole_lines(path) if path.is_file() else ():
            lines += path == directory / RECORDS
            try:
                without_checksum(line)
            except BadValue as error:
                failed.append(f"{path.relative_to(directory)}, line {number}: {error}")
    if twice := opened.journal.contradicted:
        failed.append(f"{RECORDS}: {twice} finished trials have a second record that differs")
    broken = Counter(trial.error.boundary for trial in opened.trials if trial.error is not None)
    where = f" ({', '.join(f'{name} {broken[name]}' for name in sorted(broken))})" if broken else ""
    ended = f"{broken.total()} of {len(opened.trials)} trials ended as an error{where}"
    holds = f"{lines} lines and {len(evidence.calls)} calls, unchanged; {ended}"
    return check_of("records", failed, holds, f"lines with a wrong checksum or of a second record; {ended}")


def _settings(opened: OpenedStudy) -> Check:
    """Whether all records are of this study: its seed, box, budget, conditions and panels."""
    foreign, study = opened.foreign + opened.journal.foreign, opened.study
    said = f"all {len(opened.trials)} trials are of seed {study.seed} and these settings, {study.settings_hash}"
    other = tuple(_other_doses(opened.study.conditions))
    if other:
        said = f"{len(other)} interventions have other doses than study.json says"
    if foreign:
        first = f"; {opened.journal.first_foreign}" if opened.journal.first_foreign else ""
        said = f"{foreign} records are of another seed or of other settings{first}"
    return Check(name="settings", holds=not (foreign or other), said=said, failed=other)


def _other_doses(conditions: Sequence[Condition]) -> Iterator[str]:
    """Interventions of Lockprobe's own whose doses in the settings are not those that they have."""
    for condition in conditions:
        for spec, doses in condition.acting:
            if not is_foreign("intervention", spec) and (own := _doses_of(spec, doses)) != doses:
                found, said = (", ".join(names) or "none" for names in (own, doses))
                yield f"{condition.label}: the doses of {spec} are {found}, not {said}"


def _doses_of(spec: str, recorded: tuple[str, ...]) -> tuple[str, ...]:
    """The doses of an intervention; the recorded ones where it cannot be made here, as without the file of a prompt."""
    try:
        (made,) = interventions_of(spec)
    except UserMistake:
        return recorded
    return InterventionTraits.of(made).doses


def _due(opened: OpenedStudy) -> dict[str, Plan]:
    """What a study that stops when it is decided has to play before its next look; nothing if it may stop."""
    study = opened.study
    return {plan.key: plan for agent in study.run_agents for plan in due(study, agent, opened.trials)}


def _complete(opened: OpenedStudy, owed: Mapping[str, Plan]) -> Check:
    """Whether every planned trial of agents is there, and every trial that was timed; participants owe none."""
    known = {*owed, *(trial.key for trial in opened.trials)}
    others = opened.foreign or opened.journal.foreign
    timed = [] if others else [one.key for one in read_timings(opened.directory) if one.key not in known]
    until = f"trial that it needs until {until}" if (until := opened.study.until) else "planned trial"
    said = f"{len(owed)} planned trials are missing" if owed else f"every {until} is there"
    if opened.study.invited:
        played = sum(bool(trial.player) for trial in opened.trials)
        said += f"; of people {played} of {opened.study.invited}, who owe none"
    said += also(len(timed), "trials in timings.jsonl are not on record")
    return Check(name="complete", holds=not (owed or timed), said=said, failed=(*owed, *timed))


def _of_hashes(opened: OpenedStudy, settings: str | None, results: str | None) -> Iterator[Check]:
    """Whether settings and records are those of the published hashes."""
    study = opened.study
    if settings is not None:
        yield hash_check("settings", settings, study.settings_hash)
    if results is not None:
        yield hash_check("results", results, results_hash(study, opened.trials))


def hash_check(what: str, given: str, found: str) -> Check:
    """Whether a published hash is the one that was computed.

    Args:
        what: What it is of, ``settings`` or ``results``.
        given: The published hash.
        found: The computed hash.
    """
    holds = given.strip().lower() == found
    said = f"these {what} have the hash {found}{'' if holds else f', not {given.strip()}'}"
    return Check(name=f"{what} hash", holds=holds, said=said)


def _replayed(opened: OpenedStudy, evidence: CallEvidence, tell: Callable[[int, int], None]) -> Iterator[ReplayedTrial]:
    """Every trial, played again."""
    study = opened.study
    with asyncio.Runner() as runner:
        replay = Replay(runner)
        for done, trial in enumerate(opened.trials, 1):
            condition = study.condition_of(trial)
            assert condition is not None  # only trials that the settings ask for are opened
            plan = study.plan(trial.agent, condition, trial.repetition, trial.trial)
            yield replay(plan, trial, evidence.kept.get(trial.key, ()))
            tell(done, len(opened.trials))


def _luck(again: Sequence[ReplayedTrial]) -> Check:
    """Whether truth and reports follow from the choices, the box and the seed."""
    failed = [f"{one.key}: {one.luck}" for one in again if one.luck]
    left = sum(one.unplayed for one in again)
    follow = "follow from their choices, the box and the seed"
    read = also(sum(one.read_as_recorded for one in again), "take what a camera read from their records")
    holds = f"all {len(again) - left} trials {follow}{read}{also(left, f'more need {UNPLAYED}, and are not played')}"
    return check_of("luck", failed, holds, "trials do not follow from their choices, the box and the seed")


def _choices(again: Sequence[ReplayedTrial]) -> Check:
    """Whether strategies choose the same again, local models by their probabilities, and nobody the impossible."""
    counts = Counter(one.kind for one in again if not one.unplayed or one.kind == "own")
    unasked = sum(one.unplayed and one.kind in ("strategy", "local") for one in again)
    failed = [f"{one.key}: {one.choices}" for one in again if one.choices and one.kind != "hosted"]
    local = f"those of {counts['local']} trials of local models follow from their recorded probabilities"
    own = f"those of {counts['own']} trials of your own agents cannot be recomputed"
    said = [
        f"{counts['strategy']} trials of strategies are the same when they are asked again",
        local * bool(counts["local"]),
        f"{unasked} more of both are not asked, since they are not played" * bool(unasked),
        own * bool(counts["own"]),
    ]
    return check_of("choices", failed, "; ".join(filter(None, said)), "trials differ from what their agents choose")


def _pictures(opened: OpenedStudy) -> Iterator[Check]:
    """Whether every picture that is there is the one of its name; nothing without pictures."""
    names = sorted({name for trial in opened.trials for name in trial.picture_names})
    if not names:
        return
    album = opened.directory / ALBUM
    there = [name for name in names if (album / name).is_file()]
    failed = [name for name in there if Picture(kind="rgb", png=read_input(album / name)).name != name]
    missing = also(len(names) - len(there), "are not there")
    holds = f"{len(there)} pictures are those that the records name{missing}"
    yield check_of("pictures", failed, holds, "pictures are not those that the records name")
