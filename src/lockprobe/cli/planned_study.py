"""The study that a command line of ``lockprobe run`` asks for, and its directory."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from lockprobe.studies.file_names import SETTINGS
from lockprobe.studies.options.study_options import read_options
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.records.directory import extended, read_study
from lockprobe.studies.study import SIZES, Study


def planned_study(name: str, asked: Mapping[str, object], out: Path | None) -> tuple[Study, Path]:
    """The study of a name or file with the options of the command line, and its directory.

    Without an agent, those of an existing study play; if nothing is said of its size, it stays as large as it is.
    """
    request = read_options(name, asked)
    planned, said = study(request), request.model_fields_set
    directory = out or Path("lockprobe-runs") / f"{planned.name}-{planned.identity}"
    if not (directory / SETTINGS).exists():
        return planned, directory
    there = read_study(directory)
    if not {"trials", "repetitions", "strategy_trials", "full", "until", "most"} & said:
        planned = replace(planned, **{name: getattr(there, name) for name in SIZES})
    if request.agent is None and there.run_agents:
        planned = replace(planned, agents=there.run_agents, names=there.names)
    return extended(planned.ordered_as(there), directory), directory
