"""Merges trials that were played elsewhere (logs, other directories) into the directory of a study.

Only trials of the same study are merged: all settings except the agents must be equal. A finished trial of the
directory stays; an owed or broken trial is replaced. For a trial that is finished nowhere the calls are merged, so that
it resumes from paid replies.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from lockprobe.agents.mcp_client import SAME_IN_ALL_TRIALS
from lockprobe.agents.participant import check_participant
from lockprobe.foundation.errors import BadFile, BadValue, UserMistake
from lockprobe.foundation.grouping import grouped
from lockprobe.foundation.inputs import read_input
from lockprobe.foundation.spec import MCP, spec_kind
from lockprobe.studies.costs.call_log import read_calls
from lockprobe.studies.file_names import SETTINGS
from lockprobe.studies.records.attempt_log import AttemptLog
from lockprobe.studies.records.directory import read_study, write_settings
from lockprobe.studies.records.journal import Journal
from lockprobe.studies.records.picture_store import ALBUM, Album
from lockprobe.studies.records.read_records import load
from lockprobe.studies.records.trial_rows import Timing, read_timings
from lockprobe.studies.running.paused_trial import RecordedAttempt
from lockprobe.studies.study import WHO, Study
from lockprobe.trial.model_call import Call
from lockprobe.trial.pictures.picture import Picture
from lockprobe.trial.record import Fact, Trial

_PLANT_FACTS = ("engine", "renderer")


@dataclass(frozen=True, slots=True, kw_only=True)
class MergeSource:
    """A source of trials that were played elsewhere.

    Attributes:
        path: The path of the source, for messages.
        study: Their study.
        trials: The trials.
        unfinished: Keys of trials that were begun there and have no record.
        timings: Key -> how long the trial took, if known.
        calls: The provider calls there.
        attempts: Key -> attempts of a client with tools, from its server's log.
        picture: Function from the name of a picture to its bytes; None for a missing picture.
    """

    path: Path
    study: Study
    trials: tuple[Trial, ...]
    unfinished: frozenset[str] = frozenset()
    timings: Mapping[str, Timing] = field(default_factory=dict)
    calls: tuple[Call, ...] = ()
    attempts: Mapping[str, Sequence[RecordedAttempt]] = field(default_factory=dict)
    picture: Callable[[str], bytes | None] = lambda name: None


@dataclass(frozen=True, slots=True, kw_only=True)
class Gathered:
    """The counts of a merge.

    Attributes:
        taken: Trials added to the directory.
        there: Trials that the directory had already finished.
        different: Trials finished on both sides with different records; the directory's records stay.
        unfinished: Trials begun in a source and finished nowhere; they are owed.
        replies: Replies added for unfinished trials, which resume from them.
        agents: Agents that were new to the study.
        pictures_missing: Pictures named by added trials that were not found.
    """

    taken: int
    there: int
    different: int
    unfinished: int
    replies: int
    agents: tuple[str, ...]
    pictures_missing: int


def source_of_directory(directory: Path) -> MergeSource:
    """The directory of a study as a source.

    Raises:
        BadFile: If it is not the directory of a study, or something in it is damaged.
    """
    trials, calls, timings = tuple(load(directory)), tuple(read_calls(directory)), read_timings(directory)
    return MergeSource(
        path=directory,
        study=read_study(directory),
        trials=trials,
        unfinished=frozenset(call.key for call in calls) - {trial.key for trial in trials},
        timings={timing.key: timing for timing in timings},
        calls=calls,
        attempts=AttemptLog.read(directory),
        picture=picture_of(directory),
    )


def picture_of(directory: Path) -> Callable[[str], bytes | None]:
    """The function from the name of a picture in a directory to its bytes; None for a missing one."""

    def picture(name: str) -> bytes | None:
        file = directory / ALBUM / name
        return read_input(file) if file.is_file() else None

    return picture


def gather(
    directory: Path, sources: Sequence[MergeSource], beside: Callable[[Journal], None] = lambda journal: None
) -> Gathered:
    """Merge sources into a directory, which is created if missing. Idempotent.

    Args:
        directory: The directory of the study.
        sources: The sources; earlier ones have precedence.
        beside: Called with the journal of the merged directory while it is still open.

    Raises:
        BadValue: If there is no source.
        BadFile: If trials belong to another study, two agents have the same name, or there is neither a study nor a
            source to create it from.
        DirectoryBusy: If another process is writing there.
    """
    if not sources:
        raise BadValue("sources", 0, "at least one")
    known = read_study(directory) if (directory / SETTINGS).exists() else None
    finished = [_finished(source) for source in sources]
    names = {spec: name for source in reversed(finished) for spec, name in source.study.names.items()}
    names |= known.names if known else {}
    own = _agents(finished) or sources[0].study.agents
    first = known or replace(sources[0].study, agents=own, names=names)
    sizes = [one.earlier for one in (*([known] if known else ()), *(one.study for one in finished))]
    first = replace(first, shard=None, earlier=max(sizes, key=len))  # of the study that was extended most often
    joined = replace(first, agents=tuple(dict.fromkeys((*first.agents, *_agents(finished)))), names=names)
    for source in finished:
        _refuse_another_study(source, joined, directory)
    if known is None and not any(source.trials or source.calls for source in finished):
        raise BadFile(sources[0].path, f"no trial in it is finished, so {directory} is not made")
    if known is None:
        _refuse_another_agent(directory, (), finished)
    with Journal.open(directory, first) as journal:
        _refuse_another_agent(directory, journal.trials.values(), finished)
        if joined.agents != first.agents:
            write_settings(directory, joined)
        book, there = _CallMerger(journal), dict(journal.trials)
        log = AttemptLog(journal.store)
        counts = [_take(source, journal, book, log, there) for source in finished]
        replies = sum(book.take_begun(source) for source in finished)
        unfinished = sum(map(journal.owes, {key for source in finished for key in source.unfinished}))
        beside(journal)
    taken, kept, different, missing = (sum(column) for column in zip(*counts, strict=True))
    return Gathered(
        taken=taken,
        there=kept,
        different=different,
        unfinished=unfinished,
        replies=replies,
        agents=joined.labels if known is None else joined.labels[len(first.agents) :],
        pictures_missing=missing,
    )


def _finished(source: MergeSource) -> MergeSource:
    """The source with finished trials only; other trials become unfinished, and calls are limited to its study."""
    trials = tuple(trial for trial in source.trials if not trial.owed_again)
    unfinished = source.unfinished | {trial.key for trial in source.trials if trial.owed_again}
    known = {trial.key for trial in trials} | {key for keys in _begun(source, unfinished).values() for key in keys}
    calls = tuple(call for call in source.calls if call.key in known)
    unfinished -= {call.key for call in source.calls} - known
    return replace(source, trials=trials, unfinished=unfinished, calls=calls)


def _begun(source: MergeSource, unfinished: frozenset[str]) -> dict[str, set[str]]:
    """Agent -> its unfinished trials with recorded calls."""
    asked = {call.key for call in source.calls} & unfinished
    if not asked:
        return {}
    return {agent: asked & {plan.key for plan in source.study.plans(agent)} for agent in source.study.agents}


def _agents(sources: Iterable[MergeSource]) -> tuple[str, ...]:
    """The agents with trials or calls, each once, in the order of the study."""
    found: list[str] = []
    for source in sources:
        playing = {trial.spec for trial in source.trials}
        playing |= {agent for agent, keys in _begun(source, source.unfinished).items() if keys}
        found += [agent for agent in source.study.agents if agent in playing]
    return tuple(dict.fromkeys(found))


def _refuse_another_study(source: MergeSource, joined: Study, directory: Path) -> None:
    for name, values in (joined.differences(source.study, but=WHO) | joined.renamed(source.study)).items():
        there, here = (repr(one)[:200] for one in values)
        raise BadFile(source.path, f"trials of another study than {directory} ({name} is {there}, not {here})")
    for trial in source.trials:
        try:
            if trial.player:
                check_participant(trial.agent)
        except UserMistake as mistake:
            raise BadFile(source.path, f"{trial.key}: {mistake}") from None
    own = {id(trial) for trial in joined.own_trials(source.trials)}
    for trial in source.trials:
        if id(trial) not in own:
            raise BadFile(source.path, f"{trial.key} is no trial of that study")


class _IdentityCheck:
    """Refuses different models, prompts, runtimes or renderers under one name, as a resumed run does.

    Facts about people's devices and clients' connections may differ between trials.
    """

    def __init__(self, directory: Path, trials: Iterable[Trial]) -> None:
        self._directory = directory
        self._known: dict[tuple[str, str], Fact] = {}
        for trial in trials:
            self._known |= self._facts(trial)

    def _facts(self, trial: Trial) -> dict[tuple[str, str], Fact]:
        said = lasting_facts(trial)
        facts = {(trial.agent, name): value for name, value in said.items()}
        plant = f"the plant {trial.plant.get('plant', '')}".rstrip()
        return facts | {(plant, name): trial.plant[name] for name in _PLANT_FACTS if name in trial.plant}

    def check(self, source: MergeSource) -> None:
        for trial in source.trials:
            for (what, name), value in self._facts(trial).items():
                here = self._known.setdefault((what, name), value)
                if here is not None and value is not None and here != value:
                    why = f"{what} is not the same there ({name} is {value!r}, {here!r} in {self._directory})"
                    raise BadFile(source.path, f"0 trials taken: {why}; import it into another directory")


def lasting_facts(trial: Trial) -> Mapping[str, Fact]:
    """The facts of an agent that are the same in all its trials."""
    if trial.player:
        return {}
    if spec_kind(trial.agent) == MCP:
        return {name: trial.facts[name] for name in SAME_IN_ALL_TRIALS if name in trial.facts}
    return trial.facts


def _refuse_another_agent(directory: Path, trials: Iterable[Trial], sources: Iterable[MergeSource]) -> None:
    same = _IdentityCheck(directory, trials)
    for source in sources:
        same.check(source)


class _CallMerger:
    """Merges calls idempotently: each is written once, however often an import is repeated."""

    def __init__(self, journal: Journal) -> None:
        self._journal = journal
        self._there: defaultdict[str, Counter[Call]] = defaultdict(Counter)
        for call in read_calls(journal.directory):
            self._there[call.key][call] += 1

    def take(self, calls: Sequence[Call]) -> list[Call]:
        """Write the missing calls of one trial, and return them."""
        found, left = [], self._there[calls[0].key].copy() if calls else Counter[Call]()
        for call in calls:
            if left[call]:
                left[call] -= 1
                continue
            self._journal.calls.write(call)
            self._there[call.key][call] += 1
            found.append(call)
        return found

    def take_begun(self, source: MergeSource) -> int:
        """Merge the replies of unfinished trials and count them; a trial begun differently here keeps its own."""
        replies = 0
        for key, calls in grouped(source.calls, lambda call: call.key).items():
            if key in source.unfinished and self._journal.owes(key) and self._there[key] <= Counter(calls):
                replies += sum(call.reply is not None for call in self.take(calls))
        return replies


def _take(
    source: MergeSource, journal: Journal, book: _CallMerger, log: AttemptLog, there: dict[str, Trial]
) -> tuple[int, int, int, int]:
    """Merge the finished trials; returns the counts taken, there, different and pictures missing.

    A trial's calls and attempts are on disk before it counts as finished. ``there`` holds the records with their steps,
    which an open journal forgets; those that are taken are added to it.
    """
    album, missing = Album(journal.directory / ALBUM), 0
    owed = [trial for trial in source.trials if journal.owes(trial.key)]
    kept = [trial for trial in source.trials if not journal.owes(trial.key)]
    # how often a trial was replayed says what its journal held before
    different = sum(replace(there[trial.key], replays=0) != replace(trial, replays=0) for trial in kept)
    calls = grouped(source.calls, lambda call: call.key)
    for trial in owed:
        book.take(calls.get(trial.key, ()))
        log.replace(trial.key, source.attempts.get(trial.key, ()))
        for name in sorted(trial.picture_names):
            png = source.picture(name)
            picture = None if png is None else Picture(kind="rgb", png=png)
            if picture is None or picture.name != name:
                missing += 1
            else:
                album.keep(picture)
        there[trial.key] = trial
        unknown = Timing(key=trial.key, seconds=0.0, steps=len(trial.steps))
        journal.append(trial, source.timings.get(trial.key, unknown))
    return len(owed), len(kept), different, missing
