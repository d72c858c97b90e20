"""Studies side by side: success of every agent under the conditions that they share, differences, and ``compare.html``.

The page is one file without scripts. Agents and conditions are matched by what acts, whatever it is called.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from importlib.metadata import version
from pathlib import Path
from typing import Any

from lockprobe.foundation.errors import BadFile, UnknownName
from lockprobe.foundation.formatting import NONE, bracketed, change, p_cell, p_value, percent
from lockprobe.foundation.left_out import LeftOutSection, leaving_out, section
from lockprobe.foundation.storage.atomic_file import write_file
from lockprobe.report.format import DETECTED, TextTable, share_cell
from lockprobe.report.opened import OpenedStudy, open_study
from lockprobe.report.plain_json import plain_json
from lockprobe.report.prose.robot import broken_said
from lockprobe.report.prose.subject import Subject
from lockprobe.report.rendering import rendered
from lockprobe.report.section import Caption
from lockprobe.report.svg import image
from lockprobe.statistics.agent_comparison.across_studies import Sample, Side, StudyDifference, study_differences
from lockprobe.statistics.broken_trials import begun
from lockprobe.statistics.clustered import share_of
from lockprobe.statistics.course import is_baseline
from lockprobe.statistics.outcomes import broken_off, outcomes
from lockprobe.statistics.proportions import ALPHA, Proportion
from lockprobe.studies.comparable import check_comparable, families, shared_names
from lockprobe.studies.stopping import planned_now
from lockprobe.trial.record import Trial

_VERSION = 1
"""Version of the layout of :meth:`Comparison.plain`."""

_SHOWN = 15
"""Differences that the figure has room for; those of the first pair are always shown."""

_CAPTION = Caption(
    "Difference in success between two agents, one row for each condition; filled marks were detected. Circles: pairs "
    "of trials with common random numbers; squares: independent samples.",
    "Bars are 95 % intervals and are not corrected. A difference is detected if the corrected test rejects and the "
    "interval excludes 0.",
)


@dataclass(frozen=True, slots=True, kw_only=True)
class ComparedStudy:
    """One study of a comparison.

    Attributes:
        name: The end of its directory's path by which it is told from the others; ``study`` is that in its settings.
        not_shared: Its conditions that no other study has; they are in no number.
        looked_at: Whether it is unfinished, was extended, or stops when it is decided.
    """

    name: str
    study: str
    seed: int
    agents: tuple[str, ...]
    planned: int
    finished: int
    people_trials: int
    not_shared: tuple[str, ...]
    looked_at: bool = False

    @property
    def partial(self) -> bool:
        """Whether trials are still owed."""
        return self.finished < self.planned


@dataclass(frozen=True, kw_only=True)
class Comparison:
    """Studies side by side.

    Attributes:
        box: Name of the box.
        studies: In the order asked for.
        success: Side, shared condition that it has played, and share solved; the interval holds whatever became of
            broken trials.
        differences: Every two sides under every condition that both have, those between studies first.
        unlike: What differs between agents of one spec in several studies, a line each.
        rules: What broke the rules of the box, in a sentence; empty if nothing did.
    """

    box: str
    studies: tuple[ComparedStudy, ...]
    success: tuple[tuple[Side, str, Proportion], ...]
    differences: tuple[StudyDifference, ...]
    unlike: tuple[str, ...]
    rules: str = ""

    @property
    def said(self) -> str:
        """The conclusion in a sentence."""
        return " ".join(filter(None, (conclusion(self.differences, self.subjects), self.rules)))

    @property
    def leading(self) -> tuple[StudyDifference, ...]:
        """The differences that the conclusion is about: those of the first kind that there is."""
        return tuple(one for one in self.differences if one.kind == self.differences[0].kind)

    @cached_property
    def subjects(self) -> dict[Side, Subject]:
        """What sentences call each side."""
        return {side: _subject(side, self.studies[side.study].name) for side, _, _ in self.success}

    def plain(self) -> dict[str, Any]:
        """The comparison as JSON holds it."""

        def named(role: str, side: Side, found: Proportion) -> dict[str, Any]:
            of = {"study": self.studies[side.study].name, "agent": side.agent, "prompt": side.prompt}
            share = {"solved": found.count, "trials": found.n, "success": plain_json(found.value)}
            share |= {"success_low": found.low, "success_high": found.high}
            return {f"{role}{name}": value for name, value in (of | share).items()}

        apart = ("first", "second", "first_success", "second_success")
        return {
            "schema_version": _VERSION,
            "lockprobe": version("lockprobe"),
            "box": self.box,
            "said": self.said,
            "studies": [plain_json(one) | {"partial": one.partial} for one in self.studies],
            "success": [
                named("", side, found) | {"condition": condition, "broken": found.broken}
                for side, condition, found in self.success
            ],
            "differences": [
                named("first_", one.first, one.first_success)
                | named("second_", one.second, one.second_success)
                | {name: value for name, value in plain_json(one).items() if name not in apart}
                | {"verdict": one.verdict}
                for one in self.differences
            ],
            "unlike": list(self.unlike),
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
    own = [{one.name: one for one in shared_names(study.study).values()} for study in opened]
    every = {name: one for names in own for name, one in names.items()}
    shared = families(one for name, one in every.items() if sum(name in names for names in own) > 1)
    studies = tuple(
        ComparedStudy(
            name=name,
            study=one.study.name,
            seed=one.study.seed,
            agents=one.study.labels,
            planned=planned_now(one.study, one.trials),
            finished=one.finished,
            people_trials=one.finished_by_people,
            not_shared=tuple(left for left in names if left not in shared),
            looked_at=bool(one.every_look),
        )
        for name, one, names in zip(_names(resolved), opened, own, strict=True)
    )
    samples, box = _samples(opened, shared, set(agents or known)), opened[0].study.box
    return Comparison(
        box=box.name,
        studies=studies,
        success=tuple((one.side, one.condition, _success(one)) for one in samples),
        differences=study_differences(samples),
        unlike=tuple(_unlike(samples, studies)),
        rules=broken_said((trial for one in samples for trial in one.trials), box),
    )


def _names(directories: Sequence[Path]) -> list[str]:
    """Of each path the shortest end that tells it from the others."""
    ends = [["/".join(path.parts[-n:]) for n in range(1, len(path.parts) + 1)] for path in directories]
    return [next(end for end in own if sum(end in other for other in ends) == 1) for own in ends]


def _samples(opened: Sequence[OpenedStudy], shared: Mapping[str, str], agents: set[str]) -> list[Sample]:
    """The trials of every side under every shared condition, by condition; none without trials."""
    order = list(shared)
    found: dict[tuple[str, Side], list[Trial]] = {}
    for number, one in enumerate(opened):
        names = shared_names(one.study)
        for trial in one.trials:
            condition = one.study.condition_of(trial)
            own = names[condition] if condition else None
            if own and own.name in shared and trial.group in agents:
                side = Side(number, trial.group, own.prompt)
                found.setdefault((own.name, side), []).append(trial)
    return [
        Sample(
            side=side,
            condition=name,
            family=shared[name],
            luck=opened[side.study].study.seed,
            baseline=is_baseline(trials[0].spec),
            trials=trials,
        )
        for (name, side), trials in sorted(found.items(), key=lambda one: (order.index(one[0][0]), one[0][1].study))
    ]


def _subject(side: Side, study: str) -> Subject:
    who, prompt = Subject.of(side.agent), f" with {side.prompt}" if side.prompt else ""
    return Subject(name=f"{who.name}{prompt} in {study}", plural=who.plural)


def _success(one: Sample) -> Proportion:
    every, solved = begun(outcomes(one.trials), broken_off(one.trials))
    return share_of(solved, every.player, every.luck, every.box)


def _unlike(samples: Sequence[Sample], studies: Sequence[ComparedStudy]) -> list[str]:
    """Facts about agents of one spec that differ between studies."""
    facts: dict[str, dict[int, Mapping[str, Any]]] = {}
    called: dict[str, str] = {}
    for one in samples:
        if not (first := one.trials[0]).player:
            called.setdefault(first.spec, one.side.agent)
            facts.setdefault(first.spec, {}).setdefault(one.side.study, first.facts)
    said = []
    for spec, by_study in facts.items():
        for fact in dict.fromkeys(name for own in by_study.values() for name in own):
            values = {studies[number].name: own.get(fact) for number, own in by_study.items()}
            if len({repr(value) for value in values.values()}) > 1:
                each = ", ".join(f"{value} in {name}" for name, value in values.items())
                said.append(f"{called[spec]}: {fact} is {each}")
    return said


def conclusion(found: Sequence[StudyDifference], names: Mapping[Side, Subject]) -> str:
    """How many differences between studies were detected, and the clearest of them.

    The sentence is about all families of conditions, so it is corrected for their number too (Bonferroni).
    """
    if not found or not found[0].kind.startswith("between"):
        return "No two studies have a trial to compare under a condition that they share."
    asked = [one for one in found if one.kind == found[0].kind]
    sizes = Counter(one.family for one in asked)
    shown = [one for one in asked if one.verdict and len(sizes) * one.p_adjusted < ALPHA]
    one = min(shown or asked, key=lambda one: (one.p_adjusted, -abs(one.value)))
    first, second, shares = names[one.first], names[one.second], (one.first_success, one.second_success)
    sample = f"{shares[0].n} pairs of trials with common random numbers"
    sample = sample if one.paired else f"{shares[1].n} and {shares[0].n} trials, independent samples"
    many, beside = sizes[one.family], f" of its family and for {len(sizes)} families of conditions" * (len(sizes) > 1)
    corrected = f", corrected for {many} difference{'s' * (many > 1)}{beside}" * (many > 1 or len(sizes) > 1)
    size = (
        f"{percent(shares[1].value)} against {percent(shares[0].value)} ({change(one.value, one.low, one.high)}; "
        f"{p_value(min(1.0, len(sizes) * one.p_adjusted))}{corrected}"
        f"{', whatever became of broken trials' * bool(one.broken)}; {sample})"
    )
    more = sum(bool(other.verdict) for other in asked) - len(shown)
    more_said = f" {more} more {'are' if more > 1 else 'is'} detected if each family is taken alone." * bool(more)
    what = "baselines of different studies" if one.kind == "between-baselines" else "studies"
    if not shown:
        among, which = (f" in {len(asked)} comparisons", "the clearest is") if len(asked) > 1 else ("", "it is")
        return (
            f"No difference between {what} was detected{among}, which does not show that there is none; {which} "
            f"{second.name} against {first.name} under {one.condition}: {size}.{more_said}"
        )
    often, solves = "more" if one.value > 0 else "less", second.form("solves", "solve")
    said = f"{solves} the box {often} often than {first.name} under {one.condition}: {size}."
    if len(asked) == 1:
        return f"{second.first} {said}"
    head = f"{len(shown)} of {len(asked)} differences between {what} {'was' if len(shown) == 1 else 'were'} detected"
    return f"{head}{', the clearest' * (len(shown) > 1)}: {second.name} {said}{more_said}"


def write_comparison(
    comparison: Comparison, out: Path, *, left_out: Callable[[LeftOutSection], None] = lambda section: None
) -> Path:
    """Write the page in one step; ``left_out`` is told every table and figure that could not be made.

    Raises:
        BadFile: If it cannot be written.
    """
    with leaving_out() as failed:
        page = _page(comparison, ())
        if failed:
            page = _page(comparison, failed)
    for one in failed:
        left_out(one)
    try:
        write_file(out, page)
    except OSError as error:
        raise BadFile(out, f"cannot be written ({error.strerror})") from error
    return out


def _page(comparison: Comparison, missing: Sequence[LeftOutSection]) -> str:
    first = comparison.leading
    picture = section("Figure differences", lambda: _picture(comparison), dict[str, bytes])
    tables: dict[str, Callable[[], TextTable]] = {
        "studies": lambda: study_table(comparison),
        "success": lambda: success_table(comparison),
        "differences": lambda: difference_table(comparison, first),
        "rest": lambda: difference_table(comparison, comparison.differences[len(first) :]),
    }
    return rendered(
        "compare",
        content=comparison,
        lockprobe=version("lockprobe"),
        images={"differences": image(picture["svg"])} if picture else {},
        caption=_CAPTION,
        tables={
            name: section(f"Table {name}", make, lambda: [["This table could not be made."]])
            for name, make in tables.items()
        },
        sections_left_out=missing,
    )


def _picture(comparison: Comparison) -> dict[str, bytes]:
    from lockprobe.report import figures

    return figures.files(draw(comparison))


def draw(comparison: Comparison) -> Any:
    """The differences that the conclusion is about, the pairs one below the other as far as there is room.

    Blue circles are pairs of trials, orange squares are independent samples. None without any.
    """
    from lockprobe.report.figures.differences import Panel, difference, panels_sheet
    from lockprobe.report.figures.frame import safe_name
    from lockprobe.report.figures.palette import ACCENT, SUBJECTS

    pairs: dict[tuple[Side, Side], list[StudyDifference]] = {}
    for one in comparison.leading:
        pairs.setdefault((one.first, one.second), []).append(one)
    made: list[Panel] = []
    for (first, second), found in pairs.items():
        if made and sum(len(one.rows) for one in made) + len(found) > _SHOWN:
            break
        looks = {True: (SUBJECTS[0], "o"), False: (ACCENT, "s")}
        rows = [
            difference(safe_name(one.condition, 46), one, detected=bool(one.verdict), colour=colour, marker=marker)
            for one in found
            for colour, marker in [looks[one.paired]]
        ]
        whom, versus = (safe_name(comparison.subjects[side].name, 46) for side in (second, first))
        made.append(Panel.of(rows, whom, f"\N{MINUS SIGN} {versus}", label=""))
    left = len(comparison.leading) - sum(len(one.rows) for one in made)
    made[-1:] = [replace(one, label="difference, points") for one in made[-1:]]
    return panels_sheet(made, 1, f"{left} more differences are in the tables" if left else "")


def study_table(comparison: Comparison) -> TextTable:
    """The studies: their seeds and their finished trials."""
    people = any(one.people_trials for one in comparison.studies)
    head = ["study", "name", "seed", "trials finished", *["of these, people's"] * people]
    rows = [[*head, "conditions in no other study"]]
    for one in comparison.studies:
        finished = f"{one.finished} of {one.planned}" + " (partial)" * one.partial
        by_people = [str(one.people_trials)] * people
        rows.append([one.name, one.study, str(one.seed), finished, *by_people, ", ".join(one.not_shared) or NONE])
    return rows


def success_table(comparison: Comparison) -> TextTable:
    """Success by condition, study and agent; broken trials where there are any."""
    broken = any(share.broken for _, _, share in comparison.success)
    rows = [["condition", "study", "agent", "solved", "success", *["broken"] * broken]]
    for side, condition, share in comparison.success:
        agent = side.agent + (f" with {side.prompt}" if side.prompt else "")
        counted = [f"{share.count}/{share.n}", share_cell(share), *[str(share.broken)] * broken]
        rows.append([condition, comparison.studies[side.study].name, agent, *counted])
    return rows


def difference_table(comparison: Comparison, found: Sequence[StudyDifference]) -> TextTable:
    """The differences, the first agent minus the second."""
    rows = [["agent", "compared with", "condition", "trials", "success", "success of the other", "difference, points"]]
    rows[0] += ["P", "corrected P", "conclusion"]
    for one in found:
        first, second = one.first_success, one.second_success
        rows.append(
            [
                *(comparison.subjects[side].name for side in (one.second, one.first)),
                one.condition,
                f"{first.n} pairs" if one.paired else f"{second.n} and {first.n} trials",
                percent(second.value),
                percent(first.value),
                bracketed(one.value, one.low, one.high),
                p_cell(one.p_value),
                p_cell(one.p_adjusted),
                DETECTED[bool(one.verdict)],
            ]
        )
    return rows
