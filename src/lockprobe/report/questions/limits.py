"""What limits the numbers: trials that broke, what is known whatever became of them, and what no number shows."""

from __future__ import annotations

from collections.abc import Iterator
from statistics import median
from typing import Any

from lockprobe.foundation.formatting import count
from lockprobe.foundation.grouping import grouped
from lockprobe.foundation.spec import Spec
from lockprobe.report.answer import known_of_broken
from lockprobe.report.opened import OpenedStudy
from lockprobe.report.questions.boxes import boxes_said
from lockprobe.report.questions.loops import LENGTHS
from lockprobe.report.rows import Estimate, Fact, Results, Row
from lockprobe.report.section import Part, Section, Template
from lockprobe.statistics.differences import few_broke_until
from lockprobe.trial.record import Trial


def _rows(numbers: OpenedStudy) -> Iterator[Row]:
    """By agent and boundary, with the first message and how many will be replayed; when trials broke and ended."""
    broken = grouped(
        (trial for trial in numbers.trials if trial.error is not None),
        lambda trial: (trial.group, str(trial.error.boundary) if trial.error else ""),
    )
    for (agent, boundary), trials in sorted(broken.items()):
        yield Estimate(quantity="broken", agent=agent, of=boundary, value=len(trials), unit="trials")
        owed = sum(trial.owed_again for trial in trials)
        replayed = "no" if not owed else "yes" if owed == len(trials) else f"{owed} of {len(trials)}"
        facts = {"first message": _message(trials[0]), "will be replayed": replayed}
        yield from (Fact(about=f"{agent}, broken at {boundary}", name=name, text=text) for name, text in facts.items())
    for (agent, modality), cells in grouped(numbers.cells, lambda cell: (cell.agent, cell.modality)).items():
        of: dict[str, Any] = {"agent": agent, "modality": modality, "unit": "steps"}
        if broke := [steps + 1 for cell in cells for steps in cell.outcomes.broken.length.tolist()]:
            yield Estimate(quantity="last_step", **of, of="broken", value=median(broke), n=len(broke))
            if ended := [steps for cell in cells for steps in cell.ended.length.tolist()]:
                yield Estimate(quantity="last_step", **of, of="ended", value=median(ended), n=len(ended))
            step = few_broke_until([cell.outcomes for cell in cells if len(cell.ended)])
            yield Estimate(quantity="last_step", **of, of="few broke", value=step)


def _message(trial: Trial) -> str:
    """What was said; of an agent that has a name without its spec, which may hold a path."""
    said = "" if trial.error is None else trial.error.message
    for written in (trial.spec, Spec.parse(trial.spec).name.removeprefix("gguf:")) if trial.called else ():
        said = said.replace(written, trial.called) if written else said
    return said


def _show(found: Results) -> Iterator[Part]:
    rows = [(row, found.facts_about(f"{row.agent}, broken at {row.of}")) for row in found.where("broken", condition="")]
    trials = sum(int(row.value or 0) for row, _ in rows)
    if rows:
        them = "it" if trials == 1 else "them"
        said = f"{count(trials, 'trial')}; shares and differences hold whatever became of {them}."
        known = known_of_broken(found, every=True)
        yield Part("Trials that broke", said, [Template("broken", {"known": known, "rows": rows})])


def _show_limits(found: Results) -> Iterator[Part]:
    """The answer says which parts of the study stand for those of the paper, which are not public."""
    answer = "Other boxes may differ." if len(found.boxes) == 1 else boxes_said(found)
    box, strategy = any(one.get("name") == "chain-4" for one in found.boxes), bool(found.reconstructed)
    if box and strategy:
        answer += " The box and the human-inspired strategy are reconstructions."
    elif box or strategy:
        answer += f" The {'box' if box else 'human-inspired strategy'} is a reconstruction."
    errors = any(row.value for row in found.where("left_out", of="ended as error"))
    values = {"caveat": LENGTHS, "errors": errors, "boxes": boxes_said(found)}
    yield Part("Limits", answer, [Template("limits", values)])


SECTIONS = (
    Section("broken", "Trials that broke", _rows, _show),
    Section("limits", "Limits", show=_show_limits),
)
