"""The study that a command line of ``lockprobe run`` asks for, and its directory."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from lockprobe.foundation.errors import BadFile, BadValue
from lockprobe.interventions.sources import follows
from lockprobe.plants.catalogue import with_camera
from lockprobe.studies.extension import extended, extension_said
from lockprobe.studies.options.settings import read_study
from lockprobe.studies.options.study_options import StudyOptions, read_options_file
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.records.directory import SETTINGS
from lockprobe.studies.records.shard import Shard
from lockprobe.studies.study import Study
from lockprobe.studies.suites import is_suite, read_suite

__all__ = ["planned_study", "refuse_followers"]

_SIZES = {"trials", "repetitions", "strategy_trials", "full", "until", "most"}
"""The options that say how much is played."""

AT_EVERY_LOOK = "The report shows what holds at every look."


def planned_study(
    name: str, asked: Mapping[str, object], out: Path | None, camera: str | None = None
) -> tuple[Study, Path]:
    """The study of a name or file with the options of the command line, and its directory.

    Without an agent, those of an existing study play.
    """
    request = read_options_file(Path(name)) if name.endswith(".toml") else StudyOptions(study=name)
    if camera is not None:
        asked = {**asked, "plant": _photographed(asked.get("plant", request.plant), camera)}
    planned = study(request, **asked)
    directory = out or Path("lockprobe-runs") / f"{planned.name}-{planned.identity}"
    if is_suite(directory):
        raise BadFile(directory, f"it holds {read_suite(directory).name}; {planned.name} needs another directory")
    if not (directory / SETTINGS).exists():
        return planned, directory
    there = read_study(directory)
    if request.agent is None and "agent" not in asked and there.run_agents:
        planned = replace(planned, agents=there.run_agents, names=there.names)
    planned = planned.ordered_as(there.settings())
    if not _SIZES & {*asked, *request.model_fields_set}:
        return replace(planned, earlier=there.earlier), directory
    if planned.until and there.repetitions > 1:  # its repetitions stay, since its trials are numbered within them
        each = -(-planned.trials // there.repetitions)
        planned = replace(planned, repetitions=there.repetitions, trials=each)
    longer = extended(planned, directory)
    if len(longer.earlier) > len(there.earlier):
        print(f"Extended: {extension_said(longer)}. {AT_EVERY_LOOK}", file=sys.stderr)
    return longer, directory


def refuse_followers(planned: Study, part: Shard | None) -> None:
    """Refuse a part of a study in which trials follow those of other parts.

    Raises:
        BadValue: If it is such a study.
    """
    if part is not None and (followers := [one.label for one in planned.conditions if follows(one)]):
        raise BadValue("shard", str(part), f"none with {followers[0]}, whose trials follow trials of other parts")


def _photographed(plant: object, camera: str) -> str:
    """The spec of the plant that is asked for, with a camera."""
    if plant is None:
        raise BadValue("camera", camera, "--plant manual with it")
    return str(with_camera(str(plant), camera))
