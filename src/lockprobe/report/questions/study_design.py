"""The study itself: what was played, what agents and box are on record as, trials that broke, and what limits it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from statistics import median
from typing import Any

from lockprobe.foundation.formatting import count, listed
from lockprobe.foundation.grouping import grouped
from lockprobe.foundation.spec import PEOPLE, Spec
from lockprobe.report.answer import known_of_broken
from lockprobe.report.opened import OpenedStudy
from lockprobe.report.questions.boxes import boxes_said
from lockprobe.report.questions.loops import LENGTHS
from lockprobe.report.rows import Estimate, Fact, Results, Row, who
from lockprobe.report.section import Part, Section, Template
from lockprobe.statistics.differences import few_broke_until
from lockprobe.trial import record
from lockprobe.trial.record import STATES, asked_again

_PLANT = "plant "
"""What facts about a plant are about: this and its spec."""

_MANY = 8
"""Values of a fact beyond which they are counted."""


def _rows(numbers: OpenedStudy) -> Iterator[Row]:
    """What is on record and in no other number, and what was played twice."""
    errors = sum(trial.ending == "error" for trial in numbers.trials)
    yield Estimate(quantity="left_out", of="ended as error", value=errors, unit="trials")
    yield Estimate(quantity="left_out", of="replaced after an error", value=numbers.replaced, unit="records")


def _show(found: Results) -> Iterator[Part]:
    boxes = [found.get("boxes", agent=PEOPLE, condition="", of=of) for of in ("finished", "planned")]
    people = " of ".join(f"{row.value:.0f}" for row in boxes if row)
    agents = [str(agent) for agent in found.study.get("agents", ())]
    run = sum(agent != PEOPLE for agent in agents)
    played_by = [count(run, "agent")] * bool(run or not people) + ["people"] * bool(people)
    modalities = list(dict.fromkeys(one.modality for one in found.design.conditions))
    values = {
        "run": run,
        "people": people,
        "subjects": list(map(who, found.subjects)),
        "others": [agent for agent in agents if agent not in found.subjects],
        "modalities": modalities if len(modalities) != 1 or modalities[0] not in (STATES, "symbolic") else [],
        "conditions": {one.name: " + ".join(one.specs) for one in found.design.conditions if found.beside_flips},
        "rates": list(dict.fromkeys(one.p for one in found.design.conditions if one.p is not None)),
        "left_out": {row.of: f"{row.value:.0f}" for row in found.where("left_out")},
    }
    answer = f"{found.progress.finished} trials of {' and '.join(played_by)}."
    yield Part("Design", answer, [Template("design", values)])


def _agent_rows(numbers: OpenedStudy) -> Iterator[Row]:
    """What agents said they were, which models answered, and what the plant is: every value, or how many there are."""
    trials, found = numbers.trials, dict[tuple[str, str], dict[str, None]]()
    for trial in trials:
        served = {step.decision.served: None for step in trial.steps if step.decision.served}
        told: list[tuple[str, Mapping[str, record.Fact | None]]] = [(trial.group, trial.facts)]
        told += [(trial.group, {"answered by": one}) for one in served]
        told += [(f"{_PLANT}{trial.plant.get('plant')}", trial.plant)] if trial.plant else []
        for about, name, value in ((about, *fact) for about, facts in told for fact in facts.items()):
            if value is not None or not about.startswith(_PLANT):  # such as a renderer where nobody looks
                found.setdefault((about, name), {})[str(value)] = None
    for (about, name), values in found.items():
        text = "; ".join(values) if len(values) <= _MANY else f"{len(values)} different values"
        yield Fact(about=about, name=name, text=text)
    again = asked_again(trials)
    for agent, own in grouped(trials, lambda trial: trial.group).items():
        tidied = [bool(step.decision.tidied) for trial in own for step in trial.steps]
        for of, (many, n) in (("tidied", (sum(tidied), len(tidied))), ("asked again", again.get(agent, (0, 0)))):
            if many:
                yield Estimate(quantity="replies", agent=agent, of=of, value=many / n, count=many, n=n)


def _show_agents(found: Results) -> Iterator[Part]:
    values = {
        "agents": {agent: facts for agent in found.study.get("agents", ()) if (facts := found.facts_about(agent))},
        "again": found.where("replies", of="asked again"),
        "tidied": found.where("replies", of="tidied"),
        "plants": [*map(found.facts_about, dict.fromkeys(f.about for f in found.facts if f.about.startswith(_PLANT)))],
    }
    said = "What agents and plant say of themselves, and what frees each joint."
    yield Part("Agents and box", said, [Template("agents", values)])


# What limits the numbers: trials that broke, what is known whatever became of them, and what no number shows.


def _broken(numbers: OpenedStudy) -> Iterator[Row]:
    """By agent and boundary, with the first message and how many will be replayed; when trials broke and ended."""
    broken = grouped(
        (trial for trial in numbers.trials if trial.error is not None),
        lambda trial: (trial.group, str(trial.error.boundary) if trial.error else ""),
    )
    for (agent, boundary), trials in sorted(broken.items()):
        yield Estimate(quantity="broken", agent=agent, of=boundary, value=len(trials), unit="trials")
        owed = sum(trial.owed_again for trial in trials)
        replayed = "no" if not owed else "yes" if owed == len(trials) else f"{owed} of {len(trials)}"
        first, said = trials[0], trials[0].error.message if trials[0].error else ""
        known = (first.spec, Spec.parse(first.spec).name.removeprefix("gguf:")) if first.called else ()
        for name in filter(None, known):  # an agent that has a name is called so: its spec may hold a path
            said = said.replace(name, first.called)
        facts = {"first message": said, "will be replayed": replayed}
        yield from (Fact(about=f"{agent}, broken at {boundary}", name=name, text=text) for name, text in facts.items())
    for (agent, modality), cells in grouped(numbers.cells, lambda cell: (cell.agent, cell.modality)).items():
        of: dict[str, Any] = {"agent": agent, "modality": modality, "unit": "steps"}
        if broke := [steps + 1 for cell in cells for steps in cell.outcomes.broken.length.tolist()]:
            yield Estimate(quantity="last_step", **of, of="broken", value=median(broke), n=len(broke))
            if ended := [steps for cell in cells for steps in cell.ended.length.tolist()]:
                yield Estimate(quantity="last_step", **of, of="ended", value=median(ended), n=len(ended))
            step = few_broke_until([cell.outcomes for cell in cells if len(cell.ended)])
            yield Estimate(quantity="last_step", **of, of="few broke", value=step)


def _show_broken(found: Results) -> Iterator[Part]:
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
    rebuilt = [str(box["name"]) for box in found.boxes if box.get("name") == "chain-4"]
    rebuilt += ["the human-inspired strategy"] * bool(found.reconstructed)
    answer += f" Reconstructed: {listed(rebuilt)}." if rebuilt else ""
    errors = any(row.value for row in found.where("left_out", of="ended as error"))
    values = {"caveat": LENGTHS, "errors": errors, "boxes": boxes_said(found), "rebuilt": rebuilt}
    yield Part("Limits", answer, [Template("limits", values)])


SECTIONS = (
    Section("design", "Design", _rows, _show),
    Section("agents", "Agents and box", _agent_rows, _show_agents),
    Section("broken", "Trials that broke", _broken, _show_broken),
    Section("limits", "Limits", show=_show_limits),
)
