"""The study that a command line of ``lockprobe run`` asks for, and its directory."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from lockprobe.foundation.errors import BadValue
from lockprobe.plants.catalogue import with_camera
from lockprobe.studies.extension import SIZE_OPTIONS, extended, sized_as_there
from lockprobe.studies.file_names import SETTINGS
from lockprobe.studies.options.study_options import StudyOptions, read_options_file
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.records.directory import read_study
from lockprobe.studies.study import SIZES, WHO, Study


def planned_study(
    name: str, asked: Mapping[str, object], out: Path | None, camera: str | None = None
) -> tuple[Study, Path]:
    """The study of a name or file with the options of the command line, and its directory.

    Without an agent, those of an existing study play. What is not said of its size is as in an existing study.
    """
    request = read_options_file(Path(name)) if name.endswith(".toml") else StudyOptions(study=name)
    if camera is not None:
        asked = {**asked, "plant": _photographed(asked.get("plant", request.plant), camera)}
    planned, said = study(request, **asked), {*asked, *request.model_fields_set}
    directory = out or Path("lockprobe-runs") / f"{planned.name}-{planned.identity}"
    if not (directory / SETTINGS).exists():
        return planned, directory
    there = read_study(directory)
    if SIZE_OPTIONS & said and not (plain := _unsized(request, asked)).differences(there, but=(*WHO, *SIZES)):
        planned = replace(plain, **{name: getattr(planned, name) for name in SIZES})
    if request.agent is None and "agent" not in asked and there.run_agents:
        planned = replace(planned, agents=there.run_agents, names=there.names)
    planned = planned.ordered_as(there)
    planned = sized_as_there(planned, there, said)
    return extended(planned, directory), directory


def _unsized(request: StudyOptions, asked: Mapping[str, object]) -> Study:
    """The study that is asked for, had nothing been said of its size; a size can change what else it has by default."""
    plain = request.model_copy(update=dict.fromkeys(SIZE_OPTIONS - {"full"}))
    return study(plain, **{name: value for name, value in asked.items() if name not in SIZE_OPTIONS - {"full"}})


def _photographed(plant: object, camera: str) -> str:
    """The spec of the plant that is asked for, with a camera."""
    if plant is None:
        raise BadValue("camera", camera, "--plant manual with it")
    return str(with_camera(str(plant), camera))
