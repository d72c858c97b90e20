"""What was played: design, hashes and what is left out of the numbers; and what agents and box are on record as."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping

from lockprobe.agents.reply import TIDIED
from lockprobe.foundation.grouping import grouped
from lockprobe.foundation.spec import PEOPLE
from lockprobe.interventions.flip import READINGS
from lockprobe.report.prose import Subject
from lockprobe.report.rows import Estimate, Fact, Results, Row
from lockprobe.report.section import Caption, Figure, Part, Section, Template
from lockprobe.report.study_numbers import StudyNumbers
from lockprobe.trial import record
from lockprobe.trial.asked_again import asked_again
from lockprobe.trial.record import STATES, Trial

_READINGS = {
    ("position", "fresh"): "a false position is corrected in the next report",
    ("position", "kept"): "a false position stays until its joint is attempted again",
    ("outcome", "fresh"): "the outcome is inverted; a false position is corrected when another joint is attempted",
    ("outcome", "kept"): "the outcome is inverted; a false position stays until its joint is attempted again",
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
    opened = numbers.opened
    for of, count, unit in (
        ("ended as error", sum(trial.ending == "error" for trial in opened.trials), "trials"),
        ("replaced after an error", opened.replaced, "records"),
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
    flips = found.design.flip_kind
    values = {
        "run": run,
        "people": people,
        "subjects": [Subject.of(agent).name for agent in found.subjects],
        "others": [agent for agent in found.study.get("agents", ()) if agent not in found.subjects],
        "modalities": modalities if len(modalities) != 1 or modalities[0] not in (STATES, "symbolic") else [],
        "conditions": {one.name: " + ".join(one.specs) for one in found.design.conditions}
        if found.beside_flips
        else {},
        "rates": list(dict.fromkeys(one.p for one in found.design.conditions if one.p is not None)),
        "kind": "".join(f" ({_READINGS[of]})" for of, kind in READINGS.items() if kind == flips and of in _READINGS),
        "reconstructed": found.facts_about(_ABOUT),
        "left_out": {row.of: f"{row.value:.0f}" for row in found.where("left_out")},
    }
    answer = f"{found.progress.finished} trials of {played_by}."
    yield Part("Design", answer, [Template("design", values), BOX])


_PLANT = "plant "
"""What facts about a plant are about: this and its spec."""

_MANY = 8
"""Values of a fact beyond which they are counted."""


def _agent_rows(numbers: StudyNumbers) -> Iterator[Row]:
    trials = numbers.opened.trials
    yield from _facts(told for trial in trials for told in _told(trial))
    # without what a plant does not have, as a renderer where nobody looks
    plants = ({name: value for name, value in one.plant.items() if value is not None} for one in trials if one.plant)
    yield from _facts((_PLANT + str(plant.get("plant")), plant) for plant in plants)
    yield from _tidied(trials)
    for agent, (again, n) in asked_again(trials).items():
        yield Estimate(quantity="replies", of="asked again", agent=agent, value=again / n, count=again, n=n)


def _told(trial: Trial) -> Iterator[tuple[str, Mapping[str, record.Fact]]]:
    """What the agent said it was, and which models answered in its place, as their provider names them."""
    yield trial.group, trial.facts
    for served in dict.fromkeys(step.decision.served for step in trial.steps):
        if served:
            yield trial.group, {"answered by": served}


def _facts(told: Iterable[tuple[str, Mapping[str, record.Fact]]]) -> Iterator[Fact]:
    """Properties; where trials differ, all values, or how many there are."""
    found: dict[str, dict[str, dict[str, None]]] = {}
    for about, facts in told:
        for name, value in facts.items():
            found.setdefault(about, {}).setdefault(name, {})[str(value)] = None
    for about, names in found.items():
        for name, values in names.items():
            text = "; ".join(values) if len(values) <= _MANY else f"{len(values)} different values"
            yield Fact(about=about, name=name, text=text)


def _tidied(trials: Iterable[Trial]) -> Iterator[Estimate]:
    """The share of replies that were tidied, by agent, and how often each thing was done; none without any."""
    decisions, tidied = Counter[str](), dict[str, list[tuple[str, ...]]]()
    for trial in trials:
        decisions[trial.group] += len(trial.steps)
        tidied.setdefault(trial.group, []).extend(step.decision.tidied for step in trial.steps if step.decision.tidied)
    for agent, made in tidied.items():
        if made:
            what = Counter(TIDIED.get(what, what) for one in made for what in one)  # type: ignore[call-overload]
            for of, count in (("tidied", len(made)), *((f"tidied, {said}", many) for said, many in what.most_common())):
                n = decisions[agent]
                yield Estimate(quantity="replies", agent=agent, of=of, value=count / n, count=count, n=n)


def _show_agents(found: Results) -> Iterator[Part]:
    agents = {agent: facts for agent in found.study.get("agents", ()) if (facts := found.facts_about(agent))}
    plants = dict.fromkeys(fact.about for fact in found.facts if fact.about.startswith(_PLANT))
    tidied = (row for row in found.where("replies") if row.of.startswith("tidied"))  # of all first, then of each thing
    values = {
        "agents": agents,
        "again": found.where("replies", of="asked again"),
        "tidied": list(grouped(tidied, lambda row: row.agent).values()),
        "plants": [found.facts_about(plant) for plant in plants],
    }
    yield Part(
        "Agents and box",
        "What agents and plant say of themselves, and what frees each joint.",
        [Template("agents", dict[str, object](values))],
    )


SECTIONS = (
    Section(name="design", title="Design", rows=_rows, show=_show, figures=(BOX,)),
    Section(name="agents", title="Agents and box", rows=_agent_rows, show=_show_agents),
)
