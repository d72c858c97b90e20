"""What was played: design, hashes and what is left out of the numbers; and what agents and box are on record as."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from lockprobe.foundation.grouping import grouped
from lockprobe.foundation.spec import PEOPLE
from lockprobe.report.opened import OpenedStudy
from lockprobe.report.prose import who
from lockprobe.report.rows import Estimate, Fact, Results, Row
from lockprobe.report.section import Part, Section, Template
from lockprobe.trial import record
from lockprobe.trial.record import STATES, asked_again

_PLANT = "plant "
"""What facts about a plant are about: this and its spec."""

_MANY = 8
"""Values of a fact beyond which they are counted."""


def _rows(numbers: OpenedStudy) -> Iterator[Row]:
    """What is on record and in no other number, and what was played twice."""
    for of, count, unit in (
        ("ended as error", sum(trial.ending == "error" for trial in numbers.trials), "trials"),
        ("replaced after an error", numbers.replaced, "records"),
    ):
        yield Estimate(quantity="left_out", of=of, value=count, unit=unit)


def _show(found: Results) -> Iterator[Part]:
    boxes = [found.get("boxes", agent=PEOPLE, condition="", of=of) for of in ("finished", "planned")]
    people = " of ".join(f"{row.value:.0f}" for row in boxes if row)
    agents = [str(agent) for agent in found.study.get("agents", ())]
    run = sum(agent != PEOPLE for agent in agents)
    played_by = [f"{run} agent{'s' * (run != 1)}"] * bool(run or not people) + ["people"] * bool(people)
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


SECTIONS = (
    Section("design", "Design", _rows, _show),
    Section("agents", "Agents and box", _agent_rows, _show_agents),
)
