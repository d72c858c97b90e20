"""Speed: how fast the box is solved, between chance and the shortest plan, and what false reports change (Fig. 3)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from lockprobe.boxes.solve import optimum, random_curve
from lockprobe.foundation.formatting import p_cell, p_value
from lockprobe.report.format import beside, each_or_span, entry_text
from lockprobe.report.left_out import section
from lockprobe.report.opened import OpenedStudy
from lockprobe.report.prose import at_lowest, played_subjects
from lockprobe.report.rows import Course, Curve, Estimate, Results, Row, measured_row, who
from lockprobe.report.section import Figure, Lines, Note, Part, Section, Table
from lockprobe.statistics.how_soon import modality_effects, steps_over_doses, success_curve
from lockprobe.statistics.modalities import fidelity, spoken
from lockprobe.statistics.proportions import ALPHA
from lockprobe.statistics.published import REFERENCE_STEPS, STEPS_TO_80

_HIGHER = "higher"
"""Part of a difference: all higher doses together less the lowest."""

_MOST = 8
"""Agents that are drawn, those that the study is about first."""


def _rows(numbers: OpenedStudy) -> Iterator[Row]:
    for cell in numbers.cells:
        curve = success_curve(cell.outcomes)
        if not curve.n:
            continue
        band: dict[str, Any] = {"value": curve.share, "low": curve.low, "high": curve.high, "n": curve.n}
        steps: dict[str, Any] = {"unit": "steps", "n": curve.n}
        x = tuple(range(len(curve.share)))
        yield Curve(quantity="success_by_step", **cell.of, axis="step", x=x, **band)
        yield cell.estimate("steps_to_solve", curve.steps_to(0.5)[0], of="half", **steps)
        yield cell.estimate("mean_steps_all", curve.restricted_mean_steps, **steps)
        step, early, late = curve.steps_to(0.8)
        steps |= {"note": "" if late is not None else "open high" if early is not None else "not reached"}
        yield cell.estimate("steps_to_solve", step, low=early, high=late, of="80 %", **steps)
    yield from section("Curves of random agents and of the shortest plan", lambda: [*_exact(numbers)], list[Row])
    for course in numbers.every_course:  # all higher doses together against the lowest; the test holds for one look
        found = steps_over_doses(course.tested)
        if found.p_value is not None and course.order is None:
            of = course.of | {"of": _HIGHER, "unit": "steps", "test": "Student over blocks"}
            yield measured_row("steps_difference", found, **of)


def _exact(numbers: OpenedStudy) -> Iterator[Row]:
    """What random agents and the shortest plan reach on the box; their mean over several."""
    boxes = numbers.study.boxes
    budget = max((one.outcomes.budget for one in numbers.courses), default=0)
    for of, repeats in (("uniform", True), ("no-repeat", False)):
        share = tuple(np.mean([random_curve(box, budget, repeats=repeats) for box in boxes], axis=0).tolist())
        yield Curve(quantity="success_by_step", of=of, axis="step", x=tuple(range(len(share))), value=share)
        yield Estimate(quantity="success_by_step", of=of, value=share[-1], note="exact")
    if len(steps := {optimum(box) for box in boxes}) == 1 and (shortest := steps.pop()) is not None:
        yield Estimate(quantity="optimum", value=shortest, unit="steps", note="exact")


def _said(found: Results) -> str:
    """Mean steps beside those of the shortest plan, and what higher flip rates change."""
    means, shown = [], played_subjects(found)
    more = "at higher flip rates" if min(found.flip_rates, default=0.0) else "with false reports"
    for course in shown:
        said = f"{course.played[0].value('mean_steps_all'):.1f} for {course.label}"
        change = course.get("steps_difference", _HIGHER)
        means.append(f"{said}, {entry_text(change)} {more} ({p_value(change.p_value)})" if change else said)
    plan = found.get("optimum")
    least = f" (at best {plan.value:g}; an unsolved trial counts all its steps)" if plan else ""
    if not means:
        return "No trial has ended."
    over = sorted(course.played[0].value("mean_steps_all") or 0.0 for course in shown)
    said = each_or_span(means, f"{over[0]:.1f} to {over[-1]:.1f}", "; ")
    return f"Mean steps to open a box {at_lowest(found)}{least}: {said}."


def draw(found: Results) -> Any:
    """Success by step: a line an agent at its lowest flip rate."""
    from lockprobe.report.figures import drawing as figures

    def on(axes: Any, shown: Sequence[Course]) -> None:
        drawn = [(curve, one) for one in shown if (curve := one.played[0].curve("success_by_step"))]
        budget = max(len(curve.x) - 1 for curve, _ in drawn)
        for i, (curve, one) in enumerate(drawn):
            figures.staircase(axes, curve, figures.style_of(one), first=1 + i % 4, label=figures.agent_label(one))
        if chance := [[share or 0.0 for share in curve.value[: budget + 1]] for curve in found.random_play]:
            low, high = chance
            grey: dict[str, Any] = {"color": figures.FAINT, "alpha": 0.13, "linewidth": 0, "zorder": 0}
            axes.fill_between(range(budget + 1), low, high, step="post", label="chance level", **grey)
        if (plan := found.get("optimum")) is not None and plan.value is not None:
            label = f"shortest plan: {plan.value:g} steps"
            axes.axvline(plan.value, color=figures.INK, linewidth=0.7, linestyle=(0, (8, 3)), zorder=1, label=label)
        if {one.played[0].p for _, one in drawn} == {0.0}:  # told the truth, as the paper's agents were
            steps = sorted({REFERENCE_STEPS, *STEPS_TO_80.values()})
            figures.published(axes, [(step, 0.8) for step in steps if step <= budget])
        figures.share_axis(axes, "solved by this step")
        axes.set_xlim(0, budget + figures.BEYOND)
        figures.whole_axis(axes, budget, "number of interactions")
        figures.title(axes, f"{figures.counts(curve.n for curve, _ in drawn)}; shade: 95 % band")

    courses = sorted((course for course in found.courses() if course.played), key=lambda one: not one.subject)
    return figures.sheet([courses[:_MOST]] if courses else [], on, height=2.42)


def _caption(found: Results) -> Note:
    courses = [course for course in found.courses() if course.played]
    some = f"{_MOST} of {len(courses)} agents" if len(courses) > _MOST else "each agent and modality"
    broke = "; where trials broke, the middle of the bounds" * any(cell.value("broken") for cell in found.cells)
    stars = (
        "Hollow stars: values in the paper's text, 80 % by step 9 (human-inspired), 11 (RGB) and 15 (positions in "
        "words, its ground truth)."
    )
    return Note(
        f"The paper's Fig. 3: share of trials solved by each step, a line for {some} {at_lowest(found)}. Grey: the "
        "chance level, choices at random with and without immediate repeats, exact.",
        f"Curves are one minus the Kaplan-Meier estimate{broke}. Bands are pointwise 95 % intervals, whatever became "
        "of broken trials.",
        stars * ({course.played[0].p for course in courses} == {0.0}),
    )


FIG3 = Figure("fig3", "Success by step", _caption, draw, applies=lambda found: bool(played_subjects(found)))


def _show(found: Results) -> Iterator[Part]:
    yield Part("How soon?", _said(found), [FIG3])


# Modalities: whether what an agent is shown of the box changes how soon, and how often, it solves it.

_PAIRS = "every two modalities"


def _of_modalities(numbers: OpenedStudy) -> Iterator[Estimate]:
    for effect in modality_effects(numbers.courses):
        ranks = {fidelity(modality) for modality in effect.modalities} - {None}
        yield measured_row(
            "modality_effect", effect.trend, agent=effect.agent, of="trend over fidelity", value=effect.trend.direction,
            unit="direction", test="log-rank", corrected_for=effect.agents,
            note="" if len(ranks) > 1 else "equal fidelity",
        )  # fmt: skip
        tested: dict[str, Any] = {"family": _PAIRS, "corrected_for": len(effect.pairs) * effect.agents}
        for first, second, hazard, final, steps in effect.pairs:
            of: dict[str, Any] = {"agent": effect.agent, "modality": second}
            of |= {"versus": effect.agent, "versus_modality": first}
            yield measured_row("hazard_ratio", hazard, **of, of="modalities", unit="ratio", test="log-rank", **tested)
            yield measured_row("steps_difference", steps, **of, unit="steps", test="Student over blocks", **tested)
            if final is not None:
                of |= {"test": final.test, "n": final.first.n, "unit": "points"}
                yield measured_row("success_difference", final, **of, **tested)


def _modalities(found: Results) -> Lines:
    head = ["agent", "compared with", "mean steps of both", "steps", "hazard ratio of solving", "log-rank, Holm"]
    yield [*head, "success, points", "P"]
    means = {(row.agent, row.modality): row for row in reversed(found.where("mean_steps_all", of=""))}
    for row in found.where("hazard_ratio", of="modalities"):
        final = found.get("success_difference", **row.pair, family=_PAIRS)
        names = f"{row.agent} ({spoken(row.modality)})", spoken(row.versus_modality)
        own, other = (means.get((row.agent, one)) for one in (row.modality, row.versus_modality))
        both = f"{entry_text(own)} and {entry_text(other)}"
        steps = beside(found.get("steps_difference", **row.pair), other, own)
        yield [*names, both, steps, row, p_cell(row.p_value), final, p_cell(final.p_value if final else None)]


def effect_said(found: Results, row: Estimate) -> str:
    """The trend over fidelity; without one whether any two modalities differ."""
    solves = f"how soon the box is solved by {who(row.agent)}"
    pairs = [one.p_value for one in found.where("hazard_ratio", agent=row.agent, of="modalities")]
    if row.p_value is not None and row.p_value < ALPHA:
        how = "sooner" if (row.value or 0) > 0 else "later or more rarely"
        by = f"the box is solved by {who(row.agent)} ({p_value(row.p_value)})"
        return f"The higher the fidelity of what is shown, the {how} {by}."
    tested = [p for p in (row.p_value, *pairs) if p is not None]
    if any(p < ALPHA for p in tested):
        return f"The modality changes {solves}, in no order of fidelity."
    if not tested:
        return f"Too few trials ended to test whether the modality changes {solves}."
    said = "" if row.p_value is None else f" ({p_value(row.p_value)})"
    return f"No effect of the modality on {solves} was detected{said}."


_TABLE = Table("modalities", _modalities)

_MODALITIES = Note(
    "Steps: the first named minus the second; an unsolved trial counts all. A ratio above one: the first is faster. "
    "With 10 trials in each modality the power to detect the paper's "
    "trend is 13 % (95 % interval 12 to 14 %; simulated for agents that solve 80 % by steps 11, 13 and 15).",
    "Log-rank tests of the step that solves the box, clustered by block: trials of equal repetition and number use "
    "common random numbers in all modalities. Success is "
    "compared within the same pairs of trials. P values are corrected for the pairs and for the number of agents.",
)


def _show_modalities(found: Results) -> Iterator[Part]:
    if effects := found.where("modality_effect"):
        said = " ".join(effect_said(found, row) for row in effects[:2])
        yield Part("What does the modality change?", said, [_TABLE, _MODALITIES])


SECTIONS = (
    Section("speed", "Speed", _rows, _show, figures=(FIG3,)),
    Section("modalities", "Modalities", _of_modalities, _show_modalities, (_TABLE,)),
)
