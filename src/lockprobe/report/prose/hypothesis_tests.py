"""Sentences on hypothesis tests: what each asks, what it is called, and how to read it."""

from __future__ import annotations

from collections.abc import Mapping

from lockprobe.report.prose.doses import cause
from lockprobe.statistics.conditions.axis import FLIPS, Axis
from lockprobe.statistics.inference.verdict import MEAN_STEPS, ONE_LOOK, Question, TestResult

_ASKED: Mapping[Question, str] = {
    "success": "Do {cause} change how often the box is solved?",
    "speed": "Do {cause} change how many steps a trial takes?",
    "shape": "Does success rise and then fall again as the {dose} rises?",
    "looping": "Do {cause} change how soon an agent loops?",
    "looping again": "Do loops begin later and then sooner again as the {dose} rises?",
}


def asked(question: Question, axis: Axis = FLIPS) -> str:
    """What a test asks, of the doses of this axis."""
    return _ASKED[question].format(cause=cause(axis), dose=axis.name, doses=axis.plural)


_EFFECTS: Mapping[str, tuple[str, str]] = {
    "greatest difference from the lowest dose, permutation": ("points", "difference in success"),
    MEAN_STEPS: ("steps", "difference in mean steps, higher {doses} minus the lowest"),
    "two lines": ("dose", "{dose} at which the lines meet"),
    "loop onset, log-rank": ("ratio", "hazard ratio of a first loop, higher {doses} over the lowest"),
    "loop onset, two lines": ("dose", "{dose} at which the lines meet"),
}
"""Test -> the unit of its effect, and what the effect is."""

_NOTES: Mapping[str, str] = {
    "greatest difference from the lowest dose, permutation": (
        "Corrected for all {doses}; permuted within blocks. It rejects only if the interval, corrected alike, "
        "excludes 0."
    ),
    MEAN_STEPS: "Pools all higher {doses}, so no peak is selected. An unsolved trial counts with its whole budget.",
    "two lines": "Both lines have to be significant; a shape like the paper's needs about 160 trials per {dose}.",
    "loop onset, log-rank": "Pools all higher {doses}, so no peak is selected.",
    "loop onset, two lines": (
        "Both lines have to be significant. Compares the hazard of a first loop at equal steps, so it does not depend "
        "on the length of trials."
    ),
}
"""What a reader should know about each test."""

_MISSING: Mapping[str, str] = {
    "fewer than two doses": "No test: it needs two {doses} with trials.",
    "fewer than three doses": "No test: it needs three {doses} with trials.",
    "no common trial": "No test: no trial was played at two {doses}.",
    "no trial at the lowest dose": "No test: no trial at a higher {dose} was also played at the lowest.",
    "too few clusters": "No test: it needs two blocks (of people: two people on either side) with trials that differ.",
    ONE_LOOK: "No test: it holds for one look, at a number of trials that was planned before and is played.",
    "too few remain": "No test: too few trials finished without an error.",
    **{
        f"no fit with {number} doses": f"No fit: it needs three {{doses}} with trials that differ, and there {said}."
        for number, said in enumerate(("are none", "is one", "are 2"))
    },
    "fewer than three trials": "No fit: it needs three trials.",
    "every trial solved": "No fit: every trial was solved.",
    "no trial solved": "No fit: no trial was solved.",
    **{
        f"order {order} separates": f"No choice of order: order {order} separates solved from unsolved trials, so its "
        "fit has no maximum."
        for order in range(4)
    },
    "no band": "No band: resampling within repetitions needs two trials in each.",
    "": "",
}
"""Why a test or an estimate is missing, by the code that the analysis gives."""


def why_missing(code: str, axis: Axis = FLIPS) -> str:
    """Why a test or an estimate is missing; empty for an empty code."""
    return _MISSING[code].format(dose=axis.name, doses=axis.plural)


def effect_said(name: str, axis: Axis = FLIPS) -> str:
    """What the effect of a test is; empty where it has none."""
    return _EFFECTS.get(name, ("", ""))[1].format(dose=axis.name, doses=axis.plural)


def unit_of_effect(name: str) -> str:
    """The unit of the effect of a test; empty where it has none."""
    return _EFFECTS.get(name, ("", ""))[0]


def limits_said(test: TestResult, axis: Axis = FLIPS) -> str:
    """Why a test is missing, or what broken trials do to its P value; empty in all other cases."""
    broke = " Trials broke: interval and P value hold whatever became of them."
    return f"{why_missing(test.note, axis)}{broke * test.broken}".strip()


def note_said(name: str, axis: Axis = FLIPS) -> str:
    """How to interpret a test."""
    return _NOTES.get(name, "").format(dose=axis.name, doses=axis.plural)
