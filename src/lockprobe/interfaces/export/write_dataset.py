"""Writes people's trials as a Psych-DS dataset: tables for any statistics package, with every column described.

::

    dataset_description.json      what it is, and what stands in every column (schema.org, JSON-LD)
    README.md, CHANGES.md
    materials/texts.toml          what the participants read, if it is still where it was
    data/study-flips_description-steps_data.csv, -trials_, -participants_, -acts_, -checks_, -answers_
    records/                      the same as the directory of a study: `lockprobe import` and `report` take it

The tables are made of the records alone, so that whoever has both can see whether they agree.
"""

from __future__ import annotations

import io
import json
import re
import shutil
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from importlib.metadata import version
from pathlib import Path

from lockprobe.foundation.errors import BadFile, UserMistake
from lockprobe.foundation.formatting import markdown_table
from lockprobe.foundation.spec import PEOPLE
from lockprobe.foundation.storage.atomic_file import atomic_directory, write_private
from lockprobe.interfaces.export.data_dictionary import column
from lockprobe.interfaces.export.table_files import write_csv
from lockprobe.interfaces.export.tables import TABLES, PeopleRecords, Table, tables_of
from lockprobe.people.diary import without_identity, write_diaries
from lockprobe.people.experiment import EXPERIMENT, SECRET
from lockprobe.people.journey import fingerprint
from lockprobe.people.texts import TEXTS, read_words, words_file
from lockprobe.people.withdrawal import count_withdrawn, withdrawn
from lockprobe.studies.file_names import PEOPLE_DIRECTORY
from lockprobe.studies.records.journal import Journal, Timing, read_timings
from lockprobe.studies.records.picture_store import ALBUM
from lockprobe.studies.study import Study
from lockprobe.trial.pictures.picture import PICTURE_NAME

__all__ = [
    "DATA",
    "DESCRIPTION",
    "MATERIALS",
    "PSYCH_DS",
    "RECORDS",
    "as_csv",
    "data_file",
    "shareable",
    "write_dataset",
]

PSYCH_DS = "Psych-DS 1.5.0"
"""The version of the Psych-DS standard."""

DESCRIPTION, DATA, MATERIALS, RECORDS = "dataset_description.json", "data", "materials", "records"


def data_file(study: Study, table: str) -> str:
    """The file name of a table, with keywords and values as Psych-DS requires.

    >>> from lockprobe.studies.options.studyfile import study
    >>> data_file(study("flips"), "steps")
    'study-flips_description-steps_data.csv'
    """
    return f"study-{re.sub(r'[^A-Za-z0-9]', '', study.name) or 'lockbox'}_description-{table}_data.csv"


def write_dataset(directory: Path, out: Path, *, everybody: bool = False, platform_ids: bool = False) -> list[Path]:
    """Write people's data of a study as a Psych-DS dataset.

    Args:
        directory: The directory of the study.
        out: The directory of the dataset, new or empty.
        everybody: Whether to include trials of strategies and models.
        platform_ids: Whether to include participants' parameters from the recruitment platform.

    Returns:
        The paths of its tables.

    Raises:
        BadFile: If nobody took part, ``out`` is not empty, a file is damaged or cannot be written, or a diary and a
            record disagree.
    """
    source = PeopleRecords.read(directory)
    if not source.diaries and not any(trial.player for trial in source.trials):
        raise BadFile(directory, "nobody took part in this study, so there are no data of people")
    if out.exists() and (not out.is_dir() or any(out.iterdir())):
        raise BadFile(out, "exists and is not empty; a dataset needs a new directory")
    given = shareable(source, everybody=everybody, platform_ids=platform_ids)
    with atomic_directory(out) as draft:
        _write_records(given, draft / RECORDS)
        given = PeopleRecords.read(draft / RECORDS)
        tables = tables_of(given)
        (draft / DATA).mkdir()
        for table in tables:
            (draft / DATA / data_file(given.study, table.name)).write_text(as_csv(table), "utf-8", newline="")
        if (texts := _texts_read(source)) is not None:
            (draft / MATERIALS).mkdir()
            (draft / MATERIALS / TEXTS).write_bytes(texts)
            write_private(draft / RECORDS / PEOPLE_DIRECTORY / TEXTS, texts)
        described = _description(given, tables, everybody=everybody)
        (draft / DESCRIPTION).write_text(json.dumps(described, indent=2, ensure_ascii=False) + "\n", "utf-8")
        (draft / "README.md").write_text(_readme(given, described, texts=texts is not None), "utf-8")
        (draft / "CHANGES.md").write_text(
            f"# Changes\n\n1.0.0: written by Lockprobe {version('lockprobe')}.\n", "utf-8"
        )
        (draft / ".psychds-ignore").write_text(f"{RECORDS}/\n.psychds-ignore\n", "utf-8")
    return [out / DATA / data_file(given.study, table.name) for table in tables]


def shareable(source: PeopleRecords, *, everybody: bool = False, platform_ids: bool = False) -> PeopleRecords:
    """The records for sharing: without the identity of participants and without the time of participation.

    ``everybody`` keeps trials of strategies and models, ``platform_ids`` the recruitment platform's parameters.
    """
    return replace(
        source,
        study=source.study if everybody else replace(source.study, agents=(PEOPLE,)),
        trials=tuple(trial for trial in source.trials if everybody or trial.player),
        diaries=tuple(without_identity(kept, platform=platform_ids) for kept in source.diaries),
    )


def _write_records(given: PeopleRecords, records: Path) -> None:
    seconds = {timing.key: timing.seconds for timing in read_timings(given.directory)}
    with Journal.open(records, given.study) as journal:
        for trial in given.trials:
            journal.append(trial, Timing(key=trial.key, seconds=seconds.get(trial.key, 0.0), steps=len(trial.steps)))
    names = {name for trial in given.trials for name in trial.picture_names if PICTURE_NAME.fullmatch(name)}
    for name in sorted(names):
        if (picture := given.directory / ALBUM / name).is_file():
            (records / ALBUM).mkdir(exist_ok=True)
            shutil.copyfile(picture, records / ALBUM / name)
    write_diaries(records, given.diaries)
    if number := withdrawn(given.directory):
        count_withdrawn(records, number)
    if given.experiment is not None:
        language = Path(given.experiment.language).name
        settings = given.experiment.model_copy(update={**dict.fromkeys(SECRET, ""), "language": language})
        write_private(records / PEOPLE_DIRECTORY / EXPERIMENT, f"{settings.model_dump_json(indent=2)}\n")


def _texts_read(source: PeopleRecords) -> bytes | None:
    """The file with the texts that the participants read; None if it is missing or has changed."""
    read = {kept.joined.words for kept in source.diaries}
    language = "" if source.experiment is None else source.experiment.language
    for name in (language, str(source.directory / PEOPLE_DIRECTORY / TEXTS)):
        with suppress(UserMistake, OSError):
            if fingerprint(read_words(name)) in read:
                return words_file(name).read_bytes()
    return None


def as_csv(table: Table) -> str:
    """CSV as in RFC 4180. Line ends are CR LF, so a single CR or LF within a text is quoted."""
    file = io.StringIO()
    write_csv(table.columns, table.rows, file, end="\r\n")
    return file.getvalue()


def _description(given: PeopleRecords, tables: Sequence[Table], *, everybody: bool) -> dict[str, object]:
    study = given.study
    players = {trial.player for trial in given.trials if trial.player}
    who = {*players, *(kept.spec for kept in given.diaries)}
    others = (
        "Trials of strategies and models are included."
        if everybody
        else "Trials of strategies and models are not included."
    )
    played = sum(trial.agent in players for trial in given.trials)
    return {
        "@context": "https://schema.org/",
        "@type": "Dataset",
        "name": f"People opening lockboxes: {study.name} on {study.box.name}",
        "description": (
            f"{len(who)} people, {len(players)} with trials ({played} in all) in which they tried to open a lockbox, "
            f"step by step: their attempts, the true outcomes, the reports, and response times. {others} Steps of "
            "unfinished trials are in the table of acts, not in the table of steps."
        ),
        "schemaVersion": PSYCH_DS,
        "keywords": ["lockbox", "problem solving", "exploration", "false reports", "action loops"],
        "variableMeasured": [
            _variable(name) for name in dict.fromkeys(name for table in tables for name in table.columns)
        ],
    }


def _variable(name: str) -> dict[str, object]:
    about = column(name)
    facts = {"unitText": about.unit or None, "minValue": about.least, "maxValue": about.most}
    stated = {fact: value for fact, value in facts.items() if value is not None}
    return {"@type": "PropertyValue", "name": name, "description": about.meaning, **stated}


def _readme(given: PeopleRecords, described: dict[str, object], *, texts: bool) -> str:
    read = f"`{MATERIALS}/{TEXTS}` holds the texts that the participants read.\n\n" if texts else ""
    rows = ((data_file(given.study, name), row) for name, row in TABLES.items())
    return f"""# {described["name"]}

{described["description"]}

{markdown_table(("file in data/", "one row is"), *rows)}

{read}{DESCRIPTION} describes every column with its unit and its clock. There are two clocks: response times are
measured by the participant's browser, and times of arrival by the server. No time reveals the day or the time of day
at which somebody took part. `state` has `b` in front, so that no program reads it as a number. A text that a
spreadsheet would read as a formula has an apostrophe in front; `{RECORDS}/` has the original text.

Before you share this dataset: read the written answers, which may contain personal data, and add `author`, `license`
and other fields to {DESCRIPTION}.

`{RECORDS}/` holds the same data as Lockprobe's records. `lockprobe import DIR THIS` imports the trials into a study if
the tables in data/ agree with the records; `lockprobe report {RECORDS}` reports on them.
"""
