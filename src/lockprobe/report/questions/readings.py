"""What a false report is: what is inverted, what becomes of it, how often it was false, and what that changes."""

from __future__ import annotations

from collections.abc import Iterator

from markupsafe import Markup

from lockprobe.foundation.formatting import capital, listed, percent
from lockprobe.foundation.grouping import grouped
from lockprobe.foundation.spec import Spec
from lockprobe.interventions.conditions import tells_positions
from lockprobe.report.captions import interval_kind
from lockprobe.report.format import TextTable
from lockprobe.report.prose.readings import BOTH_FIT, false_reports, inverted, reading_name, untested_said
from lockprobe.report.prose.subject import Subject
from lockprobe.report.questions.effects import compared_rows, compared_table
from lockprobe.report.rows import Estimate, Finding, Results, Row
from lockprobe.report.section import Block, Caption, Detail, Figure, Note, Part, Section, Table, Text
from lockprobe.report.study_numbers import StudyNumbers
from lockprobe.report.table_rows import points_cell, share_of_row
from lockprobe.statistics.conditions.factors import READING_FACTORS
from lockprobe.statistics.conditions.no_feedback import NO_FEEDBACK
from lockprobe.trial.condition import Condition

_NAME = "readings"


def _rows(numbers: StudyNumbers) -> Iterator[Row]:
    study = numbers.study
    positions = any(map(tells_positions, study.modalities))
    if not any(study.p) or not positions:
        return
    said = f"The flip rate is the probability that {inverted(study.flip, positions=positions)}."
    yield Finding(section=_NAME, kind="what", text=said, judges=False)
    for one in numbers.others.against_none if numbers.others else ():
        yield from compared_rows(one, numbers.conditions)
    if said := untested(numbers):
        yield Finding(section=_NAME, kind="untested", text=said, judges=False)


def untested(numbers: StudyNumbers) -> str:
    """That agents were played with only false reports that are soon corrected, and what the others would take."""
    study, rates = numbers.study, sum(rate > 0 for rate in numbers.study.p)
    crossed = bool(numbers.others and numbers.others.whys)  # a study of controls has one reading: the other is a study
    rates, how = (len(study.conditions), "--flip integrated") if crossed else (rates, "--readings fresh,kept")
    heeding = {one.agent for one in numbers.flips.subjects if not one.blind}
    asked = [agent for agent in study.run_agents if study.label_of(agent) in heeding]
    alone = [agent for agent in asked if not any(map(_stays, study.conditions_of(agent)))]
    if study.flip.keep or not rates or not any(map(tells_positions, study.modalities)):
        return ""
    more = [rates * study.repetitions * study.trials_of(agent) for agent in alone]
    return untested_said([Subject.of(study.label_of(agent)).name for agent in alone], how, sum(more))


def _stays(condition: Condition) -> bool:
    """Whether false positions survive reports under a condition."""
    return condition.doses.get("flip.keep", 0.0) > 0


def _compared(found: Results) -> list[Estimate]:
    """Success under one reading minus success under another at the same flip rate."""
    return [row for row in found.where("success_difference", of="") if row.axis in READING_FACTORS and not row.versus]


def _against_none(found: Results) -> list[Estimate]:
    """Success with false reports minus success without any report."""
    return found.where("success_difference", of="", axis=NO_FEEDBACK)


def _against_none_said(found: Results) -> Iterator[str]:
    """Whether false reports are worse than none, for each agent that the study is about."""
    for agent, rows in grouped(_against_none(found), lambda row: row.agent).items():
        if agent not in found.subjects:
            continue
        better, worse = (
            [
                f"{row.condition} ({points_cell(row)} points)"
                for row in rows
                if row.detected and sign * (row.value or 0.0) > 0
            ]
            for sign in (1, -1)
        )
        open_ = [row.condition for row in rows if not row.detected]
        said = [
            f"{what} with {listed(those)}"
            for what, those in (("more", better), ("fewer", worse), ("no difference detected", open_))
            if those
        ]
        yield f"Trials that {Subject.of(agent).name} solved, against no feedback at all: {'; '.join(said)}."


def _answer(found: Results) -> str:
    rows, kind = _compared(found), found.design.flip_kind
    if not rows:
        alone = len({options for _, options in found.readings}) < 2
        return f"One kind was played: {kind}." if kind and alone else ""
    detected = [row for row in rows if row.detected and row.agent in found.subjects]
    counted = f"{sum(row.detected for row in rows)} of {len(rows)} differences between readings were detected."
    if not detected:
        return counted
    clearest = max(detected, key=lambda row: abs(row.value or 0.0))
    return f"{capital(_difference(found, clearest))}."


def _words(found: Results, condition: str) -> str:
    """The false reports of a condition, or its name if it is more than a flip."""
    specs = next((one.specs for one in found.design.conditions if one.name == condition), ())
    acts = [Spec.parse(spec, "condition") for spec in specs]
    if [one.kind for one in acts] != ["flip"]:
        return condition
    return false_reports("&".join(f"{name}={value}" for name, value in acts[0].without(["p"]).options.items()))


def _difference(found: Results, row: Estimate) -> str:
    doses = {one.name: one.doses.get("flip.p", 0.0) for one in found.design.conditions}
    kept, fresh = (_words(found, name) for name in (row.condition, row.control))
    if kept == f"{fresh} that stay":
        fresh += " that are corrected"
    more = "more" if (row.value or 0.0) > 0 else "fewer"
    return (
        f"at a flip rate of {doses[row.condition]:g} {Subject.of(row.agent).name} solved {more} trials with {kept} "
        f"than with {fresh} ({points_cell(row)} points)"
    )


def _shares(found: Results) -> TextTable:
    """How often reports were false, and success, under every reading and flip rate."""
    head = ["agent", "what a false report is", "flip rate", "trials", "false outcomes", "reports with a false position"]
    table = [[*head, "success"]]
    for axis, options in found.readings:
        for course in found.courses(axis):
            table += [
                [
                    course.label, reading_name(options), f"{cell.dose:g}", str(cell.trials),
                    percent(cell.value("false_report", "steps"), 1), percent(cell.value("false_positions"), 1),
                    share_of_row(cell.get("success")),
                ]
                for cell in course.played
                if cell.dose
            ]  # fmt: skip
    table[1:] = sorted(table[1:], key=lambda row: list(dict.fromkeys(one[0] for one in table)).index(row[0]))
    return table if len(table) > 1 and found.said(_NAME, "what") else []


def _none_table(found: Results) -> TextTable:
    rows = _against_none(found)
    return compared_table(found, rows) if rows else []


def _compared_table(found: Results) -> TextTable:
    rows = _compared(found)
    return compared_table(found, rows) if rows else []


_SHARES = Table("readings", _shares, numeric_from=2)
_COMPARED = Table("readings-compared", _compared_table)
_NONE = Table("against-no-feedback", _none_table)


def _caption(found: Results) -> Caption:
    bars = interval_kind(found.progress.every_look)
    return Caption(
        "Share of trials solved by flip rate, a line for each reading of a false report. Below: share of outcomes that "
        "were reported falsely, and of reports that showed a joint in a false position.",
        f"Bars are 95 % {bars}. The flip rate is the assigned dose; how many outcomes and positions are false depends "
        "on the reading and on what the agent does.",
    )


_FIGURE = Figure(
    "readings",
    "Success by flip rate under each reading of a false report, with the share of reports that were false",
    _caption,
    draw="lockprobe.report.figures.readings:readings",
)


def _show(found: Results) -> Iterator[Part]:
    what = found.said(_NAME, "what")
    if what:
        yield Part("What a false report is", _answer(found), list(_blocks(found, what)), _NAME)


def _blocks(found: Results, what: list[str]) -> Iterator[Block]:
    compared = _compared(found)
    said = [*what, *([BOTH_FIT] if compared else []), *found.said(_NAME, "untested")]
    said += _against_none_said(found)
    for text in said:
        yield Text(text)
    if len(found.readings) > 1:
        yield _FIGURE
    numbers: list[Block] = [_SHARES]
    if compared:
        numbers += [
            _COMPARED,
            Note(
                "Success under one reading minus success under another at the same flip rate: the difference between "
                "their effects, since both are compared with the same true reports.",
                Markup(
                    "Trials of equal repetition and number use common random numbers and are compared in pairs. "
                    "<i>P</i> is the larger of McNemar's exact one and that of the interval, corrected for all flip "
                    "rates and for the agents (baselines apart)."
                ),
            ),
        ]
    if _against_none(found):
        note = Note(
            "Success with false reports minus success without any report. A positive difference: false reports are "
            "better than none. Strategies that ship learn from reports alone what they have tried: without any, "
            "round-robin and human-inspired repeat one joint.",
            Markup("Compared and tested as above; the contrasts with no feedback are a family of their own."),
        )
        numbers += [_NONE, note]
    if _shares(found):
        yield Detail("False reports and comparisons, in numbers", numbers)


SECTIONS = (
    Section(
        name=_NAME,
        title="What a false report is",
        rows=_rows,
        show=_show,
        tables=(_SHARES, _COMPARED, _NONE),
        figures=(_FIGURE,),
    ),
)
