"""The first screen: what was asked, who was studied, the answer for every agent, one figure, and what limits it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

from lockprobe.agents.catalogue import description
from lockprobe.foundation.formatting import capital, count, listed
from lockprobe.foundation.spec import PEOPLE, spec_name
from lockprobe.report.answer import AnswerList, beside_said, broken_said, headline, known_of_broken, solved_said
from lockprobe.report.curve import curve_figure, drawable
from lockprobe.report.format import DETECTED
from lockprobe.report.opened import OpenedStudy
from lockprobe.report.primary import Line, primary_lines
from lockprobe.report.prose import at_dose, cause
from lockprobe.report.questions import speed, stopping, why
from lockprobe.report.questions.boxes import boxes_said, differ_said
from lockprobe.report.questions.conditions import EFFECTS
from lockprobe.report.questions.contrasts import CONTRASTS, misreading_said
from lockprobe.report.questions.speed import effect_said
from lockprobe.report.questions.stopping import every_look_said, small_said
from lockprobe.report.rows import Fact, Results, Row, who
from lockprobe.report.section import Part, Section, Table, Template
from lockprobe.statistics.design import FLIPS, Design, arms_of
from lockprobe.statistics.outcomes import idle_interventions, never_acted
from lockprobe.studies.study import Study

_WHO, _WHO_MOST = "who was studied", 8
"""What the facts of agents are about, and how many are introduced at the top; of more there is only the list."""

_TOLD, _TOLD_MOST, _LOOKED_AT = "told under", 8, 10
"""What the facts of conditions are about, of how many at most, and among how many trials an example is looked for."""

_MODEL = ("served", "model", "temperature", "host")
"""Facts of a model that introduce it."""

_JOINTS = 6
"""Joints of a box that is drawn on the first screen; the drawing of a larger one stands in its part of the page."""

_NOTES = ("beside", "small", "every_look", "changed_nothing", "boxes")
"""Sentences below the answer, in their order."""

_CHANGES, _MOST = (CONTRASTS, why.TABLE, EFFECTS), 20
"""Tables of changes that the first screen shows in place of a curve, the first that has rows, and the most rows of one.
Of more it shows what was detected, and says so. The last stands beside no list of many agents, who have it there."""

_FIGURES = (stopping.FIGURE, speed.FIG3)
"""Figures of questions of their own, for a study whose answer is no curve over doses: the first that applies."""


def _rows(numbers: OpenedStudy) -> Iterator[Row]:
    study = numbers.study
    said = {
        "question": _question(study, numbers.design),
        "trial": _trial(study, numbers.design),
        "every_look": every_look_said(study, numbers.every_look, numbers.decisions, numbers.progress.finished),
        "changed_nothing": " ".join(_changed_nothing(numbers)),
        "rules": numbers.broken_rules_said,
    }
    for kind, text in said.items():
        if text:
            yield Fact(about="overview", name=kind, text=text)
    yield from (Fact(about=_WHO, name=label, text=what) for label, what in _who(numbers))
    yield from _told(numbers)


def _question(study: Study, design: Design) -> str:
    """What the study asks, in one line."""
    box = study.boxes_in_words
    if any(map(arms_of, design.shown.values())):
        return f"Why do false reports change how agents open {box}?"
    misread = [name for name, one in study.contrasts.items() if one.measure == "misreading"]
    if misread and next(iter(study.contrasts)) == misread[0]:
        return f"Do{'es' * (len(misread) == 1)} {listed(misread, named=3)} change what agents misread of {box}?"
    flips = ["false reports"] if any(one.p for one in study.flip_axis) else []
    axes = [one.axis for one in design.against_controls if one.axis not in (None, FLIPS)]
    causes = flips or list(dict.fromkeys(cause(one) for one in axes if one))
    rest = [label for one in design.against_controls if one.axis is None for label in one.groups[0][1:]]
    alone = [*study.contrasts][:1] or rest * (len(rest) == 1 and not causes)
    if study.of_flips and len(study.modalities) > 1 and not flips and not study.contrasts:
        alone = ["what agents see"]
    if alone:
        return f"Does {alone[0]} change how agents open {box}?"
    if rest and not flips:
        causes.append(f"{len(rest)}{' other' * bool(causes)} condition{'s' * (len(rest) > 1)}")
    return f"Do {listed(causes)} change how agents open {box}?" if causes else f"How well do agents open {box}?"


def _trial(study: Study, design: Design) -> str:
    """What happens in a trial, and what is varied."""
    steps, told = study.max_steps, "it is told what happened"
    if study.of_flips and len(study.modalities) > 1 and not any(one.p for one in study.flip_axis):
        told = "it is shown, or told, how the joints stand"
    said = f"An agent has {count(steps, 'step')} to open a box whose joints lock each other. After each step {told}."
    if any(one.p for one in study.flip_axis):
        what = "and some corrected" if any(map(arms_of, design.shown.values())) else "as often as the flip rate says"
        return f"{said} Some reports are false, {what}."
    acting = dict.fromkeys(spec_name(spec) for one in study.conditions for spec in one.specs)
    return f"{said} What acts under the conditions: {listed([*acting], named=4)}." if acting else said


def _changed_nothing(numbers: OpenedStudy) -> Iterator[str]:
    """Interventions that changed nothing, which is no null result."""
    design = numbers.design
    acting = {arm.label: arm.without() for arm in design.arms}
    whole: dict[str, dict[str, int]] = {}
    for cell in numbers.cells:
        if cell.agent not in numbers.subjects or cell.condition in design.controls.values():
            continue
        steps = int(cell.ended.length.sum())
        if never_acted(cell.trials):
            whole.setdefault(cell.condition, {})[cell.agent] = steps
        elif idle := idle_interventions(cell.trials, acting[cell.condition]):
            yield f"{listed(idle)} changed nothing under {cell.condition} for {who(cell.agent)} (0 of {steps} steps)."
    rates = {one.label: at_dose(one.p) for one in numbers.study.flip_axis if one.p}
    for condition, agents in whole.items():
        every = len(agents) == len(numbers.subjects)
        whom = " for any agent" * (len(agents) > 1) if every else f" for {listed([*map(who, agents)], named=3)}"
        rate = rates.get(condition)
        said = f"{capital(rate)} no report was false" if rate else f"{condition} changed nothing"
        yield f"{said}{whom} (0 of {sum(agents.values())} steps), so nothing is concluded from it."


def _who(numbers: OpenedStudy) -> Iterator[tuple[str, str]]:
    """What each agent that played is, in a few words: what its facts say of a model, else its description."""
    facts: dict[str, Mapping[str, object]] = {}
    for cell in numbers.cells:
        facts.setdefault(cell.agent, cell.trials[0].facts)
    for spec in numbers.study.agents:
        agent = numbers.study.label_of(spec)
        if agent in facts:
            known = [(name, facts[agent][name]) for name in _MODEL if facts[agent].get(name)]
            if agent == PEOPLE:
                known = [("people", f"{len({trial.agent for trial in numbers.trials if trial.player})} who took part")]
            model = ", ".join(f"temperature {said}" if name == "temperature" else str(said) for name, said in known)
            yield who(agent), model or description(spec)


def _told(numbers: OpenedStudy) -> Iterator[Fact]:
    """What one attempt was told under each condition with a name, where some tell something else.

    It is the same first attempt of the first agent, which no report has changed yet.
    """
    named = [one.label for one in numbers.study.conditions if one.name]
    cells = [cell for cell in numbers.cells if cell.agent == numbers.subjects[0] and cell.condition in named]
    if not 1 < len(cells) <= _TOLD_MOST:
        return
    for trials in zip(*(cell.trials[:_LOOKED_AT] for cell in cells), strict=False):
        steps = [trial.steps[:2] for trial in numbers.records(trials) if trial.steps]
        said = [" ".join(filter(None, (first.told, *(one.remark for one in later)))) for first, *later in steps]
        did = {(first.decision.joint, first.moved) for first, *_ in steps}
        if len(steps) == len(cells) and len(did) == 1 < len({*said}):
            joint, moved = did.pop()
            attempt = f"after {joint} {'moved' if moved else 'was blocked'}"
            yield Fact(about="overview", name="attempt", text=attempt)
            yield from (Fact(about=_TOLD, name=at.condition, text=text) for at, text in zip(cells, said, strict=True))
            return


def answer_of(found: Results) -> str:
    """What the study found: the sentences of the question that it asks, or what changed success."""
    solved, broke = found.where("success", of=""), found.where("broken", of="")
    if found.progress.finished and not (solved or broke):
        return "The answer could not be computed; the sections below that are left out say why."
    lines, nothing = primary_lines(found), found.fact("overview", "changed_nothing")
    own = [line for line in lines if not line.baseline] or lines
    declared, misread = any(line.cause for line in lines), found.where("misreading_difference")
    shown = [row for row in found.where("modality_effect") if row.agent in found.subjects]
    alone = bool(shown) and not found.several_p and not found.beside_flips
    axis = found.main_axis
    if declared:
        said = headline(own, own[0].cause, several=False)
    elif found.where("false_report_effect", of="total"):
        said = why.answer(own, found)
    elif found.progress.every_look and (misread or alone):
        said = "The answer holds for one look: it stands here when all planned trials are played."
    elif misread:
        said = misreading_said(misread)
    elif alone:
        said = effect_said(found, shown[0])
    elif nothing and not any(line.change or line.alike for line in lines):
        said = nothing
    else:
        dosed = axis and any(line.under.startswith(f"at {axis.axis.name} ") for line in own)
        what = "false reports" if found.several_p else cause(axis.axis) if axis and dosed else ""
        said = headline(own, what) or solved_said(found, own)
    everything = broken_said(found)
    sentences = everything, said * (bool(solved) or not everything), found.fact("overview", "rules")
    return " ".join(filter(None, sentences))


def _chain(box: Mapping[str, Any]) -> list[tuple[int, int]]:
    """Each joint that frees another, and that one, by place; none unless each waits for one beside it at most."""
    places = {joint["name"]: i for i, joint in enumerate(box.get("joints", ()))}
    needs = [(places[joint], clauses) for joint, clauses in box.get("interlock", {}).items()]
    chain = [(places[other], waits) for waits, clauses in needs for clause in clauses for other in clause]
    single = all(len(clauses) == 1 and len(clauses[0]) == 1 for _, clauses in needs)
    return chain if single and all(abs(frees - waits) == 1 for frees, waits in chain) else []


def _changes(found: Results, table: Table, lines: Sequence[Line]) -> tuple[Table, str] | None:
    """A table of changes as the first screen has room for it, and what it leaves out; None without a row."""
    head, *rows = table.cells(found) or [[]]
    primary = [line.change for line in lines if line.cause]  # the first declared contrast is the list
    every = [row for row in rows if not any(one in row for one in primary)]
    clear = every if len(rows) <= _MOST else [row for row in every if DETECTED in row]
    said = "" if clear == every else f"{len(clear)} of {len(every)} were detected; the questions below have all."
    shown = replace(table, lines=lambda found: iter([head, *clear]))
    return (shown, said) if 0 < len(clear) <= _MOST else None


def _show(found: Results) -> Iterator[Part]:
    """The top of the page, which has no heading of its own; nothing where its sentences could not be made."""
    said = found.facts_about("overview")
    if not said:
        return
    listing = AnswerList(found)
    drawn = [] if found.where("false_report_effect") or found.design.contrasts else drawable(found)
    introduced = {agent: what for agent, what in found.facts_about(_WHO).items() if what}
    played = {one.agent for one in found.design.players}
    waiting = [who(agent) for agent in found.study.get("agents", ()) if agent not in played]
    box = found.boxes[0] if len(found.boxes) == 1 and 0 < len(found.boxes[0].get("joints", ())) <= _JOINTS else {}
    figures, tables = [one for one in _FIGURES if one.applies(found)], _CHANGES[: 2 if listing.many else 3]
    said |= {"boxes": f"{differ_said(found)} {boxes_said(found)}".strip()} if len(found.boxes) > 1 else {}
    said["beside"] = beside_said(listing.lines)
    said["small"] = "" if found.where("false_report_effect") else small_said(found)
    values = {
        "said": said,
        "notes": [said[kind] for kind in _NOTES if said.get(kind) and said[kind] not in found.answer],
        "listing": listing,
        "broke": known_of_broken(found),
        "compared": max((line.change.corrected_for for line in listing.lines if line.change), default=1),
        "waiting": listed(waiting, named=3) if waiting else "",
        "who": list(introduced.items()) if len(introduced) <= _WHO_MOST else [],
        "panel": Template("panel", {"box": box, "chain": _chain(box)}) if box else None,
        "chain": bool(_chain(box)),
        "told": found.facts_about(_TOLD),
        "curve": curve_figure(found, wide=True) if drawn else "",
        "narrow": curve_figure(found, wide=False) if drawn else "",
        "axis": drawn[0].name if drawn else "",
        "stars": any(one.axis == "flip rate" for one in drawn),
        "figures": [] if drawn or listing.many else figures[:1],
        "changes": next((one for table in tables if (one := _changes(found, table, listing.lines))), None),
    }
    yield Part("First screen", found.answer, [Template("first_screen", values)])


SECTIONS = (Section(name="overview", title="First screen", rows=_rows, show=_show),)
