"""Merges trials that were played elsewhere, in other directories, into the directory of a study: whole or not at all.

Only trials of the same study are merged: all settings except the agents must be equal. A finished trial of the
directory stays; an owed or broken trial is replaced. For a trial that is finished nowhere the calls are merged, so that
it resumes from paid replies.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from lockprobe.agents.outside import check_participant
from lockprobe.foundation.errors import BadFile, UserMistake
from lockprobe.foundation.grouping import grouped
from lockprobe.foundation.inputs import read_input
from lockprobe.studies.costs.call_log import read_calls
from lockprobe.studies.file_names import SETTINGS
from lockprobe.studies.records.attempt_log import AttemptLog
from lockprobe.studies.records.directory import read_study
from lockprobe.studies.records.journal import Journal
from lockprobe.studies.records.known_facts import KnownFacts
from lockprobe.studies.records.picture_store import ALBUM, Album
from lockprobe.studies.records.read_records import on_record
from lockprobe.studies.records.store import read
from lockprobe.studies.records.trial_rows import COLUMNS, OnRecord, TrialRow, trial_in
from lockprobe.studies.study import WHO, Study
from lockprobe.trial.model_call import Call
from lockprobe.trial.pictures.picture import Picture
from lockprobe.trial.trial_reader import TrialReader


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
        trials = on_record(store, study)
    AttemptLog.read(directory)
    calls = tuple(read_calls(directory))
    return MergeSource(directory=directory, album=album or directory / ALBUM, study=study, trials=trials, calls=calls)


def gather(
    directory: Path, sources: Sequence[MergeSource], beside: Callable[[Journal], None] = lambda journal: None
) -> Gathered:
    """Merge sources into a directory, which is created if missing: all of them or nothing. Idempotent.

    Args:
        directory: The directory of the study.
        sources: One or more; earlier ones have precedence.
        beside: Called with the journal of the merged directory while it is still open.

    Raises:
        BadFile: If trials belong to another study, two agents have the same name, or there is neither a study nor a
            source to create it from.
        DirectoryBusy: If another process is writing there.
    """
    known = read_study(directory) if (directory / SETTINGS).exists() else None
    studies = [*([known] if known else []), *(source.study for source in sources)]
    names = {spec: name for one in reversed(studies) for spec, name in one.names.items()}
    here = known.agents if known else ()
    agents = tuple(dict.fromkeys((*here, *(agent for source in sources for agent in source.agents))))
    earlier = max((one.earlier for one in studies), key=len)  # of the study that was extended most often
    joined = replace(studies[0], agents=agents or studies[0].agents, names=names, shard=None, earlier=earlier)
    for source in sources:
        for name, values in (joined.differences(source.study, but=WHO) | joined.renamed(source.study)).items():
            there, asked = (repr(one)[:200] for one in values)
            raise BadFile(
                source.directory, f"trials of another study than {directory} ({name} is {there}, not {asked})"
            )
        for one in source.finished.values():
            try:
                if one.player:
                    check_participant(one.player)
            except UserMistake as mistake:
                raise BadFile(source.directory, f"{one.key}: {mistake}") from None
    if known is None and not any(source.finished or source.begun for source in sources):
        raise BadFile(sources[0].directory, f"no trial in it is finished, so {directory} is not made")
    with Journal.open(directory, joined) as journal, journal.store.transaction(sync=True):
        merger = _Merger(journal)
        for source in sources:
            merger.take(source)
        merger.take_pictures()  # before the records that name them are committed
        replies = sum(map(merger.take_begun, sources))
        begun = {key for source in sources for key in (*source.begun, *(source.trials.keys() - source.finished.keys()))}
        unfinished = sum(map(journal.owes, begun))
        beside(journal)
    return Gathered(
        taken=merger.taken,
        there=merger.there,
        different=merger.different,
        unfinished=unfinished,
        replies=replies,
        agents=joined.labels[len(here) :],
        pictures_missing=merger.missing,
    )


class _Merger:
    """Takes what sources have into an open journal, and counts it.

    Refuses different models, prompts, runtimes or renderers under one name, as a resumed run does.

    Attributes:
        taken, there, different, missing: The counts of :class:`Gathered`, the last of pictures.
    """

    def __init__(self, journal: Journal) -> None:
        self.taken = self.there = self.different = self.missing = 0
        self._journal, self._pictures = journal, dict[str, Path]()
        self._facts, self._log = KnownFacts(journal.kinds()), AttemptLog(journal.store)
        self._calls: defaultdict[str, Counter[Call]] = defaultdict(Counter)
        for call in read_calls(journal.directory):
            self._calls[call.key][call] += 1

    def take(self, source: MergeSource) -> None:
        """Merge the finished trials of a source, each with its calls and attempts.

        Raises:
            BadFile: If another agent or plant played one of them; nothing is taken then.
        """
        journal, reader, finished = self._journal, TrialReader(), source.finished
        calls, attempts = grouped(source.calls, lambda call: call.key), AttemptLog.read(source.directory)
        with read(source.directory) as store:
            select = f"select {COLUMNS} from trial where current order by id"  # noqa: S608 - our own columns
            for row in map(TrialRow._make, store.rows(select, nulls=True)):
                if row.key not in finished:
                    continue
                trial = trial_in(store, reader, row.key, row.record)
                for (who, name), (here, there) in self._facts.differences(trial).items():
                    why = f"{who} is not the same there ({name} is {there!r}, {here!r} in {journal.directory})"
                    raise BadFile(source.directory, f"0 trials taken: {why}; import it into another directory")
                self._facts.note(trial)
                if journal.owes(trial.key):
                    self._write(calls.get(trial.key, ()))
                    self._log.replace(trial.key, attempts.get(trial.key, ()))
                    self._pictures.update(dict.fromkeys(trial.picture_names, source.album))
                    journal.append(trial, row.timing)
                    self.taken += 1
                    continue
                self.there += 1
                (record,) = journal.store.one("select record from trial where current and key = ?", row.key)
                if record != row.record:  # how often it was replayed says only what its journal held before
                    self.different += replace(journal.read(row.key)[0], replays=0) != replace(trial, replays=0)

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
