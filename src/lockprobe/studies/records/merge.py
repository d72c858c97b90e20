"""Merges trials that were played elsewhere, in other directories, into the directory of a study: whole or not at all.

Only trials of the same study are merged: all settings except the agents must be equal. A finished trial of the
directory stays; an owed or broken trial is replaced. For a trial that is finished nowhere the calls are merged, so that
it resumes from paid replies.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path

from lockprobe.agents.outside import check_participant
from lockprobe.foundation.errors import BadFile, BadValue, UserMistake
from lockprobe.foundation.grouping import grouped
from lockprobe.foundation.inputs import read_input
from lockprobe.foundation.storage.atomic_file import write_file
from lockprobe.studies.costs.call_log import read_calls
from lockprobe.studies.file_names import SETTINGS
from lockprobe.studies.records.attempt_log import AttemptLog
from lockprobe.studies.records.directory import read_study, write_settings
from lockprobe.studies.records.journal import Journal
from lockprobe.studies.records.known_facts import KnownFacts
from lockprobe.studies.records.picture_store import ALBUM, Album
from lockprobe.studies.records.read_records import on_record
from lockprobe.studies.records.store import read
from lockprobe.studies.records.trial_rows import COLUMNS, OnRecord, TrialRow, trial_in
from lockprobe.studies.study import WHO, Study
from lockprobe.trial.model_call import Call
from lockprobe.trial.pictures.picture import Picture
from lockprobe.trial.record import Trial
from lockprobe.trial.trial_reader import TrialReader

_TOGETHER = 1000
"""Records that are checked together."""


@dataclass(frozen=True, slots=True, kw_only=True)
class MergeSource:
    """The directory of a study whose trials are merged.

    Attributes:
        directory: Its settings and its store; every record in it can be read.
        album: The directory of its pictures.
        study: The study.
        trials: What is on record of it, by key.
        calls: The provider calls there.
    """

    directory: Path
    album: Path
    study: Study
    trials: Mapping[str, OnRecord]
    calls: tuple[Call, ...]

    @property
    def finished(self) -> dict[str, OnRecord]:
        """The trials that are not owed, by key."""
        return {key: one for key, one in self.trials.items() if not one.owed_again}

    @property
    def begun(self) -> dict[str, str]:
        """Key of a trial that was begun and is not finished -> its agent; only planned ones with calls."""
        asked = {call.key for call in self.calls} - self.finished.keys()
        plans = (plan for agent in self.study.agents for plan in self.study.plans(agent)) if asked else ()
        return {plan.key: plan.agent for plan in plans if plan.key in asked}

    @property
    def agents(self) -> tuple[str, ...]:
        """The agents with finished trials or calls, in the order of the study."""
        playing = {one.spec for one in self.finished.values()} | {*self.begun.values()}
        return tuple(agent for agent in self.study.agents if agent in playing)


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


def source_of_directory(directory: Path, album: Path | None = None) -> MergeSource:
    """The directory of a study as a source; its pictures may lie elsewhere.

    Raises:
        BadFile: If it is not the directory of a study, or something in it is damaged.
    """
    study, reader = read_study(directory), TrialReader()
    with read(directory) as store:
        for key, record in store.rows("select key, record from trial"):
            trial_in(store, reader, key, record)
        trials, _ = on_record(store, study)
    AttemptLog.read(directory)
    calls = tuple(read_calls(directory))
    return MergeSource(directory=directory, album=album or directory / ALBUM, study=study, trials=trials, calls=calls)


def gather(
    directory: Path, sources: Sequence[MergeSource], beside: Callable[[Journal], None] = lambda journal: None
) -> Gathered:
    """Merge sources into a directory, which is created if missing: all of them or nothing. Idempotent.

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
    names = {spec: name for source in reversed(sources) for spec, name in source.study.names.items()}
    names |= known.names if known else {}
    coming = tuple(dict.fromkeys(agent for source in sources for agent in source.agents))
    first = known or replace(sources[0].study, agents=coming or sources[0].study.agents, names=names)
    sizes = [one.earlier for one in (*([known] if known else ()), *(one.study for one in sources))]
    first = replace(first, shard=None, earlier=max(sizes, key=len))  # of the study that was extended most often
    joined = replace(first, agents=tuple(dict.fromkeys((*first.agents, *coming))), names=names)
    for source in sources:
        _refuse_another_study(source, joined, directory)
    if known is None and not any(source.finished or source.begun for source in sources):
        raise BadFile(sources[0].directory, f"no trial in it is finished, so {directory} is not made")
    with Journal.open(directory, first) as journal:
        settings, kept = (directory / SETTINGS).read_bytes(), False
        if joined.agents != first.agents:
            write_settings(directory, joined)
        try:
            with journal.store.transaction(sync=True):
                merger = _Merger(journal, joined)
                for source in sources:
                    merger.take(source)
                merger.take_pictures()  # before the records that name them
                replies = sum(map(merger.take_begun, sources))
                unfinished = sum(map(journal.owes, {key for source in sources for key in _unfinished(source)}))
                beside(journal)
            kept = True
        finally:
            journal.used = journal.calls.used = kept
            if not kept:  # also after Ctrl-C: no agent without the trials that came with it
                write_file(directory / SETTINGS, settings)
    return Gathered(
        taken=merger.taken,
        there=merger.there,
        different=merger.different,
        unfinished=unfinished,
        replies=replies,
        agents=joined.labels if known is None else joined.labels[len(first.agents) :],
        pictures_missing=merger.missing,
    )


def _unfinished(source: MergeSource) -> set[str]:
    """The keys of trials that were begun in a source, with a call or until they broke, and not finished."""
    return {*source.begun, *(key for key, one in source.trials.items() if one.owed_again)}


def _refuse_another_study(source: MergeSource, joined: Study, directory: Path) -> None:
    for name, values in (joined.differences(source.study, but=WHO) | joined.renamed(source.study)).items():
        there, here = (repr(one)[:200] for one in values)
        raise BadFile(source.directory, f"trials of another study than {directory} ({name} is {there}, not {here})")
    for one in source.finished.values():
        try:
            if one.player:
                check_participant(one.player)
        except UserMistake as mistake:
            raise BadFile(source.directory, f"{one.key}: {mistake}") from None


class _Merger:
    """Takes what sources have into an open journal, and counts it.

    Refuses different models, prompts, runtimes or renderers under one name, as a resumed run does.

    Attributes:
        taken, there, different, missing: The counts of :class:`Gathered`, the last of pictures.
    """

    def __init__(self, journal: Journal, joined: Study) -> None:
        self.taken = self.there = self.different = self.missing = 0
        self._journal, self._joined, self._pictures = journal, joined, dict[str, Path]()
        self._facts, self._log = KnownFacts(journal.kinds()), AttemptLog(journal.store)
        self._calls: defaultdict[str, Counter[Call]] = defaultdict(Counter)
        for call in read_calls(journal.directory):
            self._calls[call.key][call] += 1

    def take(self, source: MergeSource) -> None:
        """Merge the finished trials of a source, each with its calls and attempts.

        Raises:
            BadFile: If one of them is not of the study, or another agent or plant played it; nothing is taken then.
        """
        reader, finished = TrialReader(), source.finished
        calls, attempts = grouped(source.calls, lambda call: call.key), AttemptLog.read(source.directory)
        with read(source.directory) as store:
            rows = map(TrialRow._make, store.rows(f"select {COLUMNS} from trial where current order by id", nulls=True))  # noqa: S608
            own = (row for row in rows if row.key in finished)
            while part := [(trial_in(store, reader, row.key, row.record), row) for row in islice(own, _TOGETHER)]:
                self._check(source, [trial for trial, _ in part])
                for trial, row in part:
                    if self._journal.owes(trial.key):
                        self._write(calls.get(trial.key, ()))
                        self._log.replace(trial.key, attempts.get(trial.key, ()))
                        self._pictures.update(dict.fromkeys(trial.picture_names, source.album))
                        self._journal.append(trial, row.timing)
                        self.taken += 1
                    else:
                        self.there += 1
                        self.different += self._differs(trial, row)

    def take_begun(self, source: MergeSource) -> int:
        """Merge the replies of unfinished trials and count them; a trial begun differently here keeps its own."""
        replies, begun = 0, source.begun
        for key, calls in grouped(source.calls, lambda call: call.key).items():
            if key in begun and self._journal.owes(key) and self._calls[key] <= Counter(calls):
                replies += sum(call.reply is not None for call in self._write(calls))
        return replies

    def take_pictures(self) -> None:
        """Copy the pictures that the taken trials name, and count those that are missing or not what they are called.

        Raises:
            BadFile: If one cannot be read or written.
        """
        for name, album in sorted(self._pictures.items()):
            picture = Picture(kind="rgb", png=read_input(album / name)) if (album / name).is_file() else None
            if picture is not None and picture.name == name:
                Album(self._journal.directory / ALBUM).keep(picture)
            else:
                self.missing += 1

    def _check(self, source: MergeSource, trials: Sequence[Trial]) -> None:
        own = {trial.key for trial in self._joined.own_trials(trials)}
        for trial in trials:
            if trial.key not in own:
                raise BadFile(source.directory, f"{trial.key} is no trial of that study")
            for (who, name), (here, there) in self._facts.differences(trial).items():
                why = f"{who} is not the same there ({name} is {there!r}, {here!r} in {self._journal.directory})"
                raise BadFile(source.directory, f"0 trials taken: {why}; import it into another directory")
            self._facts.note(trial)

    def _write(self, calls: Sequence[Call]) -> list[Call]:
        """Write those calls of one trial that are missing here, and return them."""
        found, left = [], self._calls[calls[0].key].copy() if calls else Counter[Call]()
        for call in calls:
            if left[call]:
                left[call] -= 1
                continue
            self._journal.calls.write(call)
            self._calls[call.key][call] += 1
            found.append(call)
        return found

    def _differs(self, trial: Trial, row: TrialRow) -> bool:
        """Whether a trial is another one here; how often it was replayed says only what its journal held before."""
        (record,) = self._journal.store.one("select record from trial where current and key = ?", row.key)
        return record != row.record and replace(self._journal.read(row.key)[0], replays=0) != replace(trial, replays=0)
