"""``lockprobe serve``: people take part in a study, on a page in their browser."""

from __future__ import annotations

import asyncio
import json as jsonlib
import os
from collections.abc import Iterator, Mapping
from dataclasses import replace
from importlib.util import find_spec
from math import ceil
from pathlib import Path
from typing import Annotated, Any

import typer

from lockprobe.cli import options
from lockprobe.cli.command import under_headings
from lockprobe.cli.study_options import with_study_options
from lockprobe.foundation.errors import BadFile, BadValue, Conflict, Missing
from lockprobe.foundation.inputs import read_input
from lockprobe.foundation.spec import PEOPLE
from lockprobe.foundation.storage.atomic_file import write_file
from lockprobe.interventions.conditions import flips
from lockprobe.people.assignment import boxes_each, conditions_of, trials_for
from lockprobe.people.experiment import (
    LANGUAGES,
    Experiment,
    Words,
    checked,
    kept_experiment,
    read_experiment,
    read_words,
    words_file,
)
from lockprobe.people.server_state import CODE, PREVIEW
from lockprobe.studies.options.study_options import STUDIES, read_options
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.records.directory import read_study
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
_ALLOWED = "A name of this machine on a local network; may be repeated."

Name = Annotated[str | None, typer.Argument(metavar="flips|modalities|why|FILE.toml|DIR", help=_STUDY)]
People = Annotated[list[str] | None, typer.Option(metavar="FILE.toml|N", help=_PEOPLE)]
JoinCode = Annotated[str | None, typer.Option(metavar="CODE", help="A code without which no address admits.")]
Texts = Annotated[str | None, typer.Option(metavar="NAME|FILE.toml", help=_TEXTS)]
Host = Annotated[str, typer.Option(help=options.HOST)]
Public = Annotated[str, typer.Option(metavar="ORIGIN", help=_PUBLIC)]
Allowed = Annotated[list[str] | None, typer.Option("--allow-host", metavar="NAME", help=_ALLOWED)]
WriteTexts = Annotated[Path | None, typer.Option(metavar="FILE.toml", help="Write a file of texts to edit, and exit.")]
WritePeople = Annotated[
    Path | None, typer.Option(metavar="FILE.toml", help="Write a file of settings for people to edit, and exit.")
]


@under_headings(
    {
        "The address": "host port public_url allow_host",
        "Files to edit": "write_people write_texts",
    }
)
@with_study_options(without=("agent", "until", "most", "boxes"))
def serve(
    asked: Mapping[str, object],
    what: Name = None,
    people: People = None,
    texts: Texts = None,
    join_code: JoinCode = None,
    out: options.Out = None,
    allow: options.Allow = None,
    host: Host = "127.0.0.1",
    port: options.Port = 8765,
    public_url: Public = "",
    allow_host: Allowed = None,
    write_texts: WriteTexts = None,
    write_people: WritePeople = None,
    json: options.AsJson = False,
) -> None:
    """Let people take part in a study, on a page in their browser. The same command resumes the study.

    Together they play the trials of the agent participant, each trial once; lockprobe run, report and export treat
    these like any other agent's. Ctrl-C stops the server; no progress is lost. --json prints url, study_url,
    preview_url and directory.
    """
    if write_texts or write_people:
        _write(write_texts, write_people, texts)
        return
    options.permit(allow)
    if not host:
        raise BadValue("host", host, "a name or IP address of this machine")
    if not what:
        raise BadValue("study", what, f"one of {', '.join(STUDIES)}, FILE.toml, or the directory of a study")
    file, number = _people(people or [])
    own = {"language": texts, "participants": number, "join_code": join_code}
    own = {key: value for key, value in own.items() if value is not None}
    planned, directory, experiment = _study_and_people(what, asked, file, own, out)
    if planned.attended:
        raise BadValue("plant", planned.plant, "a plant that asks nothing at the terminal: several people play at once")
    door = {"host": host, "port": port, "public": public_url.rstrip("/"), "allowed": tuple(allow_host or ())}
    _serve(planned, directory, experiment, door, json=json)


def _study_and_people(
    name: str, asked: Mapping[str, object], file: Path | None, own: Mapping[str, object], out: Path | None
) -> tuple[Study, Path, Experiment]:
    """The study, its directory, and the settings for people. A number of people sets the number of trials."""
    planned, directory = _planned(name, asked, out)
    experiment = _experiment(file, own, directory)
    if isinstance(number := own.get("participants"), int) and not _is_directory(name) and "trials" not in asked:
        repetitions = planned.repetitions if "repetitions" in asked else 1
        luck = trials_for(number, len(conditions_of(planned)), repetitions, experiment)
        enough: dict[str, object] = {"trials": ceil(luck / len(planned.boxes)), "repetitions": repetitions}
        if planned.conditions == flips(planned.p, planned.flip, planned.modalities):
            enough["p"] = list(planned.p)  # conditions stay, though default rates depend on whether trials are set
        planned, directory = _planned(name, {**asked, **enough}, out)
        experiment = _experiment(file, own, directory)
    return planned, directory, experiment


def _serve(planned: Study, directory: Path, experiment: Experiment, door: Mapping[str, object], *, json: bool) -> None:
    for package in ("starlette", "uvicorn"):
        if find_spec(package) is None:
            raise Missing(f"lockprobe serve needs the package {package}", "pip install 'lockprobe[web]'")
    from lockprobe.people.web.address import Address
    from lockprobe.people.web.app import serve as until_stopped

    words = read_words(experiment.language)

    def announce(where: Any, state: Any) -> None:
        """Say that people can join, and the address to paste into a recruitment platform, with its placeholders."""
        parts = [f"{name}={PLACEHOLDERS.get(name, '…')}" for name in experiment.recruitment]
        parts += [f"{CODE}={experiment.join_code}"] if experiment.join_code else []
        url, preview = where.url, f"{where.url}?{PREVIEW}={state.preview}"
        given = url + ("?" + "&".join(parts) if parts else "")
        if json:
            said = {"url": url, "study_url": given, "preview_url": preview, "directory": str(directory)}
            print(jsonlib.dumps(said), flush=True)
            return
        size, each = planned.size // len(planned.agents), boxes_each(planned, experiment)
        lines = (
            f"{planned.name} on {planned.boxes_in_words} for people: {size} trials, {each} for each person",
            f"Participants  {url}",
            *([f"To paste      {given}  (placeholders of the recruitment platform)"] if parts else []),
            f"Preview       {preview}  (nothing is kept, and no place taken)",
            f"Kept in       {directory}",
            *(f"Note          {line}" for line in _reminders(planned, words, experiment)),
            f"Ctrl-C stops; the same command resumes. Hash of the settings: {planned.settings_hash}",
        )
        print("\n".join(lines), flush=True)

    address = Address(**door)  # type: ignore[arg-type] # named as its fields are
    asyncio.run(until_stopped(directory, planned, experiment, words, address, announce=announce))
    if not json:
        print("Stopped. The same command resumes; everybody continues where they were.")


def _reminders(planned: Study, words: Words, experiment: Experiment) -> Iterator[str]:
    """Tasks left for the experimenter before people come."""
    if planned.layout == "fixed":
        yield (
            "Every box lies on one panel, so people can go by places and labels alone. --layout shuffled deals the "
            "joints anew in every trial; a study that has begun stays as it is."
        )
    if any(words.consent == read_words(language).consent for language in LANGUAGES):
        yield (
            "The shipped consent text names nobody as responsible and does not say how long the study takes. "
            "Edit a copy (lockprobe serve --write-texts mine.toml) and use --texts mine.toml."
        )
    if not (experiment.join_code or experiment.require_id):
        yield "Anyone with the link can join. --join-code CODE, or require_id in people.toml, keeps others out."
    if experiment.completion_code and not (experiment.left_code or experiment.left_url):
        yield "completion_code is set, but nothing for those who do not finish. In people.toml set left_code."


def _planned(name: str, asked: Mapping[str, object], out: Path | None) -> tuple[Study, Path]:
    """The study, people among its agents, and its directory."""
    directory = Path(name)
    if _is_directory(name):
        if asked or out is not None:
            given = ", ".join("--" + key.replace("_", "-") for key in (*asked, *(["out"] if out else [])))
            raise Conflict(given, f"the directory {name}", "its study already has its settings")
        there = read_study(directory)
        return replace(there, agents=tuple(dict.fromkeys((*there.agents, PEOPLE)))), directory
    request = read_options(name, asked)
    planned = study(request, agent=list(dict.fromkeys((*(request.agent or ()), PEOPLE))))
    return planned, out or Path("lockprobe-runs") / f"{planned.name}-{planned.identity}"


def _is_directory(name: str) -> bool:
    return Path(name).is_dir() and name not in STUDIES


def _people(given: list[str]) -> tuple[Path | None, int | None]:
    """A file, a number of people, or both."""
    files, numbers = [one for one in given if not one.isdecimal()], [one for one in given if one.isdecimal()]
    if len(files) > 1 or len(numbers) > 1:
        raise BadValue("people", " ".join(given), "one file, one number, or one of each")
    return (Path(files[0]) if files else None), (int(numbers[0][:9]) if numbers else None)


def _experiment(path: Path | None, asked: Mapping[str, object], directory: Path) -> Experiment:
    """The settings for people: as given, or as stored in this directory."""
    given = read_experiment(path) if path is not None else kept_experiment(directory) or Experiment()
    return checked(Experiment, {**given.model_dump(), **asked})


def _write(texts: Path | None, people: Path | None, language: str | None) -> None:
    """Write the examples, in a language or in that of a file of texts, to where an experimenter edits them."""
    asked = language or Experiment().language
    spoken = read_words(asked).language
    if texts is not None:
        _copy(read_input(words_file(asked)), texts, "--texts")
    if people is not None:
        of = spoken if spoken in EXAMPLES else Experiment().language
        example = read_input(EXAMPLES[of]).decode()
        said = f"language = {jsonlib.dumps(asked, ensure_ascii=False)}"
        _copy(example.replace(f'language = "{of}"', said).encode(), people, "--people")


def _copy(content: bytes, target: Path, option: str) -> None:
    if os.path.lexists(target):
        raise BadFile(target, "already exists, and is not overwritten")
    write_file(target, content)
    print(f"Written: {target}. Edit it, then use it: lockprobe serve STUDY {option} {target}")
