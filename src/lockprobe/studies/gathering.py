"""Trials that were played elsewhere are taken into the directory of a study: those of logs, and of other directories.

Only trials of the same study are taken: all settings are equal but for who plays. A trial that the directory has
finished is left alone; one that it owes, or that broke there, is taken.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from lockprobe.call import Call
from lockprobe.errors import BadFile, BadValue, UserMistake
from lockprobe.pictures.picture import Picture
from lockprobe.record import Fact, Trial
from lockprobe.studies.album import ALBUM, Album
from lockprobe.studies.calls import read_calls
from lockprobe.studies.journal import Journal, Timing, load, read_timings
from lockprobe.studies.settings import read_study
from lockprobe.studies.study import Study

__all__ = ["Gathered", "Source", "gather", "source_of_directory"]

_PLANT_FACTS = ("engine", "renderer")


@dataclass(frozen=True, slots=True, kw_only=True)
class Source:
    """Trials that were played elsewhere.

    Attributes:
        path: Where they were found, for messages.
        study: The study that they are of.
        trials: The trials.
        unfinished: Keys of trials that were begun there and have no record.
        seconds: How long each took, by key, as far as it is known.
        calls: What was asked of a provider there.
        picture: From a picture's name to its file; None where it is not there.
    """

    path: Path
    study: Study
    trials: tuple[Trial, ...]
    unfinished: frozenset[str] = frozenset()
    seconds: Mapping[str, float] = field(default_factory=dict)
    calls: tuple[Call, ...] = ()
    picture: Callable[[str], bytes | None] = lambda name: None


@dataclass(frozen=True, slots=True, kw_only=True)
class Gathered:
    """What came of it.

    Attributes:
        taken: Trials that the directory did not have.
        there: Trials that it had finished already.
        unfinished: Trials that were begun there and finished nowhere; they are owed.
        agents: Agents that were new to the study.
        pictures_missing: Pictures that the trials taken name and that were not found.
    """

    taken: int
    there: int
    unfinished: int
    agents: tuple[str, ...]
    pictures_missing: int


def source_of_directory(directory: Path) -> Source:
    """The trials in the directory of a study.

    Raises:
        BadFile: If it is none, or something in it is damaged.
    """

    def picture(name: str) -> bytes | None:
        file = directory / ALBUM / name
        return file.read_bytes() if file.is_file() else None

    return Source(
        path=directory,
        study=read_study(directory),
        trials=tuple(load(directory)),
        seconds={timing.key: timing.seconds for timing in read_timings(directory)},
        calls=tuple(read_calls(directory)),
        picture=picture,
    )


def gather(directory: Path, sources: Sequence[Source]) -> Gathered:
    """Take into a directory the trials that it does not have. It is made if it does not exist.

    Args:
        directory: Of the study.
        sources: Where trials are; the first sources go before later ones.

    Raises:
        BadValue: If there is no source.
        BadFile: If trials are of another study, or an agent is not the same under the same name.
        DirectoryBusy: If another process is writing there.
    """
    if not sources:
        raise BadValue("sources", 0, "at least one")
    known = read_study(directory) if (directory / "study.json").exists() else None
    finished = [replace(source, trials=tuple(t for t in source.trials if not t.owed_again)) for source in sources]
    first = known or replace(sources[0].study, agents=_agents(finished) or sources[0].study.agents)
    joined = replace(first, agents=tuple(dict.fromkeys((*first.agents, *_agents(finished)))))
    for source in finished:
        _refuse_another_study(source, joined, directory)
    with Journal.open(directory, first) as journal:
        same = _Same(directory, journal.trials.values())
        for source in finished:
            same.check(source)
        if joined.agents != first.agents:
            _write_settings(directory, joined)
        counts = [_take(source, journal) for source in finished]
        broken = {key for source in sources for key in source.unfinished}
        broken |= {trial.key for source in sources for trial in source.trials if trial.owed_again}
        unfinished = sum(map(journal.owes, broken))
    taken, there, missing = (sum(column) for column in zip(*counts, strict=True))
    return Gathered(
        taken=taken,
        there=there,
        unfinished=unfinished,
        agents=joined.agents if known is None else joined.agents[len(first.agents) :],
        pictures_missing=missing,
    )


def _agents(sources: Iterable[Source]) -> tuple[str, ...]:
    """Who played, each once, in the order of its study."""
    found: list[str] = []
    for source in sources:
        playing = {trial.agent for trial in source.trials}
        found += [agent for agent in source.study.agents if agent in playing]
    return tuple(dict.fromkeys(found))


def _refuse_another_study(source: Source, joined: Study, directory: Path) -> None:
    theirs, ours = ({**study.settings(), "agents": []} for study in (source.study, joined))
    for name in sorted({*theirs, *ours}):
        if theirs.get(name) != ours.get(name):
            there, here = _short(theirs.get(name)), _short(ours.get(name))
            raise BadFile(source.path, f"trials of another study than {directory} ({name} is {there}, not {here})")
    for trial in source.trials:
        try:
            asked = joined.asks_for(trial)
        except UserMistake as mistake:
            raise BadFile(source.path, f"{trial.key}: {mistake}") from None
        if not asked:
            raise BadFile(source.path, f"{trial.key} is no trial of its own study")


def _short(value: object) -> str:
    if isinstance(value, dict):
        value = value.get("name", value)
    return json.dumps(value)[:60]


class _Same:
    """Refuses two models, prompts, runtimes or renderers under one name, as a run does that is resumed."""

    def __init__(self, directory: Path, trials: Iterable[Trial]) -> None:
        self._directory = directory
        self._known: dict[tuple[str, str], Fact] = {}
        for trial in trials:
            self._known |= self._facts(trial)

    def _facts(self, trial: Trial) -> dict[tuple[str, str], Fact]:
        facts = {(trial.agent, name): value for name, value in trial.facts.items()}
        return facts | {("the plant", name): trial.plant[name] for name in _PLANT_FACTS if name in trial.plant}

    def check(self, source: Source) -> None:
        for trial in source.trials:
            for (what, name), value in self._facts(trial).items():
                here = self._known.setdefault((what, name), value)
                if here is not None and value is not None and here != value:
                    why = f"{what} is not the same there ({name} is {value!r}, {here!r} in {self._directory})"
                    raise BadFile(source.path, why)


def _write_settings(directory: Path, study: Study) -> None:
    """The settings with agents that are new, on disk before the first of their trials."""
    path = directory / "study.json"
    draft = path.with_suffix(".draft")
    draft.write_text(json.dumps(study.settings(), indent=2) + "\n", "utf-8")
    draft.replace(path)


def _take(source: Source, journal: Journal) -> tuple[int, int, int]:
    """Trials taken, trials there, and pictures missing."""
    album, missing = Album(journal.directory / ALBUM), 0
    owed = [trial for trial in source.trials if journal.owes(trial.key)]
    keys = {trial.key for trial in owed}
    for call in source.calls:
        if call.key in keys:
            journal.calls.write(call)
    for trial in owed:
        for name in sorted(trial.picture_names):
            png = source.picture(name)
            picture = None if png is None else Picture(kind="rgb", png=png)
            if picture is None or picture.name != name:
                missing += 1
            else:
                album.keep(picture)
        journal.append(trial, Timing(key=trial.key, seconds=source.seconds.get(trial.key, 0.0), steps=len(trial.steps)))
    return len(owed), len(source.trials) - len(owed), missing
