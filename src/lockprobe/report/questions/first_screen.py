"""The first screen of a report: its question, the answer in one sentence, one figure, and key numbers."""

from __future__ import annotations

from collections.abc import Container, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from lockprobe.agents.catalogue import description
from lockprobe.foundation.formatting import listed
from lockprobe.foundation.spec import PEOPLE
from lockprobe.report.answer_list import answer_list, headline, known_of_broken
from lockprobe.report.curve import curve_figure, drawable
from lockprobe.report.panel import panel_figure
from lockprobe.report.prose.doses import at_dose, cause
from lockprobe.report.prose.first_screen import (
    Varied,
    all_broken_said,
    interaction_said,
    modality_answer,
    no_advantage_said,
    not_above_chance,
    trial_said,
    varied_by,
)
from lockprobe.report.prose.idle import idle_doses_said, idle_said, unheeded_said
from lockprobe.report.prose.readings import BOTH_FIT
from lockprobe.report.prose.several_answers import of_conditions, several_answers
from lockprobe.report.prose.subject import Subject
from lockprobe.report.prose.trials_needed import effects_needed, flips_needed
from lockprobe.report.questions import all_sections
from lockprobe.report.questions.factors import factor_rows, factorial_said
from lockprobe.report.questions.readings import untested
from lockprobe.report.questions.stopping import PEOPLE_SAID, effects_said, every_look_said, small_said
from lockprobe.report.questions.too_few_trials import answered_questions, lacking_agents, with_lacking
from lockprobe.report.questions.why import mechanism_said
from lockprobe.report.rows import Fact, Finding, Results, Row
from lockprobe.report.section import Part, Section, Template
from lockprobe.report.study_numbers import StudyNumbers
from lockprobe.statistics.conditions.condition_study import ConditionStudySummary
from lockprobe.statistics.contrast import Effects
from lockprobe.statistics.factorial import factorials_of
from lockprobe.statistics.summary import StudySummary
from lockprobe.studies.study import Study
from lockprobe.studies.study_design import design_of
from lockprobe.trial.condition import TRUTH

_ABOUT = "first screen"
"""What the facts of the first screen are about; those of an agent, with its place from 1 behind it."""

_ANSWERS = 3
"""Agents whose answers stand there."""

_FEW = "Not known yet: the answer needs two blocks or more with an ended trial"
"""What is said as long as too few trials have ended."""

_ONE_LOOK = "The answer holds for one look: it stands here when all planned trials are played."
"""What is said where the answer rests on tests that do not hold at every look."""

_WHO, _WHO_MOST = "who was studied", 8
"""What the facts of agents are about, and how many are introduced at the top; of more there is only the list."""

_MODEL = ("served", "model", "temperature", "host")
"""Facts of a model that introduce it."""

_NUMBERS = ("All numbers", "Every condition against the control")
"""How the names of sections begin without which there is no answer."""


@dataclass(frozen=True, slots=True, kw_only=True)
class _Screen:
    """A first screen.

    Attributes:
        question: What the study asks.
        trial: What happens in a trial, and what is varied.
        answer: What it found.
        changed_nothing: Interventions that changed nothing in a whole condition, unless that is the answer, and
            conditions under which the only agent chose as under the control.
        chance: Agents without a detected advantage over random agents.
        interaction: Whether a detected effect reverses within fewer steps, and whether it differs from one that was
            not detected.
        every_look: Why it holds at every look; empty if at one.
        small: Which differences are shown to be smaller than the margin of the study.
        needed: How many trials narrow the widest interval of an undetected effect to 10 points either way.
        untested: Which agents were told false reports of one kind alone.
        figure: Name of the figure that shows it.
        cause: What may change success, where the list of agents answers the question; else empty.
    """

    question: str
    trial: str
    answer: str
    every_look: str = ""
    small: str = ""
    changed_nothing: str = ""
    chance: str = ""
    interaction: str = ""
    needed: str = ""
    untested: str = ""
    cause: str = ""
    figure: str = ""


_SAID: Mapping[str, tuple[bool, tuple[str, ...]]] = {
    "question": (False, ()),
    "trial": (False, ()),
    "answer": (True, ("success", "success_difference", "clearest_success_difference", "broken")),
    "every_look": (False, ()),
    "small": (True, ("decided_at_block",)),
    "changed_nothing": (False, ("changed_steps", "false_report")),
    "interaction": (True, ("success_interaction",)),
    "chance": (True, ("success", "success_chance")),
    "needed": (True, ("success_difference", "clearest_success_difference")),
    "untested": (False, ()),
    "cause": (False, ()),
}
"""Kind of a sentence -> whether it judges an agent, and the quantities that it rests on."""


def _rows(numbers: StudyNumbers) -> Iterator[Row]:
    lacking = lacking_agents(numbers)
    screen = (
        _of_conditions(numbers.flips, numbers.others, numbers.study, lacking)
        if numbers.others is not None
        else _of_flips(numbers.flips, numbers.study, lacking)
    )
    if numbers.opened.every_look:
        screen = _at_every_look(screen, numbers)
    screen = replace(screen, answer=with_lacking(screen.answer, numbers, lacking))
    rules = numbers.broken_rules  # random agents play a box that keeps them
    screen = replace(screen, untested=untested(numbers), chance=screen.chance * (not rules))
    if broken := all_broken_said(numbers.all_broken):
        ended = any(trial.error is None for cell in numbers.cells for trial in cell.trials)
        screen = replace(screen, answer=_joined(broken, screen.answer * ended))
    screen = replace(screen, answer=_joined(screen.answer, rules))
    for kind, (judges, rests_on) in _SAID.items():
        counted = ("against_rules",) * (kind == "answer" and bool(rules))
        if said := getattr(screen, kind):
            yield Finding(section="overview", kind=kind, text=said, rests_on=(*rests_on, *counted), judges=judges)
    if screen.figure:
        yield Fact(about=_ABOUT, name="figure", text=screen.figure)
    yield from (Fact(about=_WHO, name=label, text=what) for label, what in _who(numbers))


def _who(numbers: StudyNumbers) -> Iterator[tuple[str, str]]:
    """What each agent that played is, in a few words: what its facts say of a model, else its description."""
    facts: dict[str, Mapping[str, object]] = {}
    for cell in numbers.cells:
        for trial in cell.trials[:1]:
            facts.setdefault(cell.agent, trial.facts)
    for spec in numbers.study.agents:
        agent = numbers.study.label_of(spec)
        if agent in facts:
            known = [(name, facts[agent][name]) for name in _MODEL if facts[agent].get(name)]
            model = ", ".join(f"temperature {said}" if name == "temperature" else str(said) for name, said in known)
            yield agent, model or description(spec)


def _at_every_look(screen: _Screen, numbers: StudyNumbers) -> _Screen:
    """The first screen of a study that is judged at every look: it holds then, or it is not said yet."""
    opened, study = numbers.opened, numbers.study
    found = numbers.decisions
    said = every_look_said(study, opened.every_look, found, opened.finished)
    people = PEOPLE_SAID * (PEOPLE in study.agents)
    margin = study.until.margin if study.until else None
    return replace(
        screen,
        answer=screen.answer if not _judged_at_one_look(numbers) else effects_said(found) if found else _ONE_LOOK,
        every_look=_joined(said, people),
        small="" if margin is None or (numbers.others and numbers.others.whys) else small_said(found, margin),
        needed="",
        interaction="",
        figure="stopping" if study.until else screen.figure,
    )


def _judged_at_one_look(numbers: StudyNumbers) -> bool:
    """Whether the answer rests on tests that hold for one look: of steps, of modalities, or of many factors."""
    arms, others = design_of(numbers.study).arms, numbers.others
    if others is None:
        return bool(numbers.flips.modalities) and len({one.dose for one in numbers.flips.conditions}) < 2
    modalities = design_of(numbers.study).modalities
    return any(factorials_of(arms, modality) for modality in modalities)


def _of_flips(summary: StudySummary, study: Study, lacking: Container[str] = ()) -> _Screen:
    """The first screen of a study of flips or modalities."""
    box, several = study.box.name, len({one.dose for one in summary.conditions}) > 1
    modal = bool(summary.modalities) and not several
    varied: Varied = "modalities" if modal else "flips" if any(study.p) else "nothing"
    subjects = summary.judged
    question, answer = f"How well do agents open {box}?", ""
    if modal:
        question = f"Does what agents see change how they open {box}?"
        seeing = [one for one in summary.modalities if one.agent in {agent.agent for agent in subjects}]
        answer = " ".join(modality_answer(one) for one in seeing[:1])
    elif several:
        question = f"Do false reports change how agents open {box}?"
    return _Screen(
        question=question,
        trial=trial_said(study.max_steps, varied, study.flip, study.modalities),
        answer=answer or several_answers(answered_questions(summary, lacking)),
        changed_nothing=_joined(*map(idle_doses_said, subjects)),
        chance=not_above_chance(summary),
        interaction=interaction_said(summary),
        needed=flips_needed(summary),
        cause="false reports" if several and not modal else "",
        figure="overview" if subjects else "",
    )


def _of_conditions(
    flips: StudySummary, found: ConditionStudySummary, study: Study, lacking: Container[str] = ()
) -> _Screen:
    """The first screen of a study with conditions beside flip rates: one question for each family of contrasts."""
    axes = _tested_axes(flips, found)
    judged = _judged(found)
    effects = [one for one in found.effects if one.agent in judged and one.effects]
    named = [one for one in found.idle if one.agent in judged]
    idle = idle_said(named, judged)
    if found.whys:
        said = _of_why(found, study)
    elif any(factorials_of(found.design.arms, modality) for modality in found.design.modalities):
        said = _of_factorial(found, study)
    else:
        questions = [question for one in axes for question in answered_questions(one, lacking)]
        if effects or not (questions or any(agent in lacking for agent in judged)):
            other = bool(questions) or any(not one.intervention for one in named)
            questions += of_conditions(effects, other=other)
        said = _Screen(
            question=_asked(axes, found, study),
            trial=trial_said(study.max_steps, varied_by(study.conditions)),
            answer=_joined(several_answers(questions), BOTH_FIT * (_readings(axes) > 1 and bool(questions))),
            chance=_no_advantage(found, effects) or _joined(*map(not_above_chance, axes[:1])),
            needed=_joined(*dict.fromkeys((*(flips_needed(one, named=True) for one in axes), effects_needed(effects)))),
        )
        if not effects and not axes and idle:
            said, idle = replace(said, answer=idle[0]), idle[1:]
        caused = cause(axes[0].axis) if axes and not effects else ""
        said = replace(said, cause=caused, figure="effects" if effects or axes else "")
    if len(judged) == 1:
        idle += unheeded_said(found.unheeded, judged)
    said = replace(said, changed_nothing=_joined(*idle))
    if flips in axes:
        said = _with_flips(_of_flips(flips, study, lacking), said)
    return said


def _readings(axes: Sequence[StudySummary]) -> int:
    """How many readings of a false report are compared with the truth."""
    return len({one.axis for one in axes if one.axis.of_flips})


def _judged(found: ConditionStudySummary) -> tuple[str, ...]:
    """The agents that the study is about and that have an ended trial; all with one if none of them has."""
    ended = {agent for (agent, _), one in found.conditions.items() if one.success.n}
    return tuple(agent for agent in found.subjects if agent in ended) or tuple(
        agent for agent in found.agents if agent in ended
    )


def _tested_axes(flips: StudySummary, found: ConditionStudySummary) -> list[StudySummary]:
    """The axes whose doses are compared with the control, flip rates first; without any in a study of controls."""
    several = [flips] if len({one.dose for one in flips.conditions}) > 1 else []
    tested = {one.axis for one in found.on_axes}
    more = [one for series, one in found.series if series in found.design.other_axes and one.axis.name in tested]
    return [] if found.whys or found.factorials else [*several, *more]


def _asked(axes: Sequence[StudySummary], found: ConditionStudySummary, study: Study) -> str:
    """The question of the page."""
    compared = map(found.design.comparison, found.design.modalities)
    rest = [label for of in compared for label in (*of.others, *of.controls)]
    kinds = _readings(axes)
    said = (
        cause(one.axis) if kinds < 2 or not one.axis.of_flips else f"false reports of {kinds} kinds" for one in axes
    )
    causes = list(dict.fromkeys(said))
    if not causes and not rest:
        return f"How well do agents open {study.box.name}?"
    if not causes and len(rest) == 1:
        return f"Does {rest[0]} change how agents open {study.box.name}?"
    causes += [f"{len(rest)}{' other' * bool(causes)} condition{'s' * (len(rest) > 1)}"] * bool(rest)
    return f"Do {listed(causes)} change how agents open {study.box.name}?"


def _of_why(found: ConditionStudySummary, study: Study) -> _Screen:
    """The first screen of a study of controls."""
    whys = [one for one in found.whys if one.agent in found.subjects] or found.whys[:1]
    effects = [one for one in found.effects if one.agent in found.subjects and one.effects]
    return _Screen(
        question=f"Why do false reports change how agents open {study.box.name}?",
        trial=trial_said(study.max_steps, varied_by(study.conditions)),
        answer=_joined(*map(mechanism_said, whys)),
        chance=_no_advantage(found, effects),
        figure="why",
    )


def _of_factorial(found: ConditionStudySummary, study: Study) -> _Screen:
    """The first screen of a study of many factors at once."""
    return _Screen(
        question=f"Which features of the scene change how agents open {study.box.name}?",
        trial=trial_said(study.max_steps, "scenes" if study.plants[1:] and study.has_pictures else "conditions"),
        answer=" ".join(factorial_said(factor_rows(one)) for one in found.factorials[:_ANSWERS])
        or f"{_FEW} in every condition.",
        figure="factorial" * bool(found.factorials),
    )


def _with_flips(flips: _Screen, all_axes: _Screen) -> _Screen:
    """One first screen: flip rates are the question; other conditions have parts of their own below."""
    return replace(
        all_axes,
        changed_nothing=_joined(flips.changed_nothing, all_axes.changed_nothing),
        question=flips.question,
        trial=flips.trial,
        cause=flips.cause,
        chance=flips.chance or all_axes.chance,
        interaction=flips.interaction,
        figure=flips.figure or all_axes.figure,
    )


def _joined(*sentences: str) -> str:
    return " ".join(filter(None, sentences))


def _no_advantage(found: ConditionStudySummary, effects: Sequence[Effects]) -> str:
    """Agents without a detected advantage over random agents under the first control."""
    if not effects:
        return ""
    control = effects[0].control
    agents = [one.agent for one in effects if one.control == control]
    shares = {Subject.of(agent).name: found.conditions[agent, control].success for agent in agents}
    return no_advantage_said(
        shares, at_dose(0) if control == TRUTH else f"under {control}", found.reference.no_repeat[-1]
    )


def _show(found: Results) -> Iterator[Part]:
    """The top of the page, which has no heading of its own; nothing where its sentences could not be made."""
    said = {one.kind: one.text for one in found.findings if one.section == "overview"}
    figure, listing = found.fact(_ABOUT, "figure"), answer_list(found)
    drawn = drawable(found) if figure == "overview" else []
    tested = [line.change for line in listing.lines if line.change]
    who = {agent: what for agent, what in found.facts_about(_WHO).items() if what}
    panel, panel_says = panel_figure(found.study.get("box", {}))
    one_look = not found.progress.every_look and figure in ("overview", "effects", "")
    values = {
        "said": dict.fromkeys(_SAID, "") | said,
        "headline": headline(listing.lines, said.get("cause", "")) if one_look else "",
        "listing": listing,
        "broke": known_of_broken(found),
        "compared": max((row.corrected_for for row in tested), default=1),
        "who": list(who.items()) if len(who) <= _WHO_MOST else [],
        "panel": panel,
        "panel_says": panel_says,
        "curve": curve_figure(found, wide=True) if drawn else "",
        "narrow": curve_figure(found, wide=False) if drawn else "",
        "axis": drawn[0].name if drawn else "",
        "stars": any(one.axis == "flip rate" for one in drawn),
        "figures": [
            one for of in all_sections() for one in of.figures if one.name == figure and not (drawn or listing.many)
        ],
    }
    if said:
        yield Part("First screen", found.answer_of("overview"), [Template("first_screen", values)])


def without_answer(found: Results) -> Results:
    """The results without an answer if its numbers are among what could not be made."""
    numberless = any(one.section.startswith(_NUMBERS) for one in found.sections_left_out)
    if not (numberless and found.progress.finished) or found.where("success"):
        return found
    said = "The answer could not be computed; the sections below that are left out say why."
    findings = [
        one.model_copy(update={"text": said}) if (one.section, one.kind) == ("overview", "answer") else one
        for one in found.findings
    ]
    return found.changed(findings=tuple(findings), answer=said)


SECTIONS = (Section(name="overview", title="First screen", rows=_rows, show=_show),)
