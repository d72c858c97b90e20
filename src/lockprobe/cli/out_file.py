"""Where a command may write a file: nowhere in the place of what belongs to a study."""

from __future__ import annotations

from pathlib import Path

from lockprobe.foundation.errors import BadFile
from lockprobe.studies import FORKS, PEOPLE_DIRECTORY, SETTINGS
from lockprobe.studies.records.store import ALBUM, STORE

_OF_STUDY = {SETTINGS, "results.json", "report.html", ALBUM, PEOPLE_DIRECTORY, FORKS}
"""What no export may replace, beside the store and what is named after it; beside figures and tables there is room."""


def refuse_study_file(out: Path) -> None:
    """Refuse to replace a file of any study, also through a link.

    Raises:
        BadFile: If ``out`` is such a file.
    """
    file = out.resolve()
    for place in file.parents:
        name = file.relative_to(place).parts[0]
        if (place / SETTINGS).is_file() and (name in _OF_STUDY or name.startswith(STORE)):
            raise BadFile(out, "belongs to the study; choose another file")
