"""The first screen of a report in words: the question, and the answer in one sentence."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from typing import Literal

from lockprobe.foundation.formatting import capital, change, listed, p_value, percent, range_of
from lockprobe.interventions.conditions import tells_positions
from lockprobe.interventions.flip import OutcomeFlip
from lockprobe.report.prose.doses import at_dose, cause
from lockprobe.report.prose.readings import inverted
from lockprobe.report.prose.subject import Subject, subject_of, subjects_by_name
from lockprobe.report.prose.success import alike_said
from lockprobe.statistics.agent_comparison.pairs import AgentComparison
from lockprobe.statistics.agent_summary import AgentSummary
from lockprobe.statistics.clustered import ClusteredProportion
from lockprobe.statistics.conditions.axis import Axis
from lockprobe.statistics.conditions.modalities import spoken
from lockprobe.statistics.conditions.modality_effect import ModalityEffect
from lockprobe.statistics.contrast import CONTROLS, Effect, Effects
from lockprobe.statistics.inference.difference import DifferenceAt
from lockprobe.statistics.proportions import ALPHA, Paired, Proportion, proportion
from lockprobe.statistics.sequential.shares import SequentialShare
from lockprobe.statistics.summary import StudySummary
from lockprobe.trial.condition import Condition
from lockprobe.trial.record import STATES

NARROW = 0.1
"""Half the width of an interval that would decide whether an effect is small; ours, chosen by eye."""

_WORDS = 30
"""Words of an answer at most."""

_NAMED = 3
"""Names in a list; the others are counted."""

_DOES = ("raise", "lower")
"""What may be done to success: more of it, and less."""


_VARIED = {
    "flips": "After each step it is told what happened. The flip rate is the probability that {flipped}.",
    "nothing": "After each step it is told what happened.",
    "modalities": "After each step it is shown, or told, how the joints stand.",
    "scenes": "After each step it sees the box in a picture. Conditions change the scene.",
    "conditions": (
        "After each step it is told what happened. Conditions change what it is told, what it is asked or what it does."
    ),
    "conditions and plant": (
        "After each step it is told what happened. Conditions change what it is told, what it is asked, what it does "
        "or the plant."
    ),
    "plant": "After each step it is told what happened. Conditions change the plant on which it acts.",
}

Varied = Literal["flips", "modalities", "conditions", "conditions and plant", "plant", "scenes", "nothing"]
"""What differs between the conditions of a study."""


def trial_said(
    budget: int, varied: Varied, flip: OutcomeFlip | None = None, modalities: Sequence[str] = (STATES,)
) -> str:
    """What happens in a trial, and what is varied.

    Args:
        budget: Steps of a trial.
        varied: What differs between conditions.
        flip: What a false report is; the default reading if None.
        modalities: How the box is shown.
    """
    positions = any(map(tells_positions, modalities))
    told = _VARIED[varied].format(flipped=inverted(flip or OutcomeFlip(), positions=positions))
    return f"An agent has {budget} step{'s' * (budget != 1)} to open a box whose joints lock each other. {told}"


def varied_by(conditions: Sequence[Condition]) -> Varied:
    """What differs between conditions that are more than flip rates: interventions, the plant, or both."""
    on_others = [one for one in conditions if one.plant.options]
    told = any(len(one.specs) > bool(one.plant.options) for one in conditions)
    return "conditions" if not on_others else "conditions and plant" if told else "plant"


def flips_answer(summary: StudySummary) -> str:
    """What false reports, or another dose, did to the success of the agents that the study is about."""
    counted = summary.judged
    if not counted:
        return "No trial has ended yet."
    heeding = [agent for agent in counted if agent.contrast and not agent.blind]
    if heeding:
        return _changes(heeding, summary.axis)
    if len(counted) > 1:
        return _leaders(counted, summary.comparisons)
    (only,) = counted
    first = next(one for one in only.conditions if one.success.n)
    rate = f"solved {percent(first.success.value)} of {first.success.n} trials"
    return (
        f"{alike_said(only)}: it {rate} at every {only.axis.name}."
        if only.blind
        else f"{subject_of(only).first} {rate}."
    )


def heeding_baselines(summary: StudySummary) -> tuple[AgentSummary, ...]:
    """Baselines beside the agents that the study is about that act by what they are told, and were tested."""
    subjects = summary.subjects
    return tuple(one for one in summary.agents if one not in subjects and one.contrast and not one.blind)


def is_changed(agent: AgentSummary) -> bool:
    """Whether an effect on its success was detected at any dose."""
    return agent.contrast is not None and agent.contrast.detectable


def changed_baselines(summary: StudySummary) -> list[AgentSummary]:
    """The baselines on whose success an effect was detected."""
    return [agent for agent in heeding_baselines(summary) if is_changed(agent)]


def baselines_answer(summary: StudySummary) -> str:
    """What false reports, or another dose, did to the success of baselines; empty where nothing was detected.

    After a sentence that begins with the same cause it says "they".
    """
    changed, first = changed_baselines(summary), capital(cause(summary.axis))
    said = _changes(changed, summary.axis, baselines=True) if changed else ""
    repeats = said.startswith(first) and flips_answer(summary).startswith(f"{first} ")
    return f"They{said.removeprefix(first)}" if repeats else said


def all_broken_said(broken: Mapping[str, int]) -> str:
    """That all trials of these agents ended as an error; empty without any.

    >>> all_broken_said({"a": 8}), all_broken_said({"a": 8, "b": 1})
    ('All 8 trials of a ended as an error.', 'All trials of a and b ended as an error.')
    """
    if not broken:
        return ""
    trials = [*broken.values()]
    which = "All" if len(trials) > 1 else f"All {trials[0]}" if trials[0] > 1 else "The only"
    trial = f"trial{'s' * (sum(trials) > 1)}"
    return f"{which} {trial} of {_listed([Subject.of(agent).name for agent in broken])} ended as an error."


def _leaders(agents: Sequence[AgentSummary], pairs: Sequence[AgentComparison]) -> str:
    """Who solved the most, all of them in a tie, and how many agents may be the best by the comparisons of pairs."""
    shares = {agent.name: next(one for one in agent.conditions if one.success.n) for agent in agents}
    most = max(Fraction(one.success.count, one.success.n) for one in shares.values())
    best = {name: one for name, one in shares.items() if Fraction(one.success.count, one.success.n) == most}
    numbers = sorted({one.success.n for one in best.values()})
    of = f"{percent(float(most))} of {numbers[0]}{f' to {numbers[-1]}' if len(numbers) > 1 else ''} trials"
    if len(best) == len(agents):
        return f"The {len(agents)} agents solved the same share: {of}."
    between = [one for one in pairs if one.among == "subjects"]
    worse = {one.first if one.verdict > 0 else one.second for one in between if one.verdict}
    possible = len({name for one in between for name in (one.first, one.second)} - worse)
    open_ = f"; by the comparisons of pairs any of {possible} may be the best" if possible > len(best) else ""
    return f"Of {len(agents)} agents {_listed([*best])} solved the most: {of}{' each' * (len(best) > 1)}{open_}."


def _undetected(effect: str, differences: Iterable[DifferenceAt | Paired], what: str = "changes") -> str:
    """That no effect was detected, and up to which size intervals hold one, if that is not small."""
    most = _not_excluded(differences)
    if not most:
        return f"No effect of {effect} was detected."
    return f"Inconclusive: no effect of {effect} was detected, and {what} of up to {most} points are not excluded."


def _not_excluded(differences: Iterable[DifferenceAt | Paired]) -> int:
    """The largest change in points that intervals hold; 0 if it is small."""
    most = round(100 * max((abs(end) for one in differences for end in (one.low, one.high)), default=0.0))
    return most if most > 100 * NARROW else 0


def _done_to(agent: AgentSummary) -> str:
    """What its clearest difference says was done to its success; empty if none was detected."""
    if agent.contrast is None or not agent.contrast.detectable:
        return ""
    return _DOES[agent.contrast.difference.value < 0]


def _changes(agents: Sequence[AgentSummary], axis: Axis, *, baselines: bool = False) -> str:
    """The agents by what was done to their success, with their rates where the sentence stays short."""
    hidden = [agent for agent in agents if not is_changed(agent)]
    differences = [agent.contrast.difference for agent in hidden if agent.contrast]
    if len(hidden) == len(agents):
        return _undetected(f"{cause(axis)} on the success of {_names(hidden, 'or')}", differences)
    rest = f"; no effect on that of {_names(hidden, 'or')} was detected" if hidden else ""
    most = _not_excluded(differences)
    open_ = f" (within ±{most} points)" if most else ""
    said = ""
    for name in (_with_rates, lambda agent: subject_of(agent).name):
        changed = {does: [name(agent) for agent in agents if _done_to(agent) == does] for does in _DOES}
        parts = [
            f"{does} the success of " + f"the baseline{'s' * (len(own) > 1)} " * baselines + _listed(own)
            for does, own in changed.items()
            if own
        ]
        said = f"{capital(cause(axis))} {'; they '.join(parts)}{rest}"
        if len(said.split()) <= _WORDS:
            break
    return f"{said}{open_}."


def _with_rates(agent: AgentSummary) -> str:
    """Its name, and the two rates of a detected contrast."""
    name, contrast = subject_of(agent).name, agent.contrast
    if contrast is None or not contrast.detectable:
        return name
    first, second = contrast.difference.first, contrast.difference.second
    sample = "" if contrast.whole else f", of the {first.n} trials finished under both"
    where = at_dose(contrast.other.dose, agent.axis)
    return f"{name} ({percent(first.value)} to {percent(second.value)} {where}{sample})"


def interaction_said(summary: StudySummary) -> str:
    """Whether a detected effect differs from those that were not detected; empty without such a pair of agents."""
    detected = {(one.agent, one.modality): is_changed(one) for one in summary.subjects if not one.blind}
    tested = [
        (pair, pair.interaction, pair.interaction.p_adjusted)
        for pair in summary.comparisons
        if pair.interaction is not None
        and pair.interaction.p_adjusted is not None
        and {detected.get(pair.first), detected.get(pair.second)} == {True, False}
    ]
    if not tested:
        return ""
    names = {key: one.name for key, one in subjects_by_name(summary).items()}
    if len(tested) == 1:
        ((pair, found, p),) = tested
        first, second, gap = names[pair.first], names[pair.second], found.clearest.change
        return (
            f"{'A' if p < ALPHA else 'No'} difference in effect between {first} and {second} was detected, from a "
            f"{summary.axis.name} of {found.lowest:g} to {found.clearest.dose:g} (change of {second} minus that of "
            f"{first}: {change(gap.value, gap.low, gap.high)}; {p_value(p)}; {gap.blocks} trials that both finished)."
        )
    others: dict[str, tuple[list[str], list[str]]] = {}
    for pair, found, p in tested:
        affected, other = sorted((pair.first, pair.second), key=lambda agent: not detected[agent])
        unlike, rest = others.setdefault(names[affected], ([], []))
        if p < ALPHA:
            unlike.append(f"{names[other]} ({at_dose(found.clearest.dose, summary.axis)})")
        else:
            rest.append(names[other])
    agents: dict[tuple[tuple[str, ...], tuple[str, ...]], list[str]] = {}
    for affected_name, (unlike, rest) in others.items():
        agents.setdefault((tuple(unlike), tuple(rest)), []).append(affected_name)
    return " ".join(_differs(own, unlike, rest) for (unlike, rest), own in agents.items())


def _differs(affected: Sequence[str], unlike: Sequence[str], rest: Sequence[str]) -> str:
    """From which effects those on some agents were found to differ, and from which not."""
    those = _listed(rest, "or") if rest else ""
    if not unlike:
        return f"No difference in effect between {_listed(affected, 'or')} and {those} was detected."
    effects = f"The effect{'s' * (len(affected) > 1)} on {_listed(affected)}"
    open_ = f"; no difference from that on {those} was detected" if rest else ""
    return f"{effects} {'were' if affected[1:] else 'was'} found to differ from that on {_listed(unlike)}{open_}."


def _listed(names: Sequence[str], last: str = "and") -> str:
    return listed(names, last, _NAMED)


def _names(agents: Iterable[AgentSummary], last: str = "and") -> str:
    return _listed([subject_of(agent).name for agent in agents], last)


def not_above_chance(summary: StudySummary) -> str:
    """Agents without a detected advantage over random agents without immediate repeats, in their first condition."""
    counted = [
        (subject_of(agent).name, first)
        for agent in summary.subjects
        if (first := next((one for one in agent.conditions if one.success.n), None)) is not None
    ]
    if summary.reference is None or not counted:
        return ""
    by_chance = summary.reference.no_repeat[len(counted[0][1].curve.share) - 1]
    where = at_dose(counted[0][1].dose, summary.axis)
    return no_advantage_said({name: first.success for name, first in counted}, where, by_chance)


def no_advantage_said(shares: Mapping[str, Proportion | ClusteredProportion], where: str, by_chance: float) -> str:
    """Which agents solve fewer boxes than random agents without immediate repeats, and which may solve as many.

    Empty if all solve more. With several agents intervals hold for all of them at once, since the sentence also says
    of those that it does not name that they exceed chance. They are exact: of few trials, or near 0 and 1, Wilson's
    say *fewer* too often.

    Args:
        shares: Agent -> its success.
        where: Under which reports.
        by_chance: Success of the random agents, [0, 1].
    """
    found = {name: _of_all(one, len(shares)) for name, one in shares.items()}
    below = [name for name, one in found.items() if one.high < by_chance]
    rest = [name for name, one in found.items() if one.low <= by_chance <= one.high]
    random = f"random agents without immediate repeats ({percent(by_chance)})"
    undetected = f"was detected for {_listed(rest, 'or')}" if rest else ""
    if below:
        first = below[0]
        rates = {name: f"{percent(found[name].value)}, {_ends(found[name])}" for name in below}
        rates[first] = f"{percent(found[first].value)}, {_kind(found[first], len(shares))} {_ends(found[first])}"
        fewer = _listed([f"{name} ({rate})" for name, rate in rates.items()])
        open_ = f"; no difference from them {undetected}" if rest else ""
        return f"{capital(where)}, {fewer} solved fewer boxes than {random}{open_}."
    return f"{capital(where)}, no difference from {random} {undetected}." if rest else ""


def _kind(one: Proportion | ClusteredProportion, agents: int) -> str:
    """What the interval is by which a share was compared."""
    if isinstance(one, ClusteredProportion):
        return "95 % interval"
    exact = "exact " * (not isinstance(one, SequentialShare))
    return f"{'simultaneous ' * (agents > 1)}{exact}95 % interval"


def _ends(one: Proportion | ClusteredProportion) -> str:
    return range_of(one.low, one.high)


def _of_all(one: Proportion | ClusteredProportion, agents: int) -> Proportion | ClusteredProportion:
    """The share with the exact interval for one of several agents; clustered intervals of people stay as they are.

    An interval that holds at every look holds then for all agents at once.
    """
    if isinstance(one, SequentialShare):
        return one.at_level(1 - ALPHA / agents)
    if isinstance(one, Proportion) and one.broken:  # bounds: broken trials as failed, and as solved
        ends = [
            proportion(count, one.n + one.broken, 1 - ALPHA / agents, "exact")
            for count in (one.count, one.count + one.broken)
        ]
        return replace(one, low=ends[0].low, high=ends[1].high)
    alone = proportion(one.count, one.n)
    if (alone.low, alone.high) != (one.low, one.high):
        return one
    return proportion(one.count, one.n, 1 - ALPHA / agents, "exact")


def modality_answer(effect: ModalityEffect) -> str:
    """What the modality did to how soon one agent solves the box."""
    who = Subject.of(effect.agent)
    solves, it, sees = who.form("solves", "solve"), who.form("it", "they"), who.form("sees", "see")
    if effect.detectable:
        sooner = "sooner" if effect.direction > 0 else "later or more rarely"
        return f"The higher the fidelity of what {who.name} {sees}, the {sooner} {it} {solves} the box."
    if any(pair.p_adjusted is not None and pair.p_adjusted < ALPHA for pair in effect.pairs):
        return f"How soon {who.name} {solves} the box differs between {_listed([*map(spoken, effect.modalities)])}."
    finals = [pair.final for pair in effect.pairs]
    return _undetected(f"fidelity on how soon {who.name} {solves} the box", finals, "differences in success")


def effects_answer(found: Sequence[Effects], *, other: bool = False, shown: str = "", many: int = 1) -> str:
    """What conditions did to the success of the agents that the study is about, against their control.

    Args:
        found: Their effects.
        other: Whether there are conditions that these effects leave out: flip rates, or some that changed nothing.
        shown: How the box was shown, where conditions of several modalities are judged apart; else empty.
        many: For how many questions their P values are corrected further.
    """
    every = [one for own in found for one in own.effects]
    said = [f"{did} the success of {Subject.of(own.agent).name}" for own in found if (did := _did(own.effects, many))]
    if said:
        more = len(said) - _NAMED
        said = [*said[:_NAMED], f"effects on {more} more agent{'s' * (more > 1)} were detected"] if more > 0 else said
        rest = sum(one.difference.p_value * many >= ALPHA for one in every)
        others = f"; no effect of {rest} other{'s' * (rest > 1)} was detected" if rest and len(found) == 1 else ""
        return f"{'; '.join(said)}{others}."
    if not every:
        return "No two conditions have a trial in common yet."
    what = f"any {'other ' * other}condition{shown and f' with {shown}'} on success"
    if found[0].family == CONTROLS:
        what = "the modality on success"
    elif len(found) == 1:
        conditions = _listed([one.condition for one in every], "or")
        what = f"{conditions} on the success of {Subject.of(found[0].agent).name}"
    return _undetected(what, [one.difference for one in every])


def _did(effects: Sequence[Effect], many: int) -> str:
    """Which conditions raise success, and which lower it; empty without any."""
    clear = [one for one in effects if one.difference.p_value * many < ALPHA]
    ways = {
        "raise": [one.condition for one in clear if one.difference.value > 0],
        "lower": [one.condition for one in clear if one.difference.value < 0],
    }
    return " and ".join(f"{_listed(own)} {way}{'s' * (len(own) == 1)}" for way, own in ways.items() if own)
