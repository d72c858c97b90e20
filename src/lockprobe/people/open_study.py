"""Opening a study for people: its directory, its settings, and what all participants share.

A start that fails before people are invited leaves the directory as it was: it deletes the files that it made and
restores settings and texts. Diaries and notes of withdrawals always stay, and so does everything once a participant
has joined.
"""

from __future__ import annotations

import asyncio
import json
from collections.abc import AsyncIterator, Callable, Iterator
from contextlib import asynccontextmanager, contextmanager, nullcontext, suppress
from dataclasses import dataclass, replace
from pathlib import Path

from lockprobe.foundation.errors import BadFile, BadValue, SettingsChanged
from lockprobe.foundation.inputs import read_input
from lockprobe.foundation.spec import PEOPLE, spec_name
from lockprobe.foundation.storage.atomic_file import remove_file, write_private
from lockprobe.people.assignment import boxes_each
from lockprobe.people.diary import make_private, read_diaries
from lockprobe.people.experiment import EXPERIMENT, SECRET, Experiment, kept_experiment
from lockprobe.people.journey import fingerprint
from lockprobe.people.practice import examples_of, practice_plan
from lockprobe.people.text_scenes import TextScenes
from lockprobe.people.texts import LANGUAGES, TEXTS, Words, read_words, words_file
from lockprobe.people.tokens import TOKENS
from lockprobe.people.withdrawal import delete_unnamed_pictures, withdrawn
from lockprobe.plants.catalogue import resolve_plant
from lockprobe.studies.file_names import PEOPLE_DIRECTORY, SETTINGS
from lockprobe.studies.records.directory import read_study, write_settings
from lockprobe.studies.records.journal import Journal
from lockprobe.studies.records.store import has_joined
from lockprobe.studies.running.playable import PERSON, check_playable
from lockprobe.studies.running.trial_setup import own_thread
from lockprobe.studies.study import Study
from lockprobe.trial.loop import Executor, here

LOG = "server.log"
"""The log of refused requests, next to the diaries."""

_SETTINGS = (EXPERIMENT, TEXTS)
"""Files that every start rewrites."""

_MADE = (*_SETTINGS, TOKENS, LOG)
"""Files that a start creates."""

_ENGLISH = frozenset({"nudge", "remark", "distract", "warn", "correction"})
"""Interventions whose words reach the page as they are."""

_MAY_CHANGE = {"participants", "away_minutes", "language", "require_id", *SECRET}
"""Settings that change nothing of what a participant sees in a box. Texts count by content, not by language."""


@dataclass(frozen=True, slots=True, kw_only=True)
class OpenStudy:
    """What all participants of a study share.

    Attributes:
        study: The study, with people among its agents.
        experiment: How people take part.
        words: The texts that participants read.
        texts: The scenes made of these texts.
        journal: Records finished trials.
        invited: Set when people are invited; a later failure leaves the directory as it is.
        place: Where plants run.
        clock: Seconds since 1970.
        page: Version of the page.
    """

    study: Study
    experiment: Experiment
    words: Words
    texts: TextScenes
    journal: Journal
    invited: asyncio.Event
    place: Executor
    clock: Callable[[], float]
    page: str


def words_to_read(directory: Path, experiment: Experiment) -> Words:
    """The texts that people read here. Once a participant has joined, the copy in the directory counts.

    Raises:
        UnknownName: If the language does not exist.
        BadFile: If a file is damaged or holds no texts.
    """
    copy = directory / PEOPLE_DIRECTORY / TEXTS
    held = (
        experiment.language in LANGUAGES
        and copy.is_file()
        and any(diary.joined.token for diary in read_diaries(directory))
    )
    return read_words(str(copy) if held else experiment.language)


@asynccontextmanager
async def open_study(
    directory: Path, study: Study, experiment: Experiment, words: Words, *, clock: Callable[[], float], page: str
) -> AsyncIterator[OpenStudy]:
    """Open a study for people in its directory, and close it afterwards.

    Raises:
        SettingsChanged: If the directory holds another study, or people have joined under other settings.
        DirectoryBusy: If another process is writing there.
        BadFile: If a file in it is damaged.
        UserMistake: If the plant is not available, there is no such practice box, or people cannot play a condition.
    """
    there = read_study(directory) if (directory / SETTINGS).exists() else study
    known = there.agents
    study = replace(study, agents=tuple(dict.fromkeys((*known, PEOPLE))), names=there.names)
    study = study.ordered_as(there)  # people play the conditions in an order that is drawn from this one
    study.check_agents()
    check_playable(study.conditions, PERSON)
    _check(study, experiment)
    _check_language(study, words)
    practice = practice_plan(study, experiment)
    for plant in map(resolve_plant, dict.fromkeys((*study.plants, study.plant))):
        for box in (*study.boxes, *([practice.box] if practice else [])):
            plant.check(box)
    with (
        Journal.open(directory, replace(study, agents=known)) as journal,
        own_thread() if study.simulated else nullcontext(here) as place,
    ):
        write_settings(directory, study)
        with _undone_if_it_fails(directory) as invited:
            _settle(directory, experiment, words)
            yield OpenStudy(
                study=study,
                experiment=experiment,
                words=words,
                texts=TextScenes(words, study, experiment, await examples_of(study, words.page, place)),
                journal=journal,
                invited=invited,
                place=place,
                clock=clock,
                page=page,
            )
        if withdrawn(directory):
            delete_unnamed_pictures(journal)


@contextmanager
def _undone_if_it_fails(directory: Path) -> Iterator[asyncio.Event]:
    """Restore the directory of people if opening fails before the invitation and before anybody joins.

    Raises:
        BadFile: If existing settings cannot be read.
    """
    people, invited = directory / PEOPLE_DIRECTORY, asyncio.Event()
    new, joined, mode = not people.exists(), has_joined(directory), directory.stat().st_mode
    before = {path: read_input(path) if path.is_file() else None for path in (people / name for name in _MADE)}
    failed = True
    try:
        make_private(directory)
        yield invited
        failed = False
    except KeyboardInterrupt:
        failed = False
        raise
    finally:
        if failed and not (invited.is_set() or has_joined(directory) > joined):
            with suppress(OSError, BadFile):
                directory.chmod(mode)
                for path, content in before.items():
                    if content is None and path.is_file():
                        remove_file(path)
                    elif content is not None and path.name in _SETTINGS and path.read_bytes() != content:
                        write_private(path, content)
                if new:
                    people.rmdir()


def _check(study: Study, experiment: Experiment) -> None:
    """Refuse settings that do not fit the study."""
    luck, boxes = study.repetitions * study.trials, boxes_each(study, experiment)
    if (experiment.trials_each or 1) > luck:
        raise BadValue("trials_each", experiment.trials_each, f"at most {luck}, the trials of a condition")
    for check in experiment.checks:
        if check.after > boxes:
            raise BadValue("checks, after", check.after, f"at most {boxes}, the boxes of a participant")


def _check_language(study: Study, words: Words) -> None:
    """Refuse interventions that ship with English sentences on a page in another language."""
    if words.language.partition("-")[0].lower() == "en":
        return
    for condition in study.conditions_of(PEOPLE):
        for spec in condition.specs:
            if spec_name(spec) in _ENGLISH:
                raise BadValue("texts", words.language, f"English ones with {spec}, whose words are English")


def _settle(directory: Path, experiment: Experiment, words: Words) -> None:
    """Write settings and texts; refuse them if people have joined under other ones.

    Imported participants may have read other texts, since they do not resume here.
    """
    path = directory / PEOPLE_DIRECTORY / EXPERIMENT
    asked, known = experiment.model_dump(mode="json"), kept_experiment(directory)
    diaries = read_diaries(directory)
    read = {diary.joined.words for diary in diaries if diary.joined.token}
    different: dict[str, tuple[object, object]] = {}
    if read - {fingerprint(words)}:
        different["texts"] = (", ".join(sorted(read)), fingerprint(words))
    if known is not None and diaries:
        there = known.model_dump(mode="json")
        changed = (name for name in asked if name not in _MAY_CHANGE and there[name] != asked[name])
        different |= {name: (there[name], asked[name]) for name in changed}
    if different:
        raise SettingsChanged(path.parent, different)
    write_private(path, f"{json.dumps(asked, indent=2)}\n")
    if not diaries and (texts := words_file(experiment.language)).is_file():
        write_private(directory / PEOPLE_DIRECTORY / TEXTS, read_input(texts))
