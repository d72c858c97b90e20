"""Agents and box: what agents and the plant say they are, replies tidied or asked for again, and the interlock."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence

from lockprobe.agents.reply_text import TIDIED
from lockprobe.foundation.grouping import grouped
from lockprobe.report.rows import Estimate, Fact, Results, Row
from lockprobe.report.section import Part, Section, Template
from lockprobe.report.study_numbers import StudyNumbers
from lockprobe.trial import record
from lockprobe.trial.asked_again import asked_again
from lockprobe.trial.record import Decision, Trial

_PLANT = "plant "
"""What facts about a plant are about: this and its spec."""

_MANY = 8
"""Values of a fact beyond which they are counted."""


def _rows(numbers: StudyNumbers) -> Iterator[Row]:
    trials = numbers.opened.trials
    yield from _facts(told for trial in trials for told in _told(trial))
    # without what a plant does not have, as a renderer where nobody looks
    plants = [{name: value for name, value in one.plant.items() if value is not None} for one in trials if one.plant]
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


def _tidied(trials: Sequence[Trial]) -> Iterator[Estimate]:
    """The share of replies that were tidied, by agent, and how often each thing was done; none without any."""
    decisions: dict[str, list[Decision]] = {}
    for trial in trials:
        decisions.setdefault(trial.group, []).extend(step.decision for step in trial.steps)
    for agent, made in decisions.items():
        if tidied := sum(bool(one.tidied) for one in made):
            what = Counter(TIDIED.get(what, what) for one in made for what in one.tidied)  # type: ignore[call-overload]
            for of, count in (("tidied", tidied), *((f"tidied, {said}", many) for said, many in what.most_common())):
                n = len(made)
                yield Estimate(quantity="replies", agent=agent, of=of, value=count / n, count=count, n=n)


def _show(found: Results) -> Iterator[Part]:
    agents = {agent: facts for agent in found.study.get("agents", ()) if (facts := found.facts_about(agent))}
    plants = dict.fromkeys(fact.about for fact in found.facts if fact.about.startswith(_PLANT))
    tidied = (row for row in found.where("replies") if row.of.startswith("tidied"))  # of all first, then of each thing
    values = {
        "agents": agents,
        "again": found.where("replies", of="asked again"),
        "tidied": list(grouped(tidied, lambda row: row.agent).values()),
        "plants": [found.facts_about(plant) for plant in plants],
    }
    said = f"What is on record of {'the agents and ' * bool(agents)}the box{'es' * (len(found.boxes) > 1)}."
    yield Part("Agents and box", said, [Template("agents", dict[str, object](values))])


SECTIONS = (Section(name="agents", title="Agents and box", rows=_rows, show=_show),)
