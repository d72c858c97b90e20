"""``lockprobe serve`` and ``withdraw``: people take part in a study, on a page in their browser; one takes all back."""

from __future__ import annotations

import asyncio
import json as json_
import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import ceil
from pathlib import Path
from typing import Annotated, Any

import typer

from lockprobe.cli import options
from lockprobe.cli.study_options import with_study_options
from lockprobe.foundation import plugins
from lockprobe.foundation.errors import BadFile, BadValue, Conflict, needing
from lockprobe.foundation.formatting import count
from lockprobe.foundation.inputs import read_input
from lockprobe.foundation.spec import PEOPLE
from lockprobe.foundation.storage.atomic_file import write_file
from lockprobe.foundation.validation import validated
from lockprobe.people.assignment import boxes_each, conditions_of, places_in, trials_for
from lockprobe.people.diary import read_diaries
from lockprobe.people.experiment import (
    LANGUAGES,
    Experiment,
    kept_experiment,
    read_experiment,
    read_words,
    words_file,
)
from lockprobe.people.server_state import CODE, PREVIEW
from lockprobe.people.withdrawal import delete_unnamed_pictures
from lockprobe.people.withdrawal import withdraw as delete_all
from lockprobe.studies.options.study_options import STUDIES, read_options
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.records.directory import read_study
from lockprobe.studies.records.journal import Journal
from lockprobe.studies.study import Study

EXAMPLES = {language: Path(__file__).with_name(f"people.{language}.toml") for language in LANGUAGES}
"""An example of people's settings in each shipped language, as a file to edit."""

PLACEHOLDERS = {
    **{name: "{{%" + name + "%}}" for name in ("PROLIFIC_PID", "STUDY_ID", "SESSION_ID")},
    "survey_code": "%SURVEY_CODE%",
    "workerId": "${workerId}",
    "assignmentId": "${assignmentId}",
    "hitId": "${hitId}",
}
"""The placeholders of recruitment platforms, by parameter: Prolific, SONA, MTurk."""

_STUDY = "The study: a name, a file, or the directory of a study that people join."
_PEOPLE = (
    "A study of people (a file of settings, of which --write-people writes an example; their number, which sets the "
    "trials; or both)."
)
_TEXTS = "The texts of the page: a shipped language, or a file (--write-texts writes an example)."
_PUBLIC = "The public origin of a proxy, for example https://study.example.org."
_UNNAMED = (
    "Note          The shipped consent text names nobody as responsible and does not say how long the study takes. "
    "Edit a copy (lockprobe serve --write-texts mine.toml) and use --texts mine.toml."
)
_OPEN = "Note          Anyone with the link can join. --join-code CODE, or require_id in people.toml, keeps others out."
_ALLOWED = "A name of this machine on a local network; may be repeated."

_CODE = "A code without which no address admits."
_WRITE_TEXTS = "Write a file of texts to edit, and exit."
_WRITE_PEOPLE = "Write a file of settings for people to edit, and exit."


@options.under_headings({"The address": "host port public_url allow_host", "Files to edit": "write_people write_texts"})
@with_study_options(without=("agent", "until", "boxes"))
def serve(
    asked: Mapping[str, object],
    what: Annotated[str | None, typer.Argument(metavar="flips|modalities|why|looks|FILE.toml|DIR", help=_STUDY)] = None,
    people: Annotated[list[str] | None, typer.Option(metavar="FILE.toml|N", help=_PEOPLE)] = None,
    texts: Annotated[str | None, typer.Option(metavar="NAME|FILE.toml", help=_TEXTS)] = None,
    join_code: Annotated[str | None, typer.Option(metavar="CODE", help=_CODE)] = None,
    out: options.Out = None,
    allow: options.Allow = None,
    host: Annotated[str, typer.Option(help="Host name or IP address.")] = "127.0.0.1",
    port: Annotated[int, typer.Option(min=0, max=65535, help="The port; 0 for any free one.")] = 8765,
    public_url: Annotated[str, typer.Option(metavar="ORIGIN", help=_PUBLIC)] = "",
    allow_host: Annotated[list[str] | None, typer.Option(metavar="NAME", help=_ALLOWED)] = None,
    write_texts: Annotated[Path | None, typer.Option(metavar="FILE.toml", help=_WRITE_TEXTS)] = None,
    write_people: Annotated[Path | None, typer.Option(metavar="FILE.toml", help=_WRITE_PEOPLE)] = None,
    json: options.AsJson = False,
) -> None:
    """Let people take part in a study, on a page in their browser. The same command resumes the study.

    Together they play the trials of the agent participant, each trial once; lockprobe run, report and export treat
    these like any other agent's. Ctrl-C stops the server; no progress is lost. --json prints url, study_url,
    preview_url and directory.
    """
    if write_texts or write_people:
        _write_examples(texts or Experiment().language, write_texts, write_people)
        return
    plugins.allow(*(allow or ()))
    if not what:
        raise BadValue("study", what, f"one of {', '.join(STUDIES)}, FILE.toml, or the directory of a study")
    own = {"language": texts, "join_code": join_code}
    planned, directory, experiment = study_and_people(what, asked, people or (), own, out)
    if planned.attended:
        raise BadValue("plant", planned.plant, "a plant that asks nothing at the terminal: several people play at once")
    with needing("pages for people", "web"):
        from lockprobe.people.web.address import Address
        from lockprobe.people.web.app import opened, stop_signals
    words = read_words(experiment.language)

    def announce(where: Any, state: Any) -> None:
        """Say that people can join, and the address to paste into a recruitment platform, with its placeholders."""
        parts = [f"{name}={PLACEHOLDERS.get(name, '…')}" for name in experiment.recruitment]
        parts += [f"{CODE}={experiment.join_code}"] if experiment.join_code else []
        preview, address = f"{where.url}?{PREVIEW}={state.preview}", where.url + "?" * bool(parts) + "&".join(parts)
        if json:
            said = {"url": where.url, "study_url": address, "preview_url": preview, "directory": str(directory)}
            print(json_.dumps(said), flush=True)
            return
        places, each = places_in(planned, experiment), boxes_each(planned, experiment)
        persons, boxes = count(min(experiment.participants or places, places), "person"), count(each, "box", "boxes")
        print(
            f"{planned.name} on {planned.boxes_in_words} for people, {planned.invited} trials: {persons}, {boxes} each"
        )
        print(f"Participants  {where.url}")
        print(f"To paste      {address}  (placeholders of the recruitment platform)")
        print(f"Preview       {preview}  (nothing is kept, and no place taken)")
        print(f"Kept in       {directory}")
        sizes = f"--trials {planned.trials // len(planned.boxes)} --repetitions {planned.repetitions} --out {directory}"
        also = f"lockprobe run {planned.name} … --agent {PEOPLE} --agent human-inspired {sizes}"
        print(f"Strategies    {also}  (with the server stopped; … are your other options)")
        if any(words.consent == read_words(language).consent for language in LANGUAGES):
            print(_UNNAMED)
        if not (experiment.join_code or experiment.require_id):
            print(_OPEN)
        print(f"Ctrl-C stops; the same command resumes. Hash of the settings: {planned.settings_hash}", flush=True)

    door = Address(host=host, port=port, public=public_url.rstrip("/"), allowed=tuple(allow_host or ()))

    async def until_stopped() -> None:
        async with opened(directory, planned, experiment, words, door) as (where, state):
            with stop_signals() as stopped:
                announce(where, state)
                await stopped.wait()

    asyncio.run(until_stopped())
    if not json:
        print("Stopped. The same command resumes; everybody continues where they were.")


def study_and_people(
    name: str, asked: Mapping[str, object], people: Sequence[str], own: Mapping[str, object], out: Path | None
) -> tuple[Study, Path, Experiment]:
    """The study, people among its agents, its directory, and the settings for people: as given, or as stored there.

    ``people`` are a file of settings, a number of people, or both; a number sets that of trials. ``own`` are settings
    that count before those of the file, where they are not None.
    """
    files, numbers = [[one for one in people if one.isdecimal() == decimal] for decimal in (False, True)]
    if len(files) > 1 or len(numbers) > 1:
        raise BadValue("people", " ".join(people), "one file, one number, or one of each")
    given = {name: value for name, value in own.items() if value is not None}
    given |= {"participants": numbers[0]} if numbers else {}

    def experiment(kept_in: Path | None) -> Experiment:
        kept = read_experiment(Path(files[0])) if files else (kept_in and kept_experiment(kept_in)) or Experiment()
        return validated(Experiment, {**kept.model_dump(), **given})

    if Path(name).is_dir() and name not in STUDIES:
        if asked or out is not None:
            said = ", ".join("--" + key.replace("_", "-") for key in (*asked, *(["out"] if out else [])))
            raise Conflict(said, f"the directory {name}", "its study already has its settings")
        there, out, numbers = read_study(Path(name)), Path(name), []
        planned = replace(there, agents=there.joined([PEOPLE]))
    else:
        request = read_options(name, asked)
        planned = study(request, agent=list(dict.fromkeys((*(request.agent or ()), PEOPLE))))
    if numbers and "trials" not in asked:
        repetitions, settings = planned.repetitions if "repetitions" in asked else 1, experiment(out)
        assert settings.participants is not None
        luck = trials_for(settings.participants, len(conditions_of(planned)), repetitions, settings)
        more = planned.strategy_trials if "strategy_trials" in asked else None
        trials = ceil(luck / len(planned.boxes)) * len(planned.boxes)
        planned = replace(planned, repetitions=repetitions, trials=trials, strategy_trials=more)
    directory = out or Path("lockprobe-runs") / f"{planned.name}-{planned.identity}"
    found = experiment(directory)
    if (asked_for := found.participants) and asked_for > (places := places_in(planned, found)):
        has = f"whom {planned.invited} trials are enough for, {boxes_each(planned, found)} for each"
        has += f"; --people {asked_for} without --trials adds more" * (out != Path(name))
        raise BadValue("participants", asked_for, f"at most {places}, {has}")
    return planned, directory, found


def _write_examples(language: str, texts: Path | None, people: Path | None) -> None:
    """Write a language's texts, and its example of settings, to where an experimenter edits them."""
    example = EXAMPLES.get(language, EXAMPLES[Experiment().language])
    for target, source, option in ((texts, words_file(language), "texts"), (people, example, "people")):
        if target is None:
            continue
        if os.path.lexists(target):
            raise BadFile(target, "already exists, and is not overwritten")
        write_file(target, read_input(source))
        print(f"Written: {target}. Edit it, then use it: lockprobe serve STUDY --{option} {target}")


def withdraw(
    directory: options.Directory,
    participant: Annotated[
        str, typer.Argument(metavar="PARTICIPANT", help="The participant: the ID in the study, or a platform's ID.")
    ],
) -> None:
    """Delete all data of a participant: diary, records, times and pictures.

    The number of withdrawals stays, and a keyed digest of a platform's ID, with which nobody can begin again.

    No server may be running on the directory. Reports and exports written before have to be written again.
    """
    study, joined = read_study(directory), [diary.joined for diary in read_diaries(directory)]
    found = [one for one in joined if participant in (one.identity, *one.platform.values())]
    if len(found) != 1:
        raise BadValue("participant", participant, f"the ID of one participant ({len(found)} people have this one)")
    names = (kept_experiment(directory) or Experiment()).recruitment
    with Journal.open(directory, study) as journal:
        delete_all(journal, found[0].identity, found[0].platform.get(next(iter(names), ""), ""))
        delete_unnamed_pictures(journal)
    print(f"Withdrawn. Reports and exports of {directory} written before still count this person: write them again.")
