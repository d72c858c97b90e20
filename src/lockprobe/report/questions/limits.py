"""Limits: what the numbers of a report do not show."""

from __future__ import annotations

from collections.abc import Iterator

from lockprobe.report.questions.boxes import boxes_said
from lockprobe.report.questions.loops import LENGTHS
from lockprobe.report.rows import Results
from lockprobe.report.section import Part, Section, Template

_ANSWER = "An effect that was not detected may be there."


def _show(found: Results) -> Iterator[Part]:
    errors = any(row.value for row in found.where("left_out", of="ended as error"))
    answer = " ".join([_ANSWER, *_reconstructed(found)])
    yield Part(
        "Limits", answer, [Template("limits", {"caveat": LENGTHS, "errors": errors, "boxes": boxes_said(found)})]
    )


def _reconstructed(found: Results) -> Iterator[str]:
    """What the answer says of parts of the study that stand for those of the paper, which are not public."""
    box = any(one.get("name") == "chain-4" for one in found.boxes)
    strategy = bool(found.facts_about("design"))
    if box and strategy:
        yield "The box and the human-inspired strategy are reconstructions."
    elif box or strategy:
        yield f"The {'box' if box else 'human-inspired strategy'} is a reconstruction."


SECTIONS = (Section(name="limits", title="Limits", show=_show),)
