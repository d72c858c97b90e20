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
from lockprobe.report.results import StudyNumbers

__all__ = [
    "CAPTIONS",
    "CONDITION_CAPTIONS",
    "Caption",
    "Pictures",
    "captions_of",
    "comparison_picture",
    "drawings",
    "series_captions",
    "study_drawings",
    "suite_picture",
]

Pictures = dict[str, dict[str, bytes]]

_LONGEST = (
    *("fig5b-corrected", "rationality", "fig5a-corrected", "fig5b", "fig4-corrected", "courses", "fig5a", "fig3-by-p"),
    *("side-by-side", "fig3-corrected", "fig4", "people", "fig3", "overview", "overview-column"),
)
"""All figures, what takes longest to draw first: with one panel for each agent, those with the most marks."""


class Caption(NamedTuple):
    """What a figure shows and how it was computed, at most two sentences each, and further notes."""

    shown: str
    computed: str = ""
    more: str = ""


_FORKS = Caption(
    "Change of success by one report or action, by the step at which trials were forked. The line at 0 is a true "
    "report.",
    "Bars are 95 % intervals over trials, corrected for the number of agents alone.",
)

_BOX = Caption("The panel at the start and, below, the interlock, which no agent sees.")

_OVERVIEW = Caption(
    "Grey: between random agents with and without immediate repeats.",
    "Bars: 95 % intervals of single shares; changes are tested in pairs, so bars may overlap.",
)

CAPTIONS = {
    "overview": _OVERVIEW,
    "overview-column": _OVERVIEW,
    "box": _BOX,
    "forks": _FORKS,
    "people": Caption(
        "People, models and strategies on the same boxes: success by flip rate (top), and an agent's median steps "
        "divided by the human median (bottom). People play several boxes and may learn from one to the next; agents "
        "keep nothing.",
        "Bars are 95 % intervals, clustered by person and block for people; bars that reach the edge of the lower "
        "panel are open. Medians are over trials that both played, with unsolved ones censored at the budget.",
        "Baselines are thin with hollow markers and have no bars.",
    ),
    "side-by-side": Caption(
        "Differences between two agents on the same boxes with the same false reports, the first named minus the "
        "other; filled marks were detected. Top: success over all flip rates; bottom: change of success from the "
        "lowest flip rate to the one with the clearest difference.",
        "Bars are 95 % intervals clustered by block, at the bottom corrected for all flip rates. Tests are corrected "
        "for the number of pairs, at the bottom also for all flip rates.",
    ),
    "fig3": Caption(
        "The paper's Fig. 3: share of trials solved by each step at the lowest flip rate, one line per agent and "
        "modality.",
    ),
    "fig3-corrected": Caption(
        "Share of trials solved by each step, with the exact curves of random agents and of the shortest plan (top); "
        "area under each curve, from random (0) to the shortest plan (1) (bottom). Baselines are thin, with hollow "
        "markers and no band.",
        "Curves are one minus the Kaplan-Meier estimate, with pointwise 95 % bands.",
    ),
    "fig3-by-p": Caption(
        "Share of trials solved by each step, one line per flip rate. Bands are drawn for the lowest flip rate and "
        "for the one whose final success differs most from it.",
        "Curves are one minus the Kaplan-Meier estimate, with pointwise 95 % bands.",
        "Of more than eleven flip rates, only the two with bands and the highest are labelled.",
    ),
    "fig4": Caption(
        "The paper's Fig. 4: success by flip rate.",
        "Dots are repetitions (larger where several coincide), markers their means. The line is the second-order "
        "least-squares fit with its 95 % bootstrap band.",
    ),
    "fig4-corrected": Caption(
        "Success by flip rate, with the exact success of random agents. Triangles mark the 95 % set of the best flip "
        "rate; the diamond is the highest share, corrected for selection of the maximum.",
        "Intervals are 95 % Wilson intervals. The line is a binomial model of the order with the lowest AICc, with its "
        "95 % band.",
    ),
    "courses": Caption(
        "Share of trials solved (circles) and share with an action loop (squares) by flip rate, one panel per agent. "
        "The heading compares success with that at the lowest flip rate.",
        "Intervals are 95 % Wilson intervals.",
    ),
    "rationality": Caption(
        "Top: share of actions that are optimal for an ideal observer that believes reports (circles) and for one that "
        "doubts them (squares); bottom: expected steps lost per action. Dotted and dashed: random choices in the same "
        "situations.",
        "Intervals are 95 % intervals clustered by trial.",
    ),
    "fig5a": Caption(
        "The paper's Fig. 5a: share of trials with an action loop against success, one dot per repetition and flip "
        "rate, with the least-squares line and r.",
        LENGTH_CAVEAT,
    ),
    "fig5a-corrected": Caption(
        "Odds ratio of solving the box, after over before a loop. A ratio below one is no proof of harm: an agent that "
        "makes no progress both loops and fails.",
        "Trials still running at the same step (top) or after step 10 are compared. Over whole trials (hollow) the "
        "ratio can be far below one even if loops have no effect, because a solved trial ends before it can loop.",
        "An arrow at the edge is a ratio beyond the axis.",
    ),
    "fig5b": Caption(
        "The paper's Fig. 5b: share of trials with an action loop by flip rate, with the second-order fit.",
    ),
    "fig5b-corrected": Caption(
        "Loop rates with their chance levels in trials of the same lengths, and the share that has looped by each "
        "step. Grey: from random actions (dotted) to those without repeats (dashed); crosses: the agent's own "
        "transition probabilities; plus signs: its own actions in random order.",
        "Intervals of loop rates are 95 % Wilson intervals. The share by step is one minus the Kaplan-Meier estimate, "
        "censored at success, which assumes that solved trials would have looped like the others.",
    ),
}
"""The caption of every figure, by file name, without its stars."""

_STARS = {
    **dict.fromkeys(("overview", "overview-column"), "Stars: another model and box."),
    "fig3": (
        "Hollow stars: values in the paper's text, 80 % by step 9 (human-inspired), 11 (RGB) and 15 (ground truth)."
    ),
    "fig4": (
        "Hollow stars: values in the paper's text, 23.3 % at a flip rate of 0 and 2.85 times that, 20 of 30, at 0.4."
    ),
    "fig5b": (
        "Hollow stars: values in the paper's text, reconstructed as 24 of 30 at a flip rate of 0 (“approximately "
        "80 %”) and 16 of 30 at 0.4 (“a decrease of more than 26 %”, read as points)."
    ),
}
"""What the paper's values are, where a figure shows them."""

CONDITION_CAPTIONS = {
    "why": Caption(
        "Top: share of trials solved in each arm; the dotted line is the share with true reports. Bottom: the effect "
        "of false reports and its two parts, content and disturbance.",
        "Intervals are 95 %: Wilson intervals at the top; at the bottom over matched pairs of trials, corrected for "
        "the number of agents.",
    ),
    "effects": Caption(
        "Circles: success under each condition minus success under the control. Squares: interactions of two "
        "interventions; filled marks were detected.",
        "Bars are 95 % intervals over matched pairs of trials, corrected for the number of conditions (squares: of "
        "interactions) and of agents. A difference is detected if the test rejects and the interval excludes 0.",
    ),
    "grid": Caption(
        "Share of trials solved under every combination of two doses, with count and interval where there is room. "
        "Darker cells are higher, crossed cells were not played, and the interaction is in points.",
        "Intervals are 95 % Wilson intervals in per cent.",
    ),
}
"""The captions of what conditions beside flip rates add, by file name."""


def captions_of(drawn: Pictures) -> dict[str, Caption]:
    """The captions of figures as they were drawn: a figure without stars has none in its caption.

    Args:
        drawn: The figures; what is missing has no stars.
    """
    found = dict(CAPTIONS)
    for name, stars in _STARS.items():
        if b'id="paper"' in drawn.get(name, {}).get("svg", b""):
            found[name] = CAPTIONS[name]._replace(shown=f"{CAPTIONS[name].shown} {stars}")
    return found


def series_captions(dose: str) -> dict[str, Caption]:
    """The captions of the figures of success and of loops over one dose.

    Args:
        dose: What the dose is called.
    """
    return {
        "success": Caption(
            f"Share of trials solved by {dose}, with the exact success of random agents. Triangles mark the 95 % set "
            "of the best dose; the diamond is the highest share, corrected for selection of the maximum.",
            "Intervals are 95 % Wilson intervals. The line is a binomial model of the order with the lowest AICc.",
        ),
        "loops": Caption(
            f"Share of trials with an action loop by {dose}, with chance levels in trials of the same lengths.",
            "Intervals are 95 % Wilson intervals.",
        ),
    }


def study_drawings(numbers: StudyNumbers, box: Lockbox) -> dict[str, Callable[[], dict[str, bytes]]]:
    """Every figure of a study by name, as a function that draws it as PNG and SVG."""
    found, pictures = numbers.others, drawings(numbers.flips)
    if found is not None:
        pictures |= _condition_pictures(found.together, [summary for _, summary in found.series], found.whys)
    return pictures | {"box": partial(_draw_box, box)} | (_fork_pictures(numbers.forks) if numbers.forks else {})


def _fork_pictures(found: Sequence[BranchEffect]) -> dict[str, Callable[[], dict[str, bytes]]]:
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


def _condition_pictures(
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
