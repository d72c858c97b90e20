"""The figures of a report by file name: the paper's, each with its corrected companion."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import NamedTuple

from lockprobe.analysis.agent_comparison.across_studies import Side, StudyDifference
from lockprobe.analysis.branch import BranchEffect
from lockprobe.analysis.effects import Effects
from lockprobe.analysis.inference.association import LENGTH_CAVEAT
from lockprobe.analysis.suite_scores import SuiteScore
from lockprobe.analysis.summary import StudySummary
from lockprobe.analysis.why import Why
from lockprobe.lockbox.box import Lockbox

__all__ = [
    "CAPTIONS",
    "CONDITION_CAPTIONS",
    "Caption",
    "Pictures",
    "box_picture",
    "comparison_picture",
    "condition_pictures",
    "drawings",
    "fork_pictures",
    "series_captions",
    "suite_picture",
]

Pictures = dict[str, dict[str, bytes]]

_LONGEST = (
    *("fig5b-corrected", "rationality", "fig5a-corrected", "fig5b", "fig4-corrected", "courses", "fig5a", "fig3-by-p"),
    *("side-by-side", "fig3-corrected", "fig4", "people", "fig3", "overview", "overview-column"),
)
"""All figures, what takes longest to draw first: with one panel for each agent, those with the most marks."""


class Caption(NamedTuple):
    """What a figure shows and how it was computed, at most two sentences each, and what else there is to know."""

    shown: str
    computed: str = ""
    more: str = ""


_FORKS = Caption(
    "Change of success by one report or action, by the step at which trials were forked; the line at 0 is a true "
    "report.",
    "Bars are 95 % intervals over trials, not corrected.",
)

_BOX = Caption("The panel at the start and, below, the interlock, which no agent sees.")

CAPTIONS = {
    "overview": Caption(
        "Trials solved; thin lines are baselines, stars the paper's model. Grey is chance: from random agents with "
        "immediate repeats to those without.",
        "Bars are 95 % intervals (Wilson).",
    ),
    "box": _BOX,
    "forks": _FORKS,
    "people": Caption(
        "People, models and strategies on the same boxes: above, the share of trials solved by flip rate; below, an "
        "agent's median steps over the human median, where 2 is twice the steps of people. People play several boxes "
        "and may learn from one to the next; agents keep nothing.",
        "Bars are 95 % intervals: above, those of one person and those of equal luck count together for people; "
        "below, they are over people and luck, and open where they reach the edge. Medians are of the trials that "
        "both finished, unsolved ones censored at the budget.",
        "Agents to compare with are thin with hollow markers and have no bars.",
    ),
    "side-by-side": Caption(
        "Two agents on the same boxes with the same false reports, the first named less the other; filled where the "
        "two are told apart. Above: the difference in the share of trials solved over all flip rates; below: how much "
        "more its success changes from the lowest flip rate to the one where the test sees that most clearly.",
        "Bars are 95 % intervals in which trials that share their luck count together, below not corrected for "
        "choosing the flip rate. Two are told apart by the test, corrected for the number of pairs and below for "
        "every flip rate, and above by the interval too.",
    ),
    "fig3": Caption(
        "The paper's Fig. 3: share of trials solved by each step, one line per agent, and per modality where there "
        "are several, at its lowest flip rate. Hollow stars: the paper's text, 80 % by step 9 (human-inspired), 11 "
        "(RGB) and 15 (ground truth).",
    ),
    "fig3-corrected": Caption(
        "The same beside the exact curves of random agents on this box and the shortest plan; below, the area under "
        "each curve between random and shortest plan. Agents to compare with are thin, with hollow markers and no "
        "band.",
        "Curves are one minus Kaplan-Meier with its 95 % band.",
    ),
    "fig3-by-p": Caption(
        "The same for every flip rate. Bands are drawn for the lowest and for the one whose final success lies "
        "farthest from it; of more than eleven only these and the highest are named.",
    ),
    "fig4": Caption(
        "The paper's Fig. 4: success by flip rate. Hollow stars: the paper's text, 23.3 % at a flip rate of 0 and "
        "2.85 times that, 20 of 30, at 0.4.",
        "Dots are repetitions (larger where several coincide), markers their means. The line is the second-order "
        "least-squares fit with its 95 % bootstrap band.",
    ),
    "fig4-corrected": Caption(
        "The same with what it takes to judge it, beside the exact success of random agents. Triangles stand under "
        "every flip rate that may be the best.",
        "Intervals are Wilson's, 95 %; the line is a binomial model of the order that AICc prefers with its 95 % "
        "band. The diamond is the highest share less what it owes to having been chosen.",
    ),
    "courses": Caption(
        "Share of trials solved (circles) and share with an action loop (squares) by flip rate: every agent, and the "
        "course of its success that the tests bear out.",
        "Intervals are Wilson's, 95 %.",
    ),
    "rationality": Caption(
        "Share of actions that are optimal to an ideal observer who believes reports (circles) and to one who doubts "
        "them (squares); below, expected steps lost per action. Dotted and dashed: a random choice in the same "
        "situations.",
        "Intervals are 95 % and take a trial as one.",
    ),
    "fig5a": Caption(
        "The paper's Fig. 5a: share of trials with an action loop against success, one dot per repetition and flip "
        "rate, with the least-squares line and r.",
        LENGTH_CAVEAT,
    ),
    "fig5a-corrected": Caption(
        "Is success rarer after a loop? An agent that is lost both loops and fails: a ratio below one is no proof of "
        "harm.",
        "Odds of solving the box after a loop over the odds before one, among trials still running at the same step "
        "(top) or after step 10. Over whole trials (hollow) the ratio can be far below one even if loops do nothing, "
        "because a solved trial ends before it can loop.",
        "An arrow at the edge is a ratio beyond the axis.",
    ),
    "fig5b": Caption(
        "The paper's Fig. 5b: share of trials with an action loop by flip rate, with the second-order fit. Hollow "
        'stars: the paper\'s text, reconstructed as 24 of 30 at a flip rate of 0 ("approximately 80 %") and 16 of 30 '
        'at 0.4 ("a decrease of more than 26 %", taken in points).',
    ),
    "fig5b-corrected": Caption(
        "Loop rates beside what chance gives in trials of exactly these lengths, and the share that has looped by "
        "each step. Grey: between random actions (dotted) and those without repeats (dashed); crosses: the agent's "
        "own transitions; plus signs: its own actions in random order.",
        "Intervals of loop rates are Wilson's, 95 %. The share by step is one minus Kaplan-Meier, as if no trial had "
        "been cut short by success (taking trials about to be solved to loop like the others).",
    ),
}
"""The caption of every figure, by file name."""

CONDITION_CAPTIONS = {
    "box": _BOX,
    "forks": _FORKS,
    "why": Caption(
        "Top: share of trials solved in each arm; the dotted line is the share under true reports. Bottom: what false "
        "reports change, and its two parts.",
        "Intervals are 95 %: Wilson's at the top, over pairs of trials of equal luck at the bottom.",
    ),
    "effects": Caption(
        "Circles: share of trials solved under each condition less that under the control. Squares: how much more the "
        "second of two interventions changes it where the first acts too.",
        "Bars are intervals over pairs of trials that share their luck, corrected for the number of conditions "
        "(squares: 95 %, not corrected). Filled where the test and the interval show a difference.",
    ),
    "grid": Caption(
        "Share of trials solved under every combination of two doses, with the count and an interval as far as there "
        "is room; darker is more, a cross was not played. The interaction is in points.",
        "Intervals are Wilson's, 95 %, in per cent.",
    ),
}
"""The same of a study of conditions."""


def series_captions(dose: str) -> dict[str, Caption]:
    """The captions of the figures of success and of loops over one dose.

    Args:
        dose: What the dose is called.
    """
    return {
        "success": Caption(
            f"Share of trials solved by {dose}, beside the exact success of random agents. Triangles: doses that may "
            "be the best.",
            "Intervals are Wilson's, 95 %; the line is a binomial model of the order that AICc prefers. The diamond is "
            "the highest share less what it owes to having been chosen.",
        ),
        "loops": Caption(
            f"Share of trials with an action loop by {dose}, beside what chance gives in trials of exactly these "
            "lengths.",
            "Intervals are Wilson's, 95 %.",
        ),
    }


def fork_pictures(found: Sequence[BranchEffect]) -> dict[str, Callable[[], dict[str, bytes]]]:
    """The figure of forks by name, as a function that draws it as PNG and SVG; none without numbered steps."""
    from lockprobe import figures

    return {"forks": partial(_draw_forks, found)} if figures.fork_panels(found) else {}


def _draw_forks(found: Sequence[BranchEffect]) -> dict[str, bytes]:
    from lockprobe import figures

    figure = figures.fork_drawing(found)
    return {"png": figures.render(figure, "png"), "svg": figures.render(figure, "svg")}


def comparison_picture(found: Sequence[StudyDifference], names: Mapping[Side, str]) -> dict[str, bytes]:
    """The figure of differences between studies as PNG and SVG; at least one difference."""
    from lockprobe import figures
    from lockprobe.figures.study_comparison import comparison_drawing

    figure = comparison_drawing(found, names)
    return {"png": figures.render(figure, "png"), "svg": figures.render(figure, "svg")}


def suite_picture(entries: Sequence[tuple[str, SuiteScore]]) -> dict[str, bytes]:
    """The figure of the scores of a suite as PNG and SVG; at least one agent."""
    from lockprobe import figures
    from lockprobe.figures.suite import suite_drawing

    figure = suite_drawing(entries)
    return {"png": figures.render(figure, "png"), "svg": figures.render(figure, "svg")}


def box_picture(box: Lockbox) -> dict[str, Callable[[], dict[str, bytes]]]:
    """The figure of a box by name, as a function that draws it as PNG and SVG."""
    return {"box": partial(_draw_box, box)}


def _draw_box(box: Lockbox) -> dict[str, bytes]:
    from lockprobe import figures
    from lockprobe.figures.boxes import box_figure

    figure = box_figure(box)
    return {"png": figures.render(figure, "png"), "svg": figures.render(figure, "svg")}


def drawings(summary: StudySummary) -> dict[str, Callable[[], dict[str, bytes]]]:
    """Every figure by name, as a function that draws it as PNG and SVG; none if no trial has ended.

    What takes longest comes first.
    """
    if not any(condition.success.n for condition in summary.conditions):
        return {}
    from lockprobe import figures

    names = sorted(figures.drawings(summary), key=_LONGEST.index)
    return {name: partial(_draw, summary, name) for name in names}


def condition_pictures(
    effects: Sequence[Effects], series: Sequence[StudySummary], whys: Sequence[Why] = ()
) -> dict[str, Callable[[], dict[str, bytes]]]:
    """Every figure of a study of conditions by name, as a function that draws it as PNG and SVG."""
    from lockprobe import figures

    return {
        name: partial(_draw_condition, effects, series, whys, name)
        for name in figures.condition_drawings(effects, series, whys)
    }


def _draw_condition(
    effects: Sequence[Effects], series: Sequence[StudySummary], whys: Sequence[Why], name: str
) -> dict[str, bytes]:
    from lockprobe import figures

    figure = figures.condition_drawings(effects, series, whys)[name]()
    return {"png": figures.render(figure, "png"), "svg": figures.render(figure, "svg")}


def _draw(summary: StudySummary, name: str) -> dict[str, bytes]:
    from lockprobe import figures

    figure = figures.drawings(summary)[name]()
    return {"png": figures.render(figure, "png"), "svg": figures.render(figure, "svg")}
