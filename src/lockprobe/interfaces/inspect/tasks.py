"""The studies as Inspect tasks: ``inspect eval lockprobe/flips --model openai/gpt-4o -T p=0,0.4 -T trials=5``.

One sample is one trial, named by its place in the study: ``flip?p=0.4/rep=2/trial=7``. Epochs are further repetitions.
Inspect AI imports this module whenever a model is opened, so what plans and plays a study is imported with the first
task.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from lockprobe.agents.prompt import instructions
from lockprobe.foundation.errors import BadValue, UserMistake, needing
from lockprobe.interfaces.inspect.samples import OPTIONS, SETTINGS, VERSION, VIEW, metadata_of, sample_id
from lockprobe.interfaces.inspect.scoring import metrics_of, played
from lockprobe.interfaces.inspect.solver import agent_spec, play_trial
from lockprobe.studies.options.study_options import StudyOptions, parse_p
from lockprobe.trial.briefing import Briefing
from lockprobe.trial.plan import Names, Plan

with needing("Inspect tasks", "providers"):
    from inspect_ai import Task, task
    from inspect_ai.dataset import MemoryDataset, Sample
    from inspect_ai.model import GenerateConfig

    from lockprobe.agents.llm.inspect_internals import PrerequisiteError

if TYPE_CHECKING:
    from lockprobe.studies.study import Study

__all__ = ["flips", "modalities"]

_MODEL = "llm:inspect/model"
"""A placeholder for the eval's model, which is unknown while a task is made."""

_YES_OR_NO = ("assessment", "full", "as_paper", "parts")
"""Boolean parameters; YAML also reads ``on`` and ``yes`` as true."""


def _with_parameters(make: Callable[..., Task]) -> Callable[..., Task]:
    """Give a task the options of a study and of a model as parameters that Inspect recognises."""
    names = [name for name in StudyOptions.model_fields if name not in {"study", "agent"}]
    parameters = [inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=None) for name in (*names, *OPTIONS)]
    unknown = inspect.Parameter("unknown", inspect.Parameter.VAR_KEYWORD)  # so that they come here, and are refused
    make.__signature__ = inspect.Signature([*parameters, unknown])  # type: ignore[attr-defined]
    return make


@task
@_with_parameters
def flips(**given: Any) -> Task:
    """The effect of false reports on an agent that solves a lockbox (Sec. 3.2).

    The parameters are the options of ``lockprobe run flips``; the last four are options of the model.
    """
    return _task("flips", given)


@task
@_with_parameters
def modalities(**given: Any) -> Task:
    """The effect of pictures on an agent that solves a lockbox: RGB, RGB-D, and reports in words (Sec. 3.1).

    The parameters are the options of ``lockprobe run modalities``; the last four are options of the model.
    """
    return _task("modalities", given)


def _task(name: str, given: Mapping[str, Any]) -> Task:
    with _in_one_line():
        asked = {key: value for key, value in given.items() if value is not None and key not in {"model", *OPTIONS}}
        options = {key: given[key] for key in OPTIONS if given.get(key) is not None}
        planned = _planned(name, asked)
        _refuse_yes_or_no(options)
        agent_spec("inspect/model", options, GenerateConfig())  # before the first call
        samples = [_sample(plan) for plan in planned.plans(_MODEL)]
    settings = {**planned.settings(), "agents": []}
    return Task(
        dataset=MemoryDataset(samples, name=name),
        solver=play_trial(settings=settings, options=options),
        scorer=played(),
        metrics=metrics_of(planned),
        continue_on_fail=True,  # one trial that a provider broke ends no other; eval-retry plays it again
        version=VERSION,
        metadata={SETTINGS: settings},
        viewer=VIEW,
    )


@contextmanager
def _in_one_line() -> Iterator[None]:
    """Turn a user's mistake into an error that Inspect prints as one line, without a traceback."""
    try:
        yield
    except UserMistake as mistake:
        raise PrerequisiteError(f"lockprobe: {mistake}") from None


def _planned(name: str, asked: Mapping[str, Any]) -> Study:
    """The study that task parameters describe."""
    from lockprobe.studies.options.studyfile import study

    given = {**asked, "study": name, "agent": [_MODEL]}
    _refuse_yes_or_no(asked)
    p = given.get("p")
    if p is not None and not isinstance(p, list):
        given["p"] = parse_p(p) if isinstance(p, str) else [p]
    if isinstance(swept := given.get("sweep"), list):
        given["sweep"] = ",".join(map(str, swept))  # Inspect takes what has commas for a list
    planned = study(**given)
    if planned.until is not None:
        raise BadValue("until", str(planned.until), "none with Inspect, which plays all samples; `lockprobe run` stops")
    return planned


def _refuse_yes_or_no(asked: Mapping[str, object]) -> None:
    """Refuse true and false as numbers, which Python would accept."""
    for name, value in asked.items():
        if isinstance(value, bool) and name not in _YES_OR_NO:
            raise BadValue(name, value, "a number or a word, not true or false")


def _sample(plan: Plan) -> Sample:
    """One trial as a sample, its place in the metadata."""
    from lockprobe.interventions.camera import CameraChannel
    from lockprobe.interventions.words import TextChannel
    from lockprobe.plants.catalogue import resolve_plant
    from lockprobe.studies.modality import shown

    task = Names(plan).task(plan)
    channel = shown(plan.modality)
    pictures = 1 + (channel.depth != "none") if isinstance(channel, CameraChannel) else 0
    words = channel if isinstance(channel, TextChannel) else TextChannel()
    return Sample(
        id=sample_id(plan),
        input=instructions(
            task,
            positions=words.tell != "outcome",
            outcomes=words.tell != "state",
            in_full=words.form != "words",
            pictures=pictures,
            labelled=(resolve_plant(plan.plant).options or {}).get("labels") != "no",
            briefing=Briefing(hypothesis=plan.hypothesis),
        ),
        target=task.target,
        metadata=metadata_of(plan),
    )
