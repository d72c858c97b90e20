"""Design: what was played, by whom and how often, what is left out of the numbers, and the hashes of the study."""

from __future__ import annotations

from collections.abc import Iterator

from lockprobe.foundation.spec import PEOPLE
from lockprobe.interventions.flip import READINGS
from lockprobe.report.prose import Subject
from lockprobe.report.rows import Estimate, Fact, Results
from lockprobe.report.section import Caption, Figure, Part, Section, Template
from lockprobe.report.study_numbers import StudyNumbers
from lockprobe.trial.record import STATES

_READINGS = {
    READINGS["position", "fresh"]: " (a false position is corrected in the next report)",
    READINGS["position", "kept"]: " (a false position stays until its joint is attempted again)",
    READINGS[
        "outcome", "fresh"
    ]: " (the outcome is inverted; a false position is corrected when another joint is attempted)",
    READINGS[
        "outcome", "kept"
    ]: " (the outcome is inverted; a false position stays until its joint is attempted again)",
}
"""What a false report is."""

_ABOUT = "design"

_RECONSTRUCTED = "a reconstruction of the paper's strategy, whose algorithm is not public"


_PANEL = "The panel at the start and, below, the interlock, which no agent sees."


def _caption(found: Results) -> Caption:
    more = f" {found.boxes[0].get('name', '')}, the first of {len(found.boxes)} boxes." if len(found.boxes) > 1 else ""
    return Caption(_PANEL + more)


BOX = Figure("box", _PANEL, _caption, draw="lockprobe.report.figures.boxes:box_of_study")


def _rows(numbers: StudyNumbers) -> Iterator[Estimate | Fact]:
    """What is on record and in no other number, what was played twice, and what agents are."""
    opened, journal = numbers.opened, numbers.opened.journal
    for of, count, unit in (
        ("ended as error", sum(trial.ending == "error" for trial in opened.trials), "trials"),
        ("incomplete lines", journal.unfinished_lines, "lines"),
        ("outside the settings", opened.foreign, "trials"),
        ("of another study", journal.foreign, "records"),
        ("replaced after an error", journal.replaced, "records"),
        ("replaced without an error", journal.repeated, "records"),
        ("replayed on request", sum(trial.replays > 0 for trial in opened.trials), "trials"),
    ):
        yield Estimate(quantity="left_out", of=of, value=count, unit=unit)
    if called := [numbers.study.label_of(agent) for agent in numbers.study.agents if "human-inspired" in agent]:
        yield Fact(about=_ABOUT, name=", ".join(called), text=_RECONSTRUCTED)


def _show(found: Results) -> Iterator[Part]:
    boxes = [found.get("boxes", agent=PEOPLE, condition="", of=of) for of in ("finished", "planned")]
    people = " of ".join(f"{row.value:.0f}" for row in boxes if row)
    run = sum(agent != PEOPLE for agent in found.study.get("agents", ()))
    agents = f"{run} agent{'s' * (run != 1)}" if run or not people else ""
    played_by = " and ".join(filter(None, (agents, "people" if people else "")))
    modalities = list(dict.fromkeys(one.modality for one in found.design.conditions))
    values = {
        "run": run,
        "people": people,
        "subjects": [Subject.of(agent).name for agent in found.subjects],
        "others": [agent for agent in found.study.get("agents", ()) if agent not in found.subjects],
        "modalities": modalities if len(modalities) != 1 or modalities[0] not in (STATES, "symbolic") else [],
        "conditions": list(dict.fromkeys(cell.condition for cell in found.cells)) if found.beside_flips else [],
        "rates": list(dict.fromkeys(one.p for one in found.design.conditions if one.p is not None)),
        "kind": _READINGS.get(found.design.flip_kind, ""),
        "reconstructed": found.facts_about(_ABOUT),
        "left_out": {row.of: f"{row.value:.0f}" for row in found.where("left_out")},
    }
    answer = f"{found.progress.finished} trials of {played_by}."
    yield Part("Design", answer, [Template("design", values), BOX])


SECTIONS = (Section(name="design", title="Design", rows=_rows, show=_show, figures=(BOX,)),)
