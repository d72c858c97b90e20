"""Action loops: how often they occur beside what chance gives, when they begin, and what follows them."""

from __future__ import annotations

from collections.abc import Iterator

from markupsafe import Markup

from lockprobe.foundation.formatting import percent
from lockprobe.report.captions import fit_said, paper_rates, share_intervals_said
from lockprobe.report.format import TextTable
from lockprobe.report.prose.loops import LOOP_DEFINITION
from lockprobe.report.prose.section_answers import NO_NUMBERS
from lockprobe.report.questions.course_rows import AgentCourse
from lockprobe.report.questions.loops_over_doses import loops_over_doses
from lockprobe.report.rows import Course, Estimate, Results, Row
from lockprobe.report.section import Block, Caption, Detail, Figure, Note, Part, Section, Table, Text
from lockprobe.report.study_numbers import PlayedCell, StudyNumbers
from lockprobe.report.table_rows import distinct, share_of_row, varied
from lockprobe.statistics.conditions.axis import FLIPS
from lockprobe.statistics.inference.association import LENGTH_CAVEAT
from lockprobe.statistics.published import PEAK

_NULLS = {
    "uniform": "uniform",
    "no-repeat": "without repeats",
}
"""The models of chance, and their columns."""


def _rows(numbers: StudyNumbers) -> Iterator[Row]:
    for cell in numbers.cells:
        yield from _of_cell(cell)
    for agent in numbers.flips.agents:
        yield from loops_over_doses(AgentCourse(agent, FLIPS.name, numbers.conditions))
    yield from numbers.answer("loops", "loop_rate", "loop_rate_chance")


def _of_cell(cell: PlayedCell) -> Iterator[Estimate]:
    found = cell.summary.behaviour
    yield from cell.share("loop_rate", found.loops)
    n = found.loops.n
    for null, level in found.chance.items():
        yield cell.estimate("loop_rate_chance", level.probability, of=null, n=n, note=level.method)
        yield cell.estimate("loop_rate_chance_error", level.error, of=null, n=n)
    means = {"coverage": found.coverage, "redundant_share": found.redundant_share}
    for quantity, mean in means.items():
        if mean is not None:
            yield cell.estimate(quantity, mean, n=n)
    if found.entropy is not None:
        yield cell.estimate("policy_entropy", found.entropy, unit="bits", n=found.entropy_steps)


def _loop_table(found: Results) -> TextTable:
    """Loop rates and their chance levels under two null models."""
    head = ["agent", varied(found.cells), "trials with a loop", *_NULLS.values()]
    return [head] + [
        [
            cell.label,
            p,
            share_of_row(cell.get("loop_rate")),
            *(percent(cell.value("loop_rate_chance", of), 0) for of in _NULLS),
        ]
        for cell, p in distinct(found.cells)
    ]


_LOOPS = Table("loops", _loop_table)


def _fig5b_caption(found: Results) -> Caption:
    shown = _shown(found)
    fit = ", with the second-order fit" if fit_said(shown, "loop_fit") else ""
    text = f"The paper's Fig. 5b: share of trials with an action loop by flip rate{fit}."
    drawn = {rate for course in shown for rate in paper_rates([course])}
    stars = " and ".join(said for rate, said in _STARS.items() if rate in drawn)
    return Caption(f"{text} Hollow stars: values in the paper's text, reconstructed as {stars}." if stars else text)


_STARS = {
    0.0: "24 of 30 at a flip rate of 0 (“approximately 80 %”)",
    PEAK: "16 of 30 at 0.4 (“a decrease of more than 26 %”, read as points)",
}
"""Flip rate -> the paper's value there."""


def _fig5a_caption(found: Results) -> Caption:
    lines = [course.value("loop_success_line", "slope") for course in _shown(found)]
    with_line = ", with the least-squares line and r" if any(slope is not None for slope in lines) else ""
    return Caption(
        "The paper's Fig. 5a: share of trials with an action loop against success, one dot per repetition and flip "
        f"rate{with_line}.",
        LENGTH_CAVEAT,
    )


def _fig5b_corrected_caption(found: Results) -> Caption:
    wilson = share_intervals_said((course.agent for course in _shown(found)), "Intervals of loop rates")
    onset = any(curve.quantity == "loop_onset" for curve in found.curves)  # none with a single flip rate
    share = ", and the share that has looped by each step" * onset
    by_step = (
        " The share by step is one minus the Kaplan-Meier estimate, censored at success, which assumes that solved "
        "trials would have looped like the others."
    )
    return Caption(
        f"Loop rates with their chance levels in trials of the same lengths{share}. Grey: from random actions (dotted) "
        "to those without repeats (dashed).",
        f"{wilson}{by_step * onset}",
    )


def _shown(found: Results) -> list[Course]:
    """The agents that the study is about, as far as they have an ended trial."""
    return [course for course in found.courses() if course.subject and course.played]


def _ended(found: Results) -> bool:
    """Whether a trial under a flip rate has ended."""
    return any(course.played for course in found.courses())


def _over_p(found: Results) -> bool:
    """Whether there is something to draw over flip rates."""
    return found.several_p and _ended(found)


_DRAWN = "lockprobe.report.figures.loops"
_FIG5A = Figure(
    "fig5a",
    "Loop rate against success, as in the paper",
    _fig5a_caption,
    f"{_DRAWN}:loops_against_success",
    _over_p,
)
_FIG5B = Figure(
    "fig5b",
    "Share of trials with an action loop by flip rate, as in the paper",
    _fig5b_caption,
    f"{_DRAWN}:loops_by_p",
    _over_p,
)
_FIG5B_CORRECTED = Figure(
    "fig5b-corrected",
    "Loop rates with their chance levels, and the onset of loops",
    _fig5b_corrected_caption,
    f"{_DRAWN}:loops_with_chance",
    _ended,
)


def _show(found: Results) -> Iterator[Part]:
    yield Part("Action loops", found.answer_of("loops") or NO_NUMBERS, list(_blocks(found)))


def _blocks(found: Results) -> Iterator[Block]:
    by_itself = Markup("{} A loop is no fault by itself: <code>round-robin</code> loops by design.")
    yield Text(by_itself.format(LOOP_DEFINITION), "lead")
    yield _FIG5B_CORRECTED
    if _over_p(found):
        yield Detail("The paper's Figs. 5a and 5b", [_FIG5B, _FIG5A])
    note = Note(
        "Chance levels: loop rates expected in trials of the same lengths. They use uniformly random actions, or "
        "actions without immediate repeats.",
    )
    yield Detail("Loops and chance levels under every condition", [_LOOPS, note])


SECTIONS = (
    Section(
        name="loops",
        title="Action loops",
        rows=_rows,
        show=_show,
        tables=(_LOOPS,),
        figures=(_FIG5A, _FIG5B, _FIG5B_CORRECTED),
    ),
)
