"""``lockprobe import``: imports trials that were played elsewhere."""

from __future__ import annotations

import json as json_
import sys
from contextlib import ExitStack
from dataclasses import asdict
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated

import typer

from lockprobe.cli import options
from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.formatting import count
from lockprobe.foundation.inputs import read_input
from lockprobe.foundation.storage.atomic_file import write_private
from lockprobe.foundation.storage.database import Damaged
from lockprobe.foundation.terminal_text import printable
from lockprobe.people.diary import make_private, read_diaries, take_diaries
from lockprobe.people.experiment import EXPERIMENT, TEXTS
from lockprobe.studies import PEOPLE_DIRECTORY
from lockprobe.studies.records.merge import check_source, gather, save_sound_rows
from lockprobe.studies.records.store import ALBUM


def take(
    directory: Annotated[Path, typer.Argument(metavar="DIR", help="The directory of a study; created if missing.")],
    sources: Annotated[list[Path], typer.Argument(metavar="SOURCE...", help="The directory of another study.")],
    json: options.AsJson = False,
) -> None:
    """Import trials that DIR does not have from other study directories.

    They must be of the same study: all settings except the agents must be equal. Of a damaged one, what is sound is
    taken.
    """
    with ExitStack() as held:
        found, coming = list[Path](), list[str]()
        for path in sources:
            if path.resolve() == directory.resolve():
                raise BadValue("SOURCE", str(path), "a directory other than DIR")
            try:
                read_diaries(path)
                check_source(path)
                found.append(path)
            except Damaged as damaged:
                sound = Path(held.enter_context(TemporaryDirectory()))
                saved = save_sound_rows(path, sound)
                _copy_settings_for_people(path, sound)
                (sound / ALBUM).symlink_to((path / ALBUM).absolute())
                for line in (damaged.found, f"Sound in {path}: {count(saved, 'trial')}."):
                    print(printable(line), file=sys.stderr)
                found.append(sound)
        gathered = gather(directory, found, beside=lambda journal: coming.extend(take_diaries(journal.store, found)))
        if coming:
            make_private(directory)
            for source in found:
                _copy_settings_for_people(source, directory)
    if json:
        print(json_.dumps({**asdict(gathered), "participants": len(coming)}))
        return
    said = (
        f"{count(gathered.taken, 'trial')} imported, {gathered.there} already there ({gathered.different} differ from "
        f"those of {directory}, which keeps its own), {gathered.unfinished} unfinished ({gathered.replies} replies "
        f"kept for them), {count(len(coming), 'participant')}. New agents: {', '.join(gathered.agents) or 'none'}."
    )
    print(printable(f"{said} Report: lockprobe report {directory}"))


def _copy_settings_for_people(source: Path, into: Path) -> None:
    """Copy those that are not there."""
    for name in (EXPERIMENT, TEXTS):
        here = into / PEOPLE_DIRECTORY / name
        if (there := source / PEOPLE_DIRECTORY / name).is_file() and not here.exists():
            write_private(here, read_input(there))
