"""Merges trials that were played elsewhere, in other directories, into the directory of a study: whole or not at all.

Only trials of the same study are merged: all settings except the agents must be equal. A finished trial of the
directory stays; an owed or broken trial is replaced. For a trial that is finished nowhere the calls are merged, so that
it resumes from paid replies.
"""

from __future__ import annotations

import json
from collections import Counter, deque
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from lockprobe.agents.outside import check_outside
from lockprobe.foundation.errors import BadFile, UserMistake
from lockprobe.foundation.grouping import grouped
from lockprobe.foundation.inputs import read_input
from lockprobe.foundation.spec import PEOPLE
from lockprobe.foundation.storage.database import Database
from lockprobe.studies.costs.call_log import read_calls
from lockprobe.studies.file_names import SETTINGS
from lockprobe.studies.records.attempt_log import AttemptLog
from lockprobe.studies.records.directory import read_study
from lockprobe.studies.records.journal import Journal
from lockprobe.studies.records.known_facts import KnownFacts
from lockprobe.studies.records.picture_store import ALBUM, Album
from lockprobe.studies.records.read_records import on_record
from lockprobe.studies.records.store import checksum, read
from lockprobe.studies.records.trial_rows import COLUMNS, OnRecord, TrialRow, trial_in, trials_in
from lockprobe.studies.study import WHO, Study
from lockprobe.trial.pictures.picture import Picture
from lockprobe.trial.trial_json import TrialReader


@dataclass(frozen=True, slots=True, kw_only=True)
class MergeSource:
    """The directory of a study whose trials are merged; every record in it can be read.

    Attributes:
        directory: Its settings and its store.
        album: The directory of its pictures.
        study: The study.
        finished: The trials that are not owed, by key.
        owed: The keys of those that broke.
        begun: Key of a planned trial that has calls and is not finished -> its agent.
    """

    directory: Path
    album: Path
    study: Study
    finished: Mapping[str, OnRecord]
    owed: Collection[str]
    begun: Mapping[str, str]

    @property
    def agents(self) -> tuple[str, ...]:
        """The agents with finished trials or calls, in the order of the study."""
        playing = {one.spec for one in self.finished.values()} | {*self.begun.values()}
        return tuple(agent for agent in self.study.agents if agent in playing)


@dataclass(slots=True, kw_only=True)
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

    taken: int = 0
    there: int = 0
    different: int = 0
    unfinished: int = 0
    replies: int = 0
    agents: tuple[str, ...] = ()
    pictures_missing: int = 0


def source_of_directory(directory: Path, album: Path | None = None) -> MergeSource:
    """The directory of a study as a source; its pictures may lie elsewhere.

    Raises:
        BadFile: If it is not the directory of a study, or something in it is damaged.
    """
    study = read_study(directory)
    with read(directory) as store:
        deque(trials_in(store, "true"), maxlen=0)
        trials = on_record(store, study)
        AttemptLog(store)
    finished = {key: one for key, one in trials.items() if not one.owed_again}
    for key, one in finished.items():
        try:
            if one.player:
                check_outside(one.player, PEOPLE)
        except UserMistake as mistake:
            raise BadFile(directory, f"{key}: {mistake}") from None
    asked = {call.key for call in read_calls(directory)} - finished.keys()
    plans = (plan for agent in study.agents for plan in study.plans(agent)) if asked else ()
    return MergeSource(
        directory=directory,
        album=album or directory / ALBUM,
        study=study,
        finished=finished,
        owed=trials.keys() - finished.keys(),
        begun={plan.key: plan.agent for plan in plans if plan.key in asked},
    )


def gather(
    directory: Path, sources: Sequence[MergeSource], beside: Callable[[Journal], None] = lambda journal: None
) -> Gathered:
    """Merge sources into a directory, which is created if missing: all of them or nothing. Idempotent.

    Args:
        directory: The directory of the study.
        sources: One or more; earlier ones have precedence.
        beside: Called with the journal of the merged directory while it is still open.

    Raises:
        BadFile: If trials belong to another study, two agents have the same name, another agent or plant played one of
            them, or there is neither a study nor a source to create it from.
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
            why = f"trials of another study than {directory} ({name} is {there}, not {asked})"
            raise BadFile(source.directory, why)
    if known is None and not any(source.finished or source.begun for source in sources):
        raise BadFile(sources[0].directory, f"no trial in it is finished, so {directory} is not made")
    found, pictures = Gathered(agents=joined.labels[len(here) :]), dict[str, Path]()
    with Journal.open(directory, joined) as journal, journal.store.transaction(sync=True):
        facts = KnownFacts(journal.kinds())
        for source in sources:
            pictures |= _take(journal, source, facts, found)
        found.pictures_missing = _copy_pictures(pictures, directory / ALBUM)  # before what names them is committed
        for source in sources:
            with read(source.directory) as store:
                calls, own = _calls(store), _calls(journal.store)
            for key in source.begun:
                if journal.owes(key) and Counter(own.get(key, ())) <= Counter(calls[key]):  # else it began otherwise
                    missing = _copy_calls(journal, key, calls[key], own.get(key, ()))
                    found.replies += sum(json.loads(one).get("reply") is not None for one in missing)
        found.unfinished = sum(map(journal.owes, {key for one in sources for key in (*one.begun, *one.owed)}))
        beside(journal)
    return found


def _take(journal: Journal, source: MergeSource, facts: KnownFacts, found: Gathered) -> dict[str, Path]:
    """Take the finished trials of a source, each with its calls and attempts; return pictures that they name.

    Different models, prompts, runtimes or renderers under one name are refused, as by a resumed run.
    """
    reader, pictures, own, log = TrialReader(), dict[str, Path](), _calls(journal.store), AttemptLog(journal.store)
    with read(source.directory) as store:
        calls = _calls(store)
        attempts = AttemptLog(store).entries
        select = f"select {COLUMNS} from trial where current and not owed order by id"  # noqa: S608 - our own columns
        for row in map(TrialRow._make, store.rows(select, nulls=True)):
            trial = trial_in(store, reader, row.key, row.record)
            for (who, name), (here, there) in facts.note(trial).items():
                why = f"{who} is not the same there ({name} is {there!r}, {here!r} in {journal.directory})"
                raise BadFile(source.directory, f"0 trials taken: {why}; import it into another directory")
            if journal.owes(row.key):
                _copy_calls(journal, row.key, calls.get(row.key, ()), own.get(row.key, ()))
                log.replace(row.key, attempts.get(row.key, ()))
                pictures.update(dict.fromkeys(trial.picture_names, source.album))
                journal.append(trial, row.timing)
                found.taken += 1
                continue
            found.there += 1
            (record,) = journal.store.one("select record from trial where current and key = ?", row.key)
            if record != row.record:  # how often it was replayed says only what its journal held before
                found.different += replace(journal.read(row.key)[0], replays=0) != replace(trial, replays=0)
    return pictures


def _calls(store: Database) -> dict[str, list[str]]:
    """The outcomes of the calls of each trial."""
    rows = store.rows("select key, answer from call where answer is not null order by id")
    return {key: [answer for _, answer in own] for key, own in grouped(rows, lambda row: row[0]).items()}


def _copy_calls(journal: Journal, key: str, calls: Sequence[str], own: Sequence[str]) -> list[str]:
    """Copy those calls of a trial that are missing here, and return them."""
    left, missing = Counter(own), list[str]()
    for call in calls:
        if left[call]:
            left[call] -= 1
        else:
            missing.append(call)
    with journal.store.transaction() as writing:
        rows = [(key, call, checksum(key, None, call)) for call in missing]
        writing.executemany("insert into call (key, answer, crc) values (?, ?, ?)", rows)
    return missing


def _copy_pictures(pictures: Mapping[str, Path], into: Path) -> int:
    """Copy pictures from their albums, and count those that are missing or not what they are called."""
    missing = 0
    for name, album in sorted(pictures.items()):
        picture = Picture(kind="rgb", png=read_input(album / name)) if (album / name).is_file() else None
        if picture is not None and picture.name == name:
            Album(into).keep(picture)
        else:
            missing += 1
    return missing
