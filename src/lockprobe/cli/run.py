"""``lockprobe run``: play the trials that a study still owes, then write its report."""

from __future__ import annotations

import os
import sys
from collections.abc import Collection, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path

import typer

from lockprobe.agents.model_access import Access
from lockprobe.cli import options
from lockprobe.cli.cluster import reached
from lockprobe.cli.format_cost import print_estimates
from lockprobe.cli.progress import settings_line
from lockprobe.cli.run_study import allowed_budget, play_study
from lockprobe.cli.suite import run_suite
from lockprobe.errors import BadFile, BadValue, UnknownName
from lockprobe.interventions.condition import flips
from lockprobe.plants.catalogue import with_camera
from lockprobe.record import STATES
from lockprobe.studies.directory import SETTINGS
from lockprobe.studies.runner import Limits
from lockprobe.studies.settings import read_study
from lockprobe.studies.shard import Shard
from lockprobe.studies.study import Study
from lockprobe.studies.study_options import SHIPPED, StudyOptions, read_options_file
from lockprobe.studies.studyfile import STUDIES, study
from lockprobe.studies.suites import SUITES, is_suite, read_suite
from lockprobe.studies.yoking import is_yoked

__all__ = ["run"]


@options.with_study_options()
def run(
    what: options.Name,
    asked: Mapping[str, object],
    camera: options.Camera = None,
    out: options.Out = None,
    workers: options.Workers = None,
    shard: options.ShardOf = None,
    cluster: options.ClusterAt = None,
    connections: options.Connections = 10,
    timeout: options.Timeout = 120.0,
    retries: options.Retries = 6,
    batch: options.Batch = False,
    budget: options.Budget = None,
    again: options.Again = None,
    estimate: options.EstimateOnly = False,
    report: options.WriteReport = True,
    json: options.AsJson = False,
) -> None:
    """Play a study, or resume it, and write its report. The same command again resumes it; what people did there stays.

    flips: what false reports do. Without options a short study: 18 trials of the embedded model at each flip rate, and
    300 of a learner, random, round-robin and the human-inspired strategy, in a few minutes on two cores. modalities:
    what pictures do. RGB, RGB-D and reports, 10 trials each, on a simulated box with a camera; without options a
    scripted agent, human-inspired and random. why: whether lies change success because of what they say or because
    they disturb; without options three strategies. suite-1: five scores over four fixed boxes, 288 trials an agent;
    only --agent is chosen.

    --condition and --sweep vary anything else that lockprobe interventions lists, with the truth as control.

    Another --agent with --out and settings of a study is added to it, with the same luck. Exit status 3: a budget ended
    it; 1: every trial broke, or a condition has no valid trial.
    """
    if estimate and again is not None:
        raise BadValue("again", again, "no --estimate with it: that plays nothing and writes nothing")
    access = Access(connections=connections, timeout=timeout, retries=retries, batch=batch)
    part = None if shard is None else Shard.parse(shard)
    with reached(None if estimate else cluster) as machines:
        limits = Limits(workers=workers or min(os.cpu_count() or 1, 8), access=access, cluster=machines)
        if what in SUITES:
            if part is not None:
                raise BadValue("shard", shard, f"none with {what}, whose studies are small")
            chosen = asked if camera is None else {**asked, "camera": camera}
            suite = partial(run_suite, SUITES[what], chosen, out, limits, budget=budget, again=again)
            return suite(estimate=estimate, report=report, json=json)
        planned, directory = _planned(what, asked, out, camera)
        _refuse_followers(planned, part)
        if estimate:
            if not json:
                print(settings_line(planned.settings_hash), file=sys.stderr)
            return print_estimates([(planned, directory)], batch=batch, json=json)
        allowed = allowed_budget(planned, budget, directory)
        if status := play_study(planned, directory, limits, allowed, shard=part, again=again, report=report, json=json):
            raise typer.Exit(status)
    return None


def _refuse_followers(planned: Study, part: Shard | None) -> None:
    if part is not None and (followers := [one.label for one in planned.conditions if is_yoked(one)]):
        raise BadValue("shard", str(part), f"none with {followers[0]}, whose trials follow trials of other parts")


def _planned(name: str, asked: Mapping[str, object], out: Path | None, camera: str | None = None) -> tuple[Study, Path]:
    """The study of a name or file with the options of the command line, and its directory.

    Without an agent, those of an existing study play. A directory from an earlier release keeps its reports, unless a
    modality is given, and its number of trials of strategies.
    """
    if name not in STUDIES and Path(name).is_dir():
        expected = (
            f"one of {', '.join([*STUDIES, *SUITES])}, or FILE.toml; to go on, the same command with --out {name}"
        )
        raise BadValue("study", name, expected)
    if name not in STUDIES and not name.endswith(".toml"):
        raise UnknownName("study", name, [*STUDIES, *SUITES, *SHIPPED, "FILE.toml"])
    request = read_options_file(Path(name)) if name.endswith(".toml") else StudyOptions(study=name)
    if camera is not None:
        asked = {**asked, "plant": _photographed(asked.get("plant", request.plant), camera)}
    planned = study(request, **asked)
    if out is not None and (out / SETTINGS).exists():
        planned = _as_before(planned, read_study(out), {*request.model_fields_set, *asked})
    directory = out or Path("lockprobe-runs") / f"{planned.name}-{planned.identity}"
    if is_suite(directory):
        raise BadFile(directory, f"it holds {read_suite(directory).name}; {planned.name} needs another directory")
    if request.agent is None and "agent" not in asked and (directory / SETTINGS).exists():
        planned = replace(planned, agents=read_study(directory).run_agents or planned.agents)
    return planned, directory


def _photographed(plant: object, camera: str) -> str:
    """The spec of the plant that is asked for, with a camera."""
    if plant is None:
        raise BadValue("camera", camera, "--plant manual with it")
    return str(with_camera(str(plant), camera))


def _as_before(planned: Study, there: Study, given: Collection[str]) -> Study:
    """The study with the defaults of the release that its directory is from, where no option is given."""
    if "strategy_trials" not in given:
        planned = replace(planned, strategy_trials=there.strategy_trials)
    return planned if "modality" in given else _shown_as_before(planned, there)


def _shown_as_before(planned: Study, there: Study) -> Study:
    """The study with the reports of an earlier release, which told outcomes as well by default."""
    told = tuple(STATES if one == "symbolic" else one for one in there.modalities)
    if not (planned.of_flips and there.of_flips) or told != planned.modalities:
        return planned
    return replace(planned, conditions=flips(planned.p, planned.flip, there.modalities))
