"""Success and false reports: how success depends on the flip rate, agent by agent."""

from __future__ import annotations

from collections.abc import Iterator

from markupsafe import Markup

from lockprobe.foundation.formatting import NONE, listed, minus, p_cell, percent, points
from lockprobe.report.captions import (
    fit_said,
    model_said,
    paper_rates,
    share_intervals_said,
)
from lockprobe.report.every_look import note_at
from lockprobe.report.format import DETECTED
from lockprobe.report.prose.subject import Subject
from lockprobe.report.questions.course_rows import AgentCourse, at, course_rows
from lockprobe.report.rows import Course, Estimate, Results, Row
from lockprobe.report.rows.primary import CONTROL
from lockprobe.report.section import (
    Block,
    Caption,
    Detail,
    Figure,
    Note,
    Part,
    Section,
    Template,
)
from lockprobe.report.study_numbers import BOUNDS, StudyNumbers
from lockprobe.report.table_rows import count_of, points_cell
from lockprobe.statistics.conditions.axis import FLIPS
from lockprobe.statistics.proportions import ALPHA
from lockprobe.statistics.published import PEAK


def _rows(numbers: StudyNumbers) -> Iterator[Row]:
    for agent in numbers.flips.agents:
        yield from course_rows(AgentCourse(agent, FLIPS.name, numbers.conditions), numbers.flips.reference)


_STARS = {0.0: "23.3 % at a flip rate of 0", PEAK: "20 of 30 at 0.4, 2.85 times the success at 0"}
"""Flip rate -> the paper's value there."""


def _fig4_caption(found: Results) -> Caption:
    stars = " and ".join(_STARS[rate] for rate in paper_rates(found.courses()))
    values = f" Hollow stars: values in the paper's text, {stars}." if stars else ""
    fit = fit_said(_subjects(found), "success_fit")
    return Caption(
        f"The paper's Fig. 4: success by flip rate.{values}",
        "Dots are repetitions (larger where several coincide), markers their means."
        f"{f' The line is the {fit}.' if fit else ''}",
    )


def _corrected_caption(found: Results) -> Caption:
    subjects = _subjects(found)
    of_success = share_intervals_said((course.agent for course in subjects), every_look=bool(found.progress.every_look))
    return Caption(
        "Success by flip rate, with the exact success of random agents.",
        f"{of_success} {model_said(subjects)}".strip(),
    )


def _subjects(found: Results) -> list[Course]:
    return [course for course in found.courses() if course.subject]


_DRAWN = "lockprobe.report.figures.success_by_flip_rate"
_FIG4 = Figure(
    "fig4",
    "Success rate by flip rate, as in the paper",
    _fig4_caption,
    f"{_DRAWN}:fig4",
    applies=lambda found: found.several_p,
)
_FIG4_CORRECTED = Figure(
    "fig4-corrected",
    "Success rate by flip rate, with intervals and chance levels",
    _corrected_caption,
    f"{_DRAWN}:fig4_corrected",
    applies=lambda found: found.several_p,
)


def _show(found: Results) -> Iterator[Part]:
    if found.several_p:
        rates = listed([f"{p:g}" for p in found.flip_rates])
        said = f"Shares of trials solved at flip rates of {rates}."
        yield Part("Success and false reports", said, list(_blocks(found)))


def _blocks(found: Results) -> Iterator[Block]:
    judged = [course for course in found.courses() if course.subject]
    fits = [(_name(course), _fit_said(course)) for course in judged]
    yield _FIG4_CORRECTED
    if rows := list(_contrast_rows(found)):
        yield Detail(
            "The clearest difference of each agent, tested",
            [Template("contrasts", {"rows": rows}), note_at(found, _CONTRAST_NOTE)],
        )
    yield Detail("The paper's Fig. 4 and orders of fits", [_FIG4, *_of_agents(fits)])


def _name(course: Course) -> str:
    return Subject.of(course.agent, course.shown).name


def _of_agents(said: list[tuple[str, str]]) -> tuple[Block, ...]:
    """A sentence on each agent; nothing without agents."""
    return (Template("of_agents", {"said": said}),) if said else ()


def _fit_said(course: Course) -> str:
    """The orders that the paper's criteria prefer, and where the second-order fit turns; or why there is no fit."""
    if course.blind:
        return "no fit, its trials are the same at every flip rate."
    aic, cv = (course.value("success_fit_order", of) for of in ("AIC", "cross-validation"))
    if aic is None or cv is None:
        return course.found.fact("success_fit", f"{course.label}, {course.axis}")
    said = f"AIC prefers order {aic:g}, cross-validation order {cv:g}."
    for row in course.where("success_fit_turning"):
        share = course.value("success_fit_turning_share", row.of)
        alike = f" ({percent(share)} of resamples turn the same way within the range)" if share is not None else ""
        said += f" The second-order fit has its {row.of} at a flip rate of {row.value:.2f}{alike}."
    if (order := course.value("success_model_order", "AICc")) is not None:
        said += f" AICc of the binomial model prefers order {order:g}."
    return said


def _contrast_rows(found: Results) -> Iterator[dict[str, object]]:
    """The cells of the clearest difference of each agent, and its bounds if trials broke."""
    for course in found.courses():
        if (row := course.get("clearest_success_difference")) is None:
            continue
        dose = course.value("clearest_dose") or 0.0
        first, second = (_at_dose(course, "success_in_pairs", dose, of) for of in (CONTROL, ""))
        alone = [_at_dose(course, "solved_at_one_only", dose, of) for of in (CONTROL, "")]
        tests = _at_dose(course, "success_difference", dose, "McNemar"), course.get(row.quantity, "Fisher")
        yield {
            "label": course.label,
            "compared": _compared(course, row, dose),
            "cells": [
                count_of(first),
                count_of(second),
                points_cell(row),
                p_cell(row.p_value),
                DETECTED[row.p_value is not None and row.p_value < ALPHA],
                *(str(one.count) if one else NONE for one in alone),
                *(p_cell(one.p_value if one else None) for one in tests),
            ],
            "broken": _if_broken(course, dose),
        }


def _at_dose(course: Course, quantity: str, dose: float, of: str) -> Estimate | None:
    """A number that compares a dose with the lowest."""
    names = {cell.condition for cell in course.cells if cell.dose == dose}
    return next((row for row in course.against_lowest(quantity, of) if row.condition in names), None)


def _compared(course: Course, row: Estimate, dose: float) -> str:
    """The two flip rates, out of how many they were chosen, and of which trials."""
    rates = [course.value("lowest_dose") or 0.0, dose]
    said = " and ".join(f"{rate:g}" for rate in rates)
    others = [abs(one.value or 0.0) for one in course.against_lowest("success_difference")]
    if len(others) > 1:
        said += f", the {'farthest' if abs(row.value or 0.0) >= max(others) - 1e-9 else 'clearest'} of {len(others)}"
    compared = [_at_dose(course, "success_in_pairs", dose, of) for of in (CONTROL, "")]
    whole = [one.n if one else 0 for one in compared] == [course.value("trials_at_dose", at(rate)) for rate in rates]
    return said if whole else f"{said}, trials finished at both"


def _if_broken(course: Course, dose: float) -> str:
    """What the difference is at least and at most, whatever became of the broken trials; empty if none broke."""
    said = [points(one.value or 0.0) for end in BOUNDS if (one := _at_dose(course, "success_difference", dose, end))]
    if len(said) < len(BOUNDS):
        return ""
    return minus(
        f"Trials broke: in all begun pairs the difference is between {said[0]} and {said[1]} points, whatever became "
        "of them. Interval and corrected P value hold at both ends; P is 1 if the signs differ."
    )


_CONTRAST_NOTE = Note(
    Markup(
        "Success at two flip rates, in the trials finished at both (for people, in all trials). <em>Detected</em>: the "
        "corrected <i>P</i> is below 0.05; <em>not detected</em> does not show that there is no difference."
    ),
    Markup(
        "The corrected <i>P</i> is the larger of two: that of a permutation of flip rates within blocks, corrected for "
        "all flip rates and for the agents, and that of the interval, corrected alike. McNemar's exact test and "
        "Fisher's, which assumes independent conditions, are not corrected."
    ),
    "A trial uses the same random numbers (labels, flips, draws) at every flip rate; a block is one repetition and "
    "trial. The difference, its interval and its P values use the same sample.",
)

SECTIONS = (
    Section(
        name="success",
        title="Success and false reports",
        rows=_rows,
        show=_show,
        figures=(_FIG4, _FIG4_CORRECTED),
    ),
)
