"""The paper's claims: each beside what the study measured of it, with a verdict."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from typing import Any

from lockprobe.foundation.formatting import bracketed, p_cell
from lockprobe.report.claims.claim_tests import ClaimFinding
from lockprobe.report.claims.paper import CLAIMS, PaperClaim
from lockprobe.report.claims.verdicts import claim_rows
from lockprobe.report.format import TextTable
from lockprobe.report.prose.readings import false_reports
from lockprobe.report.rows import Estimate, Finding, Results, Row
from lockprobe.report.section import Listed, Note, Part, Section, Table, Text
from lockprobe.report.study_numbers import StudyNumbers
from lockprobe.statistics.conditions.axis import axis_key
from lockprobe.statistics.conditions.factors import READING_FACTORS
from lockprobe.statistics.summary import StudySummary

NOT_JUDGED = "not judged"
"""What stands in place of a verdict where attempts broke the rules of the box."""

_TITLE = "The paper's claims"

_UNMEASURED = "not measured"
"""The verdict on a claim that no agent of the study speaks to; it has no row."""

_LONGEST = 125
"""Characters of a quotation that stand in a heading."""


def _rows(numbers: StudyNumbers) -> Iterator[Row]:
    """The verdicts; a claim about several modalities names none. The words of the paper ship with the package."""
    first = dict[tuple[str, str], ClaimFinding]()
    for axis, summary in _readings(numbers):
        modalities = {one.name: (one.agent, one.modality) for one in summary.agents}
        for claim, name, found in claim_rows(summary):
            agent, modality = modalities.get(name, (name, ""))
            if not name or (first.setdefault((claim.name, agent), found) == found and axis):
                continue  # of another reading only what differs
            yield from _of_claim(numbers, claim, found, {"agent": agent, "modality": modality, "axis": axis})
    yield from _of_reading(numbers)


def _readings(numbers: StudyNumbers) -> Iterator[tuple[str, StudySummary]]:
    """The numbers over flip rates under each reading of a false report; the first one without the name of its axis."""
    yield "", numbers.flips
    for number, series, summary in numbers.series:
        if (axis := series.axis).of_flips:
            yield axis_key(axis.name, axis.options, axis.rest, number), summary


def _of_claim(
    numbers: StudyNumbers, claim: PaperClaim, found: ClaimFinding, of: Mapping[str, Any]
) -> Iterator[Estimate | Finding]:
    """A verdict and its words."""
    here, verdict, test, p_value = found
    not_judged = numbers.not_judged
    yield Estimate(
        quantity="claim",
        of=claim.name,
        unit="verdict",
        p_value=None if not_judged else p_value,
        test=not_judged or test,
        note=NOT_JUDGED if not_judged else verdict,
        **of,
    )
    # a number in words, which stays where nobody is judged
    about = {name: of[name] for name in ("agent", "modality")} | {"kind": _kind(claim.name, of["axis"])}
    yield Finding(section="claims", **about, text=here, rests_on=("claim",), judges=False)


def _kind(claim: str, axis: str) -> str:
    return f"{claim}; {axis}" if axis else claim


def _of_reading(numbers: StudyNumbers) -> Iterator[Estimate | Finding]:
    """Whether what a false report is makes a difference here, for each agent that was told several kinds."""
    (claim,) = (one for one in CLAIMS if one.measure == "reading")
    effects = [one for one in (numbers.others.on_factors if numbers.others else ()) if one.axis in READING_FACTORS]
    for agent in dict.fromkeys(one.agent for one in effects if one.agent in numbers.subjects):
        own = [(one, each) for one in effects if one.agent == agent for each in one.effects]
        found_in, clearest = min(own, key=lambda both: (both[1].difference.p_value, -abs(both[1].difference.value)))
        gap, modality = clearest.difference, found_in.modality
        detected = sum(each.detectable for _, each in own)
        here = (
            f"{detected} of {len(own)} differences between readings were detected; the clearest: {clearest.condition} "
            f"minus {found_in.control} "
            f"{bracketed(gap.value, gap.low, gap.high)} points"
        )
        found: ClaimFinding = (here, "not decided", "McNemar, and interval", gap.p_value)
        yield from _of_claim(numbers, claim, found, {"agent": agent, "modality": modality, "axis": ""})


def _measured(found: Results) -> Iterator[tuple[PaperClaim, list[Estimate]]]:
    """Every claim with its rows; none if the rows could not be made."""
    if all(one.section != _TITLE for one in found.sections_left_out):
        yield from ((claim, found.where("claim", of=claim.name)) for claim in CLAIMS)


def _here(found: Results, row: Estimate) -> str:
    return found.said("claims", _kind(row.of, row.axis), agent=row.agent, modality=row.modality)[0]


def _label(found: Results, row: Estimate) -> str:
    """The agent, and the reading of a false report if it is not the first."""
    reading = next((false_reports(options) for axis, options in found.readings if axis.key == row.axis), "")
    return found.label(row.agent, row.modality) + f", {reading}" * bool(reading)


def _table(found: Results) -> TextTable:
    head = ["place", "quote", "paper", "reanalysis", "agent", "this study", "verdict", "test", "P"]
    table = [head]
    for claim, rows in _measured(found):
        paper = [claim.place, claim.quote, claim.value, claim.recomputed]
        for row in rows:
            here = [_label(found, row), _here(found, row), row.note, row.test, p_cell(row.p_value)]
            table.append([*paper, *here])
        if not rows:
            table.append([*paper, "", "", _UNMEASURED, "", p_cell(None)])
    return table


def _show(found: Results) -> Iterator[Part]:
    counts = Counter(row.note for _, rows in _measured(found) for row in rows)
    said = ", ".join(f"{n} {verdict}" for verdict, n in counts.most_common())
    unjudged = Text(found.not_judged) if found.not_judged else None
    notes = [one for one in (unjudged, _VERDICTS, _CLAIMS, _NOTE) if one]
    yield Part(_TITLE, f"Of {counts.total()} comparisons with its statements: {said}." if counts else "", notes)


_CLAIMS = Table("claims", _table, numeric_from=7)

_NOTE = Note(
    "Quoted from Probing Embodied LLMs: When Higher Observation Fidelity Hurts Problem Solving, with a reanalysis of "
    "its counts. A verdict concerns the whole statement, not one of its numbers.",
    "The paper used other agents, another box and another prompt: agreement or disagreement of single numbers is not a "
    "replication. Each test is at the 5 % level, not corrected for the number of statements.",
)

_VERDICTS = Listed(
    (
        (
            "Compatible: no difference from the paper's value was detected, which may only mean that there are few "
            "trials, and the study shows the pattern that the statement describes, if it describes one."
        ),
        "Borne out: the study shows the pattern of a statement without a value.",
        "Not compatible: the study contradicts its value or pattern.",
        "Not decided: the study neither shows nor contradicts it. This is no evidence against it.",
    )
)


SECTIONS = (Section(name="claims", title=_TITLE, rows=_rows, show=_show, tables=(_CLAIMS,)),)
