"""How much of a study is played: the options that say it, and what a study has if a directory holds it already."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace
from typing import Any

from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.validation import check_whole
from lockprobe.studies.options.study_options import StudyOptions
from lockprobe.studies.study import LIMITS, SIZES, Study
from lockprobe.studies.until import MOST, Until

SIZE_OPTIONS = frozenset({"trials", "repetitions", "strategy_trials", "full", "until", "most"})
"""The options that say how much is played."""


def sizes_of(request: StudyOptions, boxes: int = 1) -> dict[str, Any]:
    """How much a request plays on so many boxes, in the fields of :class:`lockprobe.studies.study.Study`.

    Raises:
        BadValue: If it asks for a fixed number and for one that depends on what was played, or the rule is none.
    """
    until = _until(request)
    if until is not None:
        most = MOST if request.most is None else request.most
        check_whole("most", most, 1, LIMITS["trials"])
        return {"repetitions": 1, "trials": most, "until": until}
    found = {name: getattr(request, name) for name in ("repetitions", "trials", "strategy_trials")}
    many = {"repetitions": 1, "trials": boxes, "strategy_trials": boxes}
    return {name: value * many[name] for name, value in found.items() if value is not None}


def _until(request: StudyOptions) -> Until | None:
    """When the study stops; None if it plays all of its trials."""
    if request.until is None:
        if request.most is not None:
            raise BadValue("most", request.most, "--until with it; --trials says how many trials are played")
        return None
    if request.study == "looks":
        raise BadValue("until", request.until, f"none with {request.study}, whose answer holds for one look")
    for name in ("trials", "strategy_trials", "repetitions"):
        if (given := getattr(request, name)) is not None:
            raise BadValue(name, given, f"none with --until {request.until}; --most says how many trials at most")
    if request.full:
        rates = "--p 0,0.1,0.2,0.3,0.4,0.5,0.6 plays the paper's flip rates"
        raise BadValue("full", True, f"none with --until {request.until}; {rates}")
    return Until.parse(request.until)


def sized_as_there(planned: Study, there: Study, said: Collection[str]) -> Study:
    """A study with what was not said of its size as its directory has it.

    Args:
        planned: The study as it was asked for.
        there: The study of its directory.
        said: The options that were given, of :data:`SIZE_OPTIONS` and others.
    """
    said = SIZE_OPTIONS & {*said}
    if not said:
        return replace(planned, **{name: getattr(there, name) for name in SIZES})
    if "full" in said:
        return planned
    if planned.until is not None:
        return _until_there(planned, there, said)
    trials = planned.trials if "trials" in said else there.trials
    more = planned.strategy_trials
    if "strategy_trials" not in said:
        more = there.strategy_trials and max(there.strategy_trials, trials)
    return replace(
        planned,
        repetitions=planned.repetitions if "repetitions" in said else there.repetitions,
        trials=trials,
        strategy_trials=more,
    )


def _until_there(planned: Study, there: Study, said: Collection[str]) -> Study:
    """A study that stops, in the repetitions of its directory, since its trials are numbered within them.

    It plays at most what was said, in whole repetitions; else what its directory allows, or as many as by default.
    """
    each = max(1, planned.trials // there.repetitions)
    if "most" not in said:
        each = there.trials if there.until else max(each, there.trials)
    more = there.strategy_trials if there.strategy_trials and there.strategy_trials > each else None
    return replace(planned, repetitions=there.repetitions, trials=each, strategy_trials=more)
