"""Speed: how fast the box is solved, between chance and the optimum, and which agent or modality is faster."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from markupsafe import Markup

from lockprobe.foundation.formatting import NONE, p_cell
from lockprobe.report.format import TextTable
from lockprobe.report.prose.section_answers import NO_NUMBERS
from lockprobe.report.rows import Cell, Curve, Estimate, Results, Row
from lockprobe.report.section import Block, Caption, Detail, Figure, Heading, Note, Part, Section, Table
from lockprobe.report.study_numbers import PlayedCell, StudyNumbers
from lockprobe.report.table_rows import at_lowest, distinct, value_cell, varied
from lockprobe.statistics.conditions.modalities import ModalityEffect, spoken
from lockprobe.statistics.pace import Pace
from lockprobe.statistics.published import REFERENCE_STEPS, STEPS_TO_80

_PAIRS = "every two agents"
_MODALITIES = "every two modalities"


def _rows(numbers: StudyNumbers) -> Iterator[Row]:
    for cell in numbers.cells:
        yield from _of_cell(cell)
    yield from _references(numbers)
    for pace in numbers.flips.paces:
        yield from _pace(pace)
    for effect in numbers.flips.modalities:
        yield from _modalities(effect)
    yield from numbers.answer("speed", "relative_area")


def _of_cell(cell: PlayedCell) -> Iterator[Row]:
    curve = cell.summary.curve
    if not curve.n:
        return
    yield cell.curve(
        "success_by_step", axis="step", n=curve.n, x=curve.steps, value=curve.share, low=curve.low, high=curve.high
    )
    solved = len(curve.solved_at)
    yield cell.estimate("median_steps", curve.median_steps, unit="steps", n=solved)
    yield cell.estimate("mean_steps", curve.mean_steps, unit="steps", n=solved)
    yield cell.estimate("median_steps_all", curve.km_median, unit="steps", n=curve.n)
    yield cell.estimate("mean_steps_all", curve.restricted_mean_steps, unit="steps", n=curve.n)
    early, late = curve.steps_to_interval(0.8)
    open_end = "" if late is not None else "open high" if early is not None else "not reached"
    yield cell.estimate(
        "steps_to_80", curve.steps_to(0.8), low=early, high=late, unit="steps", n=curve.n, note=open_end
    )
    if area := curve.area:
        yield cell.estimate("area", area.value, low=area.low, high=area.high, n=curve.n)
    if relative := cell.summary.relative:
        yield cell.estimate("relative_area", relative.value, low=relative.low, high=relative.high, unit="ratio")


def _references(numbers: StudyNumbers) -> Iterator[Row]:
    """What random agents and the shortest plan reach on the box, exactly."""
    reference = numbers.flips.reference
    if reference is None:
        return
    for of, share in (("uniform", reference.random), ("no-repeat", reference.no_repeat)):
        yield Curve(quantity="success_by_step", of=of, axis="step", x=tuple(range(len(share))), value=share)
        yield Estimate(quantity="success_chance", of=of, value=share[-1], note="exact")
    if reference.optimum is not None:
        yield Estimate(quantity="optimum", value=reference.optimum, unit="steps", note="exact")


def _pace(pace: Pace) -> Iterator[Estimate]:
    """The second agent against the first, at the lowest flip rate."""
    found = {"": pace.p_value, "not clustered": pace.independent, "Gehan": pace.gehan}
    for of, p_value in found.items():
        yield Estimate(
            quantity="hazard_ratio",
            agent=pace.second[0],
            modality=pace.second[1],
            versus=pace.first[0],
            versus_modality=pace.first[1],
            of=of,
            doses={"flip.p": pace.dose},
            unit="ratio",
            value=pace.hazard_ratio,
            p_value=p_value,
            family=_PAIRS,
            test="Gehan-Wilcoxon" if of == "Gehan" else "log-rank",
        )


def _modalities(effect: ModalityEffect) -> Iterator[Estimate]:
    """One agent in every two of its modalities, and the trend over fidelity."""
    for pair in effect.pairs:
        of_pair: dict[str, Any] = {
            "agent": effect.agent,
            "modality": pair.second,
            "versus": effect.agent,
            "versus_modality": pair.first,
            "family": _MODALITIES,
        }
        for of, p_value, many in (("Holm", pair.p_adjusted, len(effect.pairs)), ("uncorrected", pair.p_value, 1)):
            yield Estimate(
                quantity="hazard_ratio_of_modalities",
                **of_pair,
                of=of,
                unit="ratio",
                value=pair.hazard_ratio,
                p_value=p_value,
                corrected_for=many * (effect.agents if many > 1 else 1),
                test="log-rank",
            )
        final = pair.final
        yield Estimate(
            quantity="success_difference",
            **of_pair,
            unit="points",
            n=final.n,
            value=final.value,
            low=final.low,
            high=final.high,
            p_value=final.p_value,
            test="McNemar",
        )
        for of, count in (("only", final.only_second), ("only the other", final.only_first)):
            yield Estimate(
                quantity="solved_by_one_only", **of_pair, of=of, unit="trials", n=final.n, value=count, count=count
            )
    for of, p_value in (("trend over fidelity", effect.p_value), ("any difference", effect.p_all)):
        yield Estimate(
            quantity="modality_effect",
            agent=effect.agent,
            of=of,
            unit="direction",
            value=effect.direction,
            p_value=p_value,
            corrected_for=effect.agents,
            test="log-rank",
            note="" if effect.differs_in_fidelity else "equal fidelity",
        )


def _speed_table(found: Results) -> TextTable:
    head = ["agent", varied(found.cells), "mean steps", "median step", "80 % by step", "relative area"]
    return [head] + [
        [
            cell.label,
            p,
            value_cell(cell.get("mean_steps_all"), "{:.1f}"),
            _step(cell.value("median_steps_all")),
            _by_step(cell),
            value_cell(cell.get("relative_area")),
        ]
        for cell, p in distinct(found.cells)
    ]


def _step(step: float | None) -> str:
    return NONE if step is None else f"{step:g}"


def _by_step(cell: Cell) -> str:
    row = cell.get("steps_to_80")
    if row is None or (row.value is None and row.low is None):
        return NONE
    return f"{_step(row.value)} [{_step(row.low)}, {_step(row.high)}]"


def _pace_table(found: Results) -> TextTable:
    """Every two agents at the same flip rate: who is faster."""
    head = ["agent", "compared with", "flip rate", "hazard ratio of solving", "log-rank", "log-rank, not clustered"]
    return [[*head, "Gehan"]] + [
        [
            found.label(row.agent, row.modality),
            found.label(row.versus, row.versus_modality),
            f"{row.doses['flip.p']:g}",
            NONE if row.value is None else f"{row.value:.2f}",
            *(p_cell(found.one("hazard_ratio", **row.pair, of=of).p_value) for of in ("", "not clustered", "Gehan")),
        ]
        for row in found.where("hazard_ratio", of="")
    ]


def _modality_table(found: Results) -> TextTable:
    """Every two modalities of each agent."""
    rows = found.where("hazard_ratio_of_modalities", of="Holm")
    if not rows:
        return []
    head = ["agent", "compared with", "hazard ratio of solving", "log-rank", "corrected (Holm)"]
    table = [[*head, "solved only with the first", "solved only with the second", "McNemar"]]
    for row in rows:
        pair = row.pair
        plain = found.one("hazard_ratio_of_modalities", **pair, of="uncorrected")
        alone = (found.one("solved_by_one_only", **pair, of=of) for of in ("only", "only the other"))
        table.append(
            [
                f"{row.agent} ({spoken(row.modality)})",
                spoken(row.versus_modality),
                NONE if row.value is None else f"{row.value:.2f}",
                *map(p_cell, (plain.p_value, row.p_value)),
                *(str(one.count) for one in alone),
                p_cell(found.one("success_difference", **pair, family=_MODALITIES).p_value),
            ]
        )
    return table


_SPEED = Table("speed", _speed_table)
_PACES = Table("paces", _pace_table)
_MODALITY = Table("modalities", _modality_table)


def _fig3_caption(found: Results) -> Caption:
    text = (
        f"The paper's Fig. 3: share of trials solved by each step {at_lowest(found)}, one line per agent and modality."
    )
    lowest = {one.agent: one.p for one in reversed(found.cells) if one.p is not None and one.trials}
    budget = max((len(one.x) - 1 for one in found.curves if one.quantity == "success_by_step" and one.agent), default=0)
    middle = _curves_said(found) * any(cell.value("broken") for cell in found.cells)
    if not set(lowest.values()) <= {0.0} or budget < min(REFERENCE_STEPS, *STEPS_TO_80.values()):
        return Caption(text, middle)
    stars = (
        "Hollow stars: values in the paper's text, 80 % by step 9 (human-inspired), 11 (RGB) and 15 (positions in "
        "words, its ground truth)."
    )
    return Caption(f"{text} {stars}", middle)


def _ended(found: Results) -> bool:
    """Whether a trial under a flip rate has ended."""
    return any(course.played for course in found.courses())


def _curves_said(found: Results) -> str:
    """What the curves and their bands are."""
    if any(cell.value("broken") for cell in found.cells):
        return (
            "Trials broke: a curve is the middle between all that broke by a step unsolved and all solved. Its "
            "pointwise 95 % band holds whatever became of them."
        )
    return "Curves are one minus the Kaplan-Meier estimate, with pointwise 95 % bands."


_FIG3 = Figure(
    "fig3",
    "Success by step, one line per agent, as in the paper",
    _fig3_caption,
    draw="lockprobe.report.figures.success_by_step:success_curves",
    applies=_ended,
)
_FIG3_CORRECTED = Figure(
    "fig3-corrected",
    "Success by step, with chance and the optimum",
    lambda found: Caption(
        "Share of trials solved by each step, with the exact curves of random agents and of the shortest plan; "
        "beside or below, the area under each curve, from random (0) to the shortest plan (1). Baselines are "
        "thin, with hollow markers and no band.",
        _curves_said(found),
    ),
    draw="lockprobe.report.figures.success_by_step:success_curves_corrected",
    applies=_ended,
)
_FIG3_BY_P = Figure(
    "fig3-by-p",
    "Success by step, one line per flip rate",
    lambda found: Caption(
        "Share of trials solved by each step, one line per flip rate. Bands are drawn for the lowest flip rate and "
        "for the one whose final success differs most from it.",
        _curves_said(found),
        "Of more than eleven flip rates, only the two with bands and the highest are labelled.",
    ),
    draw="lockprobe.report.figures.success_by_step:success_curves_by_p",
    applies=lambda found: found.several_p and _ended(found),
)


def _show(found: Results) -> Iterator[Part]:
    yield Part("Speed", found.answer_of("speed") or NO_NUMBERS, list(_blocks(found)))


def _blocks(found: Results) -> Iterator[Block]:
    yield _FIG3_CORRECTED
    note = Note(
        "Relative area: the area under the success curve, 0 for a uniformly random agent on this box, 1 for the "
        "shortest plan, which requires knowledge of the interlock.",
        "All trials count: in mean steps, an unsolved one with its whole budget; the median is the Kaplan-Meier "
        "estimate.",
    )
    yield Detail("The paper's Fig. 3, speed under every condition", [_FIG3, _FIG3_BY_P, _SPEED, note])
    effects = found.where("modality_effect", of="any difference")
    if found.where("hazard_ratio") and (effects or not found.where("played_by_one_only")):
        yield Detail(
            f"Speed of every pair of agents {at_lowest(found)}",
            [
                _PACES,
                Note(
                    "A ratio above one: the first named is faster.",
                    "Log-rank tests of the step that solves the box, clustered by block. Not corrected for the number "
                    "of pairs.",
                ),
            ],
        )
    if effects:
        yield Heading("Pairs of modalities")
        yield _MODALITY
        yield _modality_note(effects)


def _modality_note(effects: list[Estimate]) -> Note:
    many = max(row.corrected_for for row in effects) > 1
    fidelity = (
        "The paper's order, best with the lowest fidelity, is one trend and tested above; variants of a modality have "
        "equal fidelity. "
        if any(not row.note for row in effects)
        else ""
    )
    return Note(
        "A ratio above one: the first named is faster. With 10 trials in each modality the power to detect the paper's "
        "trend is 13 % (95 % interval 12 to 14 %).",
        "Log-rank tests of the step that solves the box, clustered by block"
        f"{' and, where corrected, for the number of agents too' if many else ''}: trials of equal repetition and "
        "number use common random numbers in all modalities. McNemar's test compares solved and unsolved trials in the "
        "same pairs.",
        Markup(
            "{}The 13 % are simulated for agents that solve 80 % of their trials by steps 11, 13 and 15, about as in "
            "the paper ( <code>benchmarks/modality_rates.py --lapses 0.12 0.2 0.3 --trials 10 --shared 0 --studies "
            "3000</code>)."
        ).format(fidelity),
    )


SECTIONS = (
    Section(
        name="speed",
        title="Speed",
        rows=_rows,
        show=_show,
        tables=(_SPEED, _PACES, _MODALITY),
        figures=(_FIG3, _FIG3_CORRECTED, _FIG3_BY_P),
    ),
)
