"""Findings: what the study found, in sentences, agent by agent and condition by condition."""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import partial

from markupsafe import Markup

from lockprobe.foundation.left_out import section
from lockprobe.report.prose.effects import effects_said
from lockprobe.report.prose.hypothesis_tests import conclusions
from lockprobe.report.prose.idle import idle_said, unheeded_said
from lockprobe.report.prose.loops import LOOP_DEFINITION, loop_finding
from lockprobe.report.prose.modalities import modality_finding
from lockprobe.report.prose.panel import panel_said
from lockprobe.report.prose.robot import rules_said, senses_said
from lockprobe.report.prose.success import baselines_said, courses_said, finding
from lockprobe.report.rows import Finding, Results, Row
from lockprobe.report.section import Block, Detail, Part, Section, Template, Text
from lockprobe.report.sections.doses import dose_sections
from lockprobe.report.study_numbers import StudyNumbers
from lockprobe.report.table_rows import name_of
from lockprobe.statistics.conditions.condition_study import ConditionStudySummary
from lockprobe.statistics.summary import StudySummary

__all__ = ["SECTIONS"]

_MANY = 2
"""Agents that the study is about, beyond which what is said of all of them comes first."""


_RESTS_ON = {
    "modalities": ("modality_effect", "hazard_ratio_of_modalities"),
    "finding": ("success", "clearest_success_difference"),
    "loops": ("loop_rate", "loop_rate_chance"),
    "conclusion": ("test",),
    "courses": ("success_difference", "success_two_lines"),
    "baselines": ("success",),
    "conditions": ("success_difference", "success_interaction", "changed_steps"),
    "verdicts": ("wrong_verdicts", "undecided_verdicts", "wrong_readings", "unclear_readings"),
    "rules": ("against_rules",),
}
"""Kind of a sentence -> the quantities that it rests on."""


def _rows(numbers: StudyNumbers) -> Iterator[Row]:
    flips, others = numbers.flips, numbers.others
    for title, rows in (
        ("Findings on modalities", _of_modalities(flips)),
        ("Findings", _of_agents(numbers)),
        ("Findings on all agents", _of_all_agents(flips)),
        ("Findings on conditions", _of_conditions(others)),
        ("Findings on the plant", _of_plant(numbers)),
    ):
        yield from section(title, partial(list, rows), list[Row])


def _said(kind: str, *sentences: str, agent: str = "", modality: str = "", judges: bool = True) -> Iterator[Finding]:
    for text in filter(None, sentences):
        yield Finding(
            section="findings",
            kind=kind,
            agent=agent,
            modality=modality,
            text=text,
            rests_on=_RESTS_ON.get(kind, ()),
            judges=judges,
        )


def _of_modalities(flips: StudySummary) -> Iterator[Row]:
    for effect in flips.modalities:
        yield from _said("modalities", modality_finding(effect, flips), agent=effect.agent)


def _of_agents(numbers: StudyNumbers) -> Iterator[Row]:
    """What each agent does over the flip rates; nothing of a study of conditions with a single rate."""
    flips = numbers.flips
    if numbers.others is not None and len({one.dose for one in flips.conditions}) == 1:
        return
    for one in flips.subjects:
        said = partial(_said, agent=one.agent, modality=one.modality)
        yield from said("finding", finding(one))
        yield from said("loops", loop_finding(one))
        yield from said("conclusion", *conclusions(one))


def _of_all_agents(flips: StudySummary) -> Iterator[Row]:
    yield from _said("courses", courses_said(flips))
    yield from _said("baselines", baselines_said(flips))


def _of_conditions(found: ConditionStudySummary | None) -> Iterator[Row]:
    """What changed nothing, for baselines too, and the effects of what did on the agents that the study is about."""
    if found is None:
        return
    yield from _said("conditions", *idle_said(found.idle, found.agents), *unheeded_said(found.unheeded, found.subjects))
    for one in found.effects:
        if one.agent in found.subjects:
            said = effects_said(one, found.conditions)
            yield from _said("conditions", *said, agent=one.agent, modality=one.modality)


def _of_plant(numbers: StudyNumbers) -> Iterator[Row]:
    """What a robot and its box did, which judges no agent, and what pictures show of the panel."""
    yield from _said("verdicts", senses_said(numbers.robot) if numbers.robot else "", judges=False)
    yield from _said("rules", rules_said(numbers.rules) if numbers.rules else "", judges=False)
    if (study := numbers.study).has_pictures:
        said = panel_said(
            study.panel,
            dealt=study.layout == "shuffled",
            listed_anew=study.shuffle != "never",
            rigid="model=" in study.plant,
        )
        yield from _said("panel", said, judges=False)


def _show(found: Results) -> Iterator[Part]:
    whys = [" ".join(found.said("why", "verdict", agent=agent, modality=modality)) for agent, modality in _why(found)]
    lines = [*(_of_flips(found) or ["No trial has been played yet."] * _unplayed(found)), *_beside_flips(found)]
    lines = list(dict.fromkeys(lines))
    number = (len(whys) + len(lines)) * any(one.section == "findings" for one in found.findings)
    said = f"{number} finding{'s' * (number != 1)}: what was detected, what was not, and how sure that is."
    shown: list[Block] = [Template("findings", {"why": whys, "lines": list(map(_parted, lines))})]
    if len(found.said("findings", "finding")) > _MANY or found.said("findings", "modalities"):
        shown.append(Detail("Agent by agent", [Text(one) for one in _by_agent(found)]))
    yield Part("Findings", said * bool(number), [*shown, *_words(found)])


def _unplayed(found: Results) -> bool:
    return not any(cell.trials for cell in found.cells)


def _of_flips(found: Results) -> list[str]:
    """What is said of flip rates and modalities; of many agents, what is said of all, and the effect on each."""
    of = partial(found.said, "findings")
    modalities, courses = of("modalities"), of("courses")
    whole = len(found.subjects) > _MANY and bool(courses)
    effects = [] if _why(found) else of("finding")
    agents = [] if modalities else effects if whole else list(_by_agent(found))
    last = of("baselines") if of("finding") else []
    first, then = (courses, []) if whole else ([], courses)
    return [*modalities, *first, *agents, *of("verdicts"), *then, *last]


def _why(found: Results) -> list[tuple[str, str]]:
    """Agents of a study of controls: the verdict on why false reports change success says whether they do."""
    return [(row.agent, row.modality) for row in found.where("false_report_effect", of="total")]


def _by_agent(found: Results) -> Iterator[str]:
    """What is said of each agent; of several, each line has the agent's name."""
    whys, several = _why(found), len(found.said("findings", "finding")) > 1
    for one in found.findings:
        if (one.section, one.kind) == ("findings", "finding"):
            own = {"agent": one.agent, "modality": one.modality}
            name = f"{name_of(found, **own)}: " if several else ""
            yield from [one.text] * ((one.agent, one.modality) not in whys)
            for kind in ("loops", "conclusion"):
                yield from (f"{name}{text}" for text in found.said("findings", kind, **own))


def _beside_flips(found: Results) -> Iterator[str]:
    """What is said of other doses, of other conditions and of the plant.

    Without a finding on flip rates, what baselines solved stands below these, as a comparison needs what it compares.
    """
    of = partial(found.said, "findings")
    for name in dose_sections(found):
        yield from found.said(name, "finding")
    yield from (*of("conditions"), *([] if of("finding") else of("baselines")), *of("rules"), *of("panel"))


_TEST = re.compile(
    r"^(?P<said>[^()]*(?:\([^()]*\)[^()]*)*?)"
    r" \((?P<test>(?:[^()]|\([^()]*\))*P [=<] [^()]*)\)"
    r"(?P<rest>.*)$"
)
"""A sentence, the brackets that hold its test, and what follows."""


def _parted(sentence: str) -> tuple[str, str]:
    """What a sentence says, and the test behind it; the second is empty where there is none, or several."""
    found = _TEST.match(sentence)
    if found is None or " P = " in found["rest"] or " P < " in found["rest"]:
        return sentence, ""
    return found["said"] + found["rest"], found["test"]


def _words(found: Results) -> Iterator[Block]:
    """What the words mean."""
    if found.several_p:
        yield Text(
            Markup(
                "Flip rate <i>p</i>: the probability that a report is inverted; <i>P</i>: the P value of a test. A "
                "block is one repetition and trial under all conditions, with common random numbers."
            ),
            "note",
        )
    if found.said("findings", "loops"):
        yield Text(LOOP_DEFINITION, "note")


SECTIONS = (Section(name="findings", title="Findings", rows=_rows, show=_show),)
