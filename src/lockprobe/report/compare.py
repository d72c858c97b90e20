"""Studies side by side: success of every agent under the conditions that they share, differences, and ``compare.html``.

Agents and conditions are matched by what acts, whatever it is called. Studies of one seed share their luck: trials of
equal repetition and number are compared in pairs. Others, and people, are independent samples. P values are corrected
(Holm) for the differences of one kind under the conditions of one family. The page is one file without scripts.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from importlib.metadata import version
from itertools import combinations
from pathlib import Path
from typing import Any

from lockprobe.foundation.errors import BadFile, UnknownName
from lockprobe.foundation.formatting import change, count, p_value, percent
from lockprobe.foundation.storage.atomic_file import write_file
from lockprobe.report.format import tested
from lockprobe.report.opened import open_study
from lockprobe.report.prose import rules_broken_said, who
from lockprobe.report.rendering import rendered
from lockprobe.report.rows import measured_row
from lockprobe.report.section import Lines
from lockprobe.statistics.clustered import share_of
from lockprobe.statistics.course import is_baseline
from lockprobe.statistics.differences import DifferenceAt, each_difference, independent_difference
from lockprobe.statistics.distributions import holm_by_family
from lockprobe.statistics.outcomes import Outcomes, outcomes
from lockprobe.statistics.proportions import ALPHA, Proportion
from lockprobe.statistics.rules import Rules
from lockprobe.studies.comparable import check_comparable, families, shared_names
from lockprobe.studies.decisions import planned_now
from lockprobe.trial.record import Trial

_KINDS = ("between", "between-baselines", "within", "within-baselines")
"""Whether two sides belong to different studies or to one, and whether one of them is a baseline."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Sample:
    """The trials of one side under one condition, broken ones too.

    Attributes:
        prompt: The file of the agent's prompt, if any.
        condition: Its name, equal in all studies that have it.
        luck: Seed of the study: trials of equal luck, repetition and number share labels, flips and draws.
        family: The axis on which the condition lies; empty for all conditions on none.
    """

    study: str
    agent: str
    prompt: str = ""
    condition: str
    luck: int
    trials: Sequence[Trial]
    family: str = ""

    @property
    def side(self) -> tuple[str, str, str]:
        """Study, agent and prompt."""
        return self.study, self.agent, self.prompt

    @property
    def called(self) -> str:
        """What sentences and tables call its agent."""
        return who(self.agent) + (f" with {self.prompt}" if self.prompt else "")

    @property
    def baseline(self) -> bool:
        """Whether the agent is a baseline."""
        return bool(self.trials) and is_baseline(self.trials[0].spec)

    @cached_property
    def outcomes(self) -> Outcomes:
        """Its trials as columns."""
        return outcomes(self.trials)

    @cached_property
    def success(self) -> Proportion:
        """The share solved, with an interval that holds whatever became of broken trials."""
        every = self.outcomes
        return share_of(every.known, every.player, every.luck, every.box)

    def plain(self, share: Proportion) -> dict[str, Any]:
        """The side as JSON holds it, with a share of its trials."""
        value = share.value if share.n else None
        solved = {"solved": share.count, "trials": share.n, "broken": share.broken, "success": value}
        names = {"study": self.study, "agent": self.agent, "prompt": self.prompt}
        return names | solved | {"success_low": share.low, "success_high": share.high}


@dataclass(frozen=True, kw_only=True)
class StudyDifference:
    """The difference in success between two sides under one condition, second minus first.

    ``paired`` is whether trials of equal luck are compared in pairs. Of what was ``found`` the interval is at 95 %, and
    the P value is corrected.
    """

    kind: str
    first: Sample
    second: Sample
    paired: bool
    found: DifferenceAt

    @property
    def family(self) -> tuple[str, str]:
        """What its P value is corrected with."""
        return self.kind, self.first.family

    @property
    def trials(self) -> str:
        """How many were compared."""
        first, second = self.found.first.n, self.found.second.n
        return f"{first} pairs" if self.paired else f"{second} and {first} trials"

    def plain(self) -> dict[str, Any]:
        """The difference as JSON holds it."""
        found, sides = self.found, ((self.first, self.found.first), (self.second, self.found.second))
        numbers = {name: getattr(found, name) for name in ("value", "low", "high", "p_value")}
        of = {"condition": self.first.condition, "family": self.first.family, "kind": self.kind, "paired": self.paired}
        first, second = (side.plain(share) for side, share in sides)
        return of | {"first": first, "second": second} | numbers | {"detected": found.detected()}


@dataclass(frozen=True, kw_only=True)
class Comparison:
    """Studies side by side.

    Attributes:
        box: Name of the box.
        studies: In the order asked for, as JSON holds them. The name is the end of a directory's path by which it is
            told from the others; conditions that no other study has (``not_shared``) are in no number.
        samples: Every side under every shared condition that it has played.
        differences: Every two sides under every condition that both have, those between studies first.
        unlike: What differs between agents of one spec in several studies, a line each.
        rules: What broke the rules of the box, in a sentence; empty if nothing did.
    """

    box: str
    studies: tuple[dict[str, Any], ...]
    samples: tuple[Sample, ...]
    differences: tuple[StudyDifference, ...]
    unlike: tuple[str, ...] = ()
    rules: str = ""

    @property
    def said(self) -> str:
        """The conclusion in a sentence."""
        return " ".join(filter(None, (conclusion(self.differences), self.rules)))

    @property
    def leading(self) -> tuple[StudyDifference, ...]:
        """The differences that the conclusion is about: those of the first kind that there is."""
        return tuple(one for one in self.differences if one.kind == self.differences[0].kind)

    def plain(self) -> dict[str, Any]:
        """The comparison as JSON holds it."""
        return {
            "lockprobe": version("lockprobe"),
            "box": self.box,
            "said": self.said,
            "studies": [*self.studies],
            "success": [one.plain(one.success) | {"condition": one.condition} for one in self.samples],
            "differences": [one.plain() for one in self.differences],
            "unlike": [*self.unlike],
        }


def compare_studies(directories: Sequence[Path], agents: Sequence[str] = ()) -> Comparison:
    """Compare the studies in several directories.

    Args:
        directories: Two or more, each of another study.
        agents: Agents to compare, as pages call them; all if none are given.

    Raises:
        BadFile: If a directory is given twice or is that of no study, or if studies cannot be compared.
        BadValue: If there are fewer than two.
        UnknownName: If no study has such an agent.
    """
    resolved = [directory.resolve() for directory in directories]
    for directory, path in zip(directories, resolved, strict=True):
        if resolved.count(path) > 1:
            raise BadFile(directory, "given twice; a study is compared with others")
    opened = [open_study(directory) for directory in directories]
    check_comparable({directory: one.study for directory, one in zip(directories, opened, strict=True)})
    known = dict.fromkeys(agent for one in opened for agent in one.study.labels)
    for agent in agents:
        if agent not in known:
            raise UnknownName("agent of these studies", agent, known)
    own = [shared_names(one.study) for one in opened]
    times = Counter(name for conditions in own for name in {shared.name for shared in conditions.values()})
    every = {shared.name: shared for conditions in own for shared in conditions.values() if times[shared.name] > 1}
    family = families(every.values())
    ends = [["/".join(path.parts[-n:]) for n in range(1, len(path.parts) + 1)] for path in resolved]
    studies, samples = [], []
    for one, conditions, paths in zip(opened, own, ends, strict=True):
        name = next(end for end in paths if sum(end in other for other in ends) == 1)
        left = dict.fromkeys(shared.name for shared in conditions.values() if shared.name not in family)
        finished, planned = one.finished, planned_now(one.study, one.trials)
        is_open = finished + sum(one.broken.values()) < planned
        studies.append(
            {"name": name, "study": one.study.name, "seed": one.study.seed, "agents": [*one.study.labels]}
            | {"planned": planned, "finished": finished, "people_trials": one.finished_by_people}
            | {"not_shared": [*left], "looked_at": bool(one.every_look), "partial": is_open}
        )
        played: dict[tuple[str, str, str], list[Trial]] = {}
        for trial in one.trials:
            shared = conditions[one.study.labelled(trial.condition)]
            if shared.name in family and trial.group in (agents or known):
                played.setdefault((shared.name, trial.group, shared.prompt), []).append(trial)
        samples += [
            Sample(
                study=name, agent=agent, prompt=prompt, condition=acting, luck=one.study.seed, trials=trials,
                family=family[acting],
            )
            for (acting, agent, prompt), trials in played.items()
        ]  # fmt: skip
    samples.sort(key=lambda one: [*family].index(one.condition))
    rules = Rules(*opened[0].study.boxes).broken(trial for one in samples for trial in one.trials)
    return Comparison(
        box=opened[0].study.boxes_in_words,
        studies=tuple(studies),
        samples=tuple(samples),
        differences=study_differences(samples),
        unlike=tuple(_unlike(samples)),
        rules=rules_broken_said(*rules),
    )


def study_differences(samples: Sequence[Sample]) -> tuple[StudyDifference, ...]:
    """Pairwise differences of the samples of each condition, corrected within each kind and family (Holm).

    They come by kind (differences between studies first), pair and condition. Pairs without a trial to compare are left
    out. Each side is at most once per condition; the order decides which side of a pair comes first.
    """
    every_baseline = all(one.baseline for one in samples)
    pairs: dict[tuple[object, object], list[StudyDifference]] = {}
    for first, second in combinations(samples, 2):
        if first.condition == second.condition:
            beside = not every_baseline and (first.baseline or second.baseline)
            kind = _KINDS[2 * (first.study == second.study) + beside]
            one, two, same_luck = first.outcomes, second.outcomes, first.luck == second.luck
            paired = same_luck and not (one.crossed or two.crossed)
            found = [at for _, at in each_difference([one, two])] if paired else []
            if not paired and (apart := independent_difference(one, two, same_luck=same_luck)):
                found = [apart]
            pairs.setdefault((first.side, second.side), []).extend(
                StudyDifference(kind=kind, first=first, second=second, paired=paired, found=at) for at in found
            )
    every = [one for rows in pairs.values() for one in rows]
    corrected = holm_by_family([one.family for one in every], [one.found.p_value for one in every])
    adjusted = [
        replace(one, found=replace(one.found, p_value=p))
        for one, p in zip(every, corrected, strict=True)
        if p is not None
    ]
    return tuple(sorted(adjusted, key=lambda one: _KINDS.index(one.kind)))


def _unlike(samples: Sequence[Sample]) -> Iterator[str]:
    """Facts about agents of one spec that differ between studies."""
    first: dict[str, dict[str, Trial]] = {}
    for one in samples:
        if not (trial := one.trials[0]).player:
            first.setdefault(trial.spec, {}).setdefault(one.study, trial)
    for by_study in first.values():
        for fact in dict.fromkeys(name for trial in by_study.values() for name in trial.facts):
            values = {study: trial.facts.get(fact) for study, trial in by_study.items()}
            if len(set(map(repr, values.values()))) > 1:
                each = ", ".join(f"{value} in {study}" for study, value in values.items())
                yield f"{next(iter(by_study.values())).group}: {fact} is {each}"


def conclusion(found: Sequence[StudyDifference]) -> str:
    """How many differences between studies were detected, and the clearest of them.

    The sentence is about all families of conditions, so it is corrected for their number too (Bonferroni).
    """
    if not found or not found[0].kind.startswith("between"):
        return "No two studies have a trial to compare under a condition that they share."
    asked = [one for one in found if one.kind == found[0].kind]
    sizes = Counter(one.family for one in asked)
    shown = [one for one in asked if one.found.detected(ALPHA / len(sizes))]
    one = min(shown or asked, key=lambda one: (one.found.p_value, -abs(one.found.value)))
    first, second, at = one.first, one.second, one.found
    sample = f"{one.trials} with common random numbers" if one.paired else f"{one.trials}, independent samples"
    worst = ", whatever became of broken trials" * (at.bounds is not None)
    what = "baselines of different studies" if one.kind == "between-baselines" else "studies"
    none = f"No difference between {what} was detected in {count(len(asked), 'comparison')}, which does not show that "
    some = f"{len(shown)} of {len(asked)} differences between {what} {'was' if len(shown) == 1 else 'were'} detected"
    return (
        f"{some if shown else f'{none}there is none'}, the clearest: {second.called} in {second.study} against "
        f"{first.called} in {first.study} under {first.condition}, {percent(at.second.value)} against "
        f"{percent(at.first.value)} ({change(at.value, at.low, at.high)}; "
        f"{p_value(min(1.0, len(sizes) * at.p_value))}, corrected for {count(sizes[one.family], 'difference')} of a "
        f"family and {count(len(sizes), 'family', 'families')}{worst}; {sample})."
    )


def write_comparison(comparison: Comparison, out: Path) -> Path:
    """Write the page in one step.

    Raises:
        BadFile: If it cannot be written.
    """
    tables = {
        "studies": [*study_table(comparison)],
        "success": [*success_table(comparison)],
        "differences": [*difference_table(comparison.leading)],
        "rest": [*difference_table(comparison.differences[len(comparison.leading) :])],
    }
    page = rendered("compare", content=comparison, lockprobe=version("lockprobe"), tables=tables)
    try:
        write_file(out, page)
    except OSError as error:
        raise BadFile(out, f"cannot be written ({error.strerror})") from error
    return out


def study_table(comparison: Comparison) -> Lines:
    """The studies: their seeds and their finished trials."""
    yield ["study", "name", "seed", "trials finished", "of these, people's", "conditions in no other study"]
    for one in comparison.studies:
        finished = f"{one['finished']} of {one['planned']}" + " (partial)" * one["partial"]
        left = ", ".join(one["not_shared"]) or None
        yield [one["name"], one["study"], str(one["seed"]), finished, str(one["people_trials"]), left]


def success_table(comparison: Comparison) -> Lines:
    """Success by condition, study and agent; broken trials."""
    yield ["condition", "study", "agent", "solved", "success", "broken"]
    for one, share in ((one, one.success) for one in comparison.samples):
        row, solved = measured_row("success", share), f"{share.count}/{share.n}"
        yield [one.condition, one.study, one.called, solved, row, str(share.broken)]


def difference_table(found: Sequence[StudyDifference]) -> Lines:
    """The differences, the first agent minus the second."""
    head = ["agent", "compared with", "condition", "trials", "success", "success of the other", "difference, points"]
    yield [*head, "P", "conclusion"]
    for one in found:
        sides = [f"{side.called} in {side.study}" for side in (one.second, one.first)]
        shares = percent(one.found.second.value), percent(one.found.first.value)
        row = measured_row("success_difference", one.found, unit="points")
        yield [*sides, one.first.condition, one.trials, *shares, *tested(row)]
