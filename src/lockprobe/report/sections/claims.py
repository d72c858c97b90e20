"""The paper's claims: each beside what the study measured of it, with a verdict."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence

from lockprobe.formatting import p_cell
from lockprobe.report.claims import claim_rows
from lockprobe.report.format import TextTable
from lockprobe.report.pages import NOT_JUDGED
from lockprobe.report.paper import CLAIMS, PaperClaim
from lockprobe.report.section import Part, Section, Table, Template
from lockprobe.report.study_numbers import StudyNumbers
from lockprobe.rows import Estimate, Finding, Results, Row

__all__ = ["SECTIONS"]

_TITLE = "The paper's claims"

_UNMEASURED = "not measured"
"""The verdict on a claim that no agent of the study speaks to; it has no row."""

_LONGEST = 125
"""Characters of a quotation that stand in a heading."""


def _rows(numbers: StudyNumbers) -> Iterator[Row]:
    """The verdicts; a claim about several modalities names none. The words of the paper ship with the package."""
    modalities = {one.name: (one.agent, one.modality) for one in numbers.flips.agents}
    not_judged = numbers.not_judged
    for claim, name, (here, verdict, test, p_value) in claim_rows(numbers.flips):
        if not name:
            continue
        agent, modality = modalities.get(name, (name, ""))
        yield Estimate(
            quantity="claim",
            agent=agent,
            modality=modality,
            of=claim.name,
            unit="verdict",
            p_value=p_value,
            test=not_judged or test,
            note=NOT_JUDGED if not_judged else verdict,
        )
        # a number in words, which stays where nobody is judged
        of = {"section": "claims", "kind": claim.name, "agent": agent, "modality": modality}
        yield Finding(**of, text=here, rests_on=("claim",), judges=False)


def _measured(found: Results) -> Iterator[tuple[PaperClaim, list[Estimate]]]:
    """Every claim with its rows; none if the rows could not be made."""
    if all(one.section != _TITLE for one in found.sections_left_out):
        yield from ((claim, found.where("claim", of=claim.name)) for claim in CLAIMS)


def _here(found: Results, row: Estimate) -> str:
    return found.said("claims", row.of, agent=row.agent, modality=row.modality)[0]


def _table(found: Results) -> TextTable:
    head = ["place", "quote", "paper", "reanalysis", "agent", "this study", "verdict", "test", "P"]
    table = [head]
    for claim, rows in _measured(found):
        paper = [claim.place, claim.quote, claim.value, claim.recomputed]
        for row in rows:
            here = [found.label(row.agent, row.modality), _here(found, row), row.note, row.test, p_cell(row.p_value)]
            table.append([*paper, *here])
        if not rows:
            table.append([*paper, "", "", _UNMEASURED, "", p_cell(None)])
    return table


def _show(found: Results) -> Iterator[Part]:
    for i, (claim, rows) in enumerate(_measured(found), 1):
        here = [(found.label(row.agent, row.modality), _here(found, row), row) for row in rows]
        block = Template("claim", {"claim": claim, "here": here})
        yield Part(_verdicts(rows), f"{_quotation(claim)} ({claim.place})", [block], name=f"claim-{i}")


def _verdicts(rows: Sequence[Estimate]) -> str:
    """The verdicts on a claim, with the number of agents where it has several rows."""
    if len(rows) < 2:
        return (rows[0].note if rows else _UNMEASURED).capitalize()
    counts = Counter(row.note for row in rows)
    return ", ".join(f"{verdict} ({count})" for verdict, count in sorted(counts.items())).capitalize()


def _quotation(claim: PaperClaim) -> str:
    if not claim.quoted:
        return claim.quote
    whole = len(claim.quote) <= _LONGEST
    return f"“{claim.quote if whole else claim.quote[: _LONGEST - 8].rsplit(' ', 1)[0] + '...'}”"


SECTIONS = (
    Section(name="claims", title=_TITLE, rows=_rows, show=_show, tables=(Table("claims", _table),), page="claims"),
)
