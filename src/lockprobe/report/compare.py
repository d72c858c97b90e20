"""Studies side by side: success of every agent under the conditions that they share, differences, and ``compare.html``.

The page is one file without scripts. Agents and conditions are matched by what acts, whatever it is called.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import Any

from pydantic_core import to_jsonable_python

from lockprobe.foundation.errors import BadFile, UnknownName
from lockprobe.foundation.formatting import change, count, p_cell, p_value, percent
from lockprobe.foundation.storage.atomic_file import write_file
from lockprobe.report.format import conclusion_of
from lockprobe.report.opened import open_study
from lockprobe.report.prose import rules_broken_said, who
from lockprobe.report.rendering import rendered
from lockprobe.report.rows import measured_row
from lockprobe.report.section import Lines
from lockprobe.statistics.proportions import ALPHA, Proportion
from lockprobe.statistics.rules import Rules
from lockprobe.statistics.studies_compared import Sample, Side, StudyDifference, study_differences
from lockprobe.studies.comparable import check_comparable, families, shared_names
from lockprobe.studies.decisions import planned_now
from lockprobe.trial.record import Trial

_plain = partial(to_jsonable_python, inf_nan_mode="null")


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
        """The comparison as JSON holds it; a side is its study, its agent, its prompt and its share."""

        def of(side: Side, found: Proportion) -> dict[str, Any]:
            share = {"solved": found.count, "trials": found.n, "success": _plain(found.value)}
            return side._asdict() | share | {"success_low": found.low, "success_high": found.high}

        success = [(one, one.success) for one in self.samples]
        return {
            "lockprobe": version("lockprobe"),
            "box": self.box,
            "said": self.said,
            "studies": [*self.studies],
            "success": [
                of(one.side, found) | {"condition": one.condition, "broken": found.broken} for one, found in success
            ],
            "differences": [
                {name: value for name, value in _plain(one).items() if not name.endswith("_success")}
                | {"first": of(one.first, one.first_success), "second": of(one.second, one.second_success)}
                | {"detected": one.detected}
                for one in self.differences
            ],
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
        played: dict[tuple[str, Side], list[Trial]] = {}
        for trial in one.trials:
            shared = conditions[one.study.labelled(trial.condition)]
            if shared.name in family and trial.group in (agents or known):
                played.setdefault((shared.name, Side(name, trial.group, shared.prompt)), []).append(trial)
        samples += [
            Sample(side=side, condition=condition, luck=one.study.seed, trials=trials, family=family[condition])
            for (condition, side), trials in played.items()
        ]
    samples.sort(key=lambda one: [*family].index(one.condition))
    return Comparison(
        box=opened[0].study.boxes_in_words,
        studies=tuple(studies),
        samples=tuple(samples),
        differences=study_differences(samples),
        unlike=tuple(_unlike(samples)),
        rules=rules_broken_said(
            *Rules(*opened[0].study.boxes).broken(trial for one in samples for trial in one.trials)
        ),
    )


def _unlike(samples: Sequence[Sample]) -> Iterator[str]:
    """Facts about agents of one spec that differ between studies."""
    first: dict[str, dict[str, Trial]] = {}
    for one in samples:
        if not (trial := one.trials[0]).player:
            first.setdefault(trial.spec, {}).setdefault(one.side.study, trial)
    for by_study in first.values():
        for fact in dict.fromkeys(name for trial in by_study.values() for name in trial.facts):
            values = {study: trial.facts.get(fact) for study, trial in by_study.items()}
            if len(set(map(repr, values.values()))) > 1:
                each = ", ".join(f"{value} in {study}" for study, value in values.items())
                yield f"{next(iter(by_study.values())).group}: {fact} is {each}"


def _named(side: Side) -> str:
    """What sentences and tables call the agent of a side."""
    return who(side.agent) + (f" with {side.prompt}" if side.prompt else "")


def conclusion(found: Sequence[StudyDifference]) -> str:
    """How many differences between studies were detected, and the clearest of them.

    The sentence is about all families of conditions, so it is corrected for their number too (Bonferroni).
    """
    if not found or not found[0].kind.startswith("between"):
        return "No two studies have a trial to compare under a condition that they share."
    asked = [one for one in found if one.kind == found[0].kind]
    sizes = Counter(one.family for one in asked)
    shown = [one for one in asked if one.detected and len(sizes) * one.p_adjusted < ALPHA]
    one = min(shown or asked, key=lambda one: (one.p_adjusted, -abs(one.value)))
    first, second = one.first_success, one.second_success
    sample = f"{first.n} pairs of trials with common random numbers"
    sample = sample if one.paired else f"{second.n} and {first.n} trials, independent samples"
    worst = ", whatever became of broken trials" * bool(one.broken)
    what = "baselines of different studies" if one.kind == "between-baselines" else "studies"
    none = f"No difference between {what} was detected in {count(len(asked), 'comparison')}, which does not show that "
    some = f"{len(shown)} of {len(asked)} differences between {what} {'was' if len(shown) == 1 else 'were'} detected"
    return (
        f"{some if shown else f'{none}there is none'}, the clearest: "
        f"{_named(one.second)} in {one.second.study} against {_named(one.first)} in {one.first.study} under "
        f"{one.condition}, {percent(second.value)} against {percent(first.value)} "
        f"({change(one.value, one.low, one.high)}; {p_value(min(1.0, len(sizes) * one.p_adjusted))}, corrected for "
        f"{count(sizes[one.family], 'difference')} of a family and {count(len(sizes), 'family', 'families')}{worst}; "
        f"{sample})."
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
        yield [one.condition, one.side.study, _named(one.side), solved, row, str(share.broken)]


def difference_table(found: Sequence[StudyDifference]) -> Lines:
    """The differences, the first agent minus the second."""
    head = ["agent", "compared with", "condition", "trials", "success", "success of the other", "difference, points"]
    yield [*head, "P", "corrected P", "conclusion"]
    for one in found:
        first, second = one.first_success, one.second_success
        row = measured_row("success_difference", one, unit="points", p_value=one.p_adjusted)
        sides = [f"{_named(side)} in {side.study}" for side in (one.second, one.first)]
        trials = f"{first.n} pairs" if one.paired else f"{second.n} and {first.n} trials"
        shares = percent(second.value), percent(first.value), row, p_cell(one.p_value)
        yield [*sides, one.condition, trials, *shares, p_cell(one.p_adjusted), conclusion_of(row)]
