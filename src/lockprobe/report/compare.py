"""Studies side by side: success of every agent under the conditions that they share, differences, and ``compare.html``.

Studies are comparable if they play the same task: box, budget of steps, plant, layout and question are equal. They may
differ in agents, prompts, seeds, flip rates, conditions and numbers of trials. A condition is compared if at least two
studies have it: agents and conditions are matched by what acts, whatever it is called.

Studies of one seed share their luck: trials of equal repetition and number are compared in pairs. Others, and people,
are independent samples. Agents of one study are compared in its own report, and baselines are compared only where all
agents are. P values are corrected (Holm) for the differences under the conditions of one family. The page is one file
without scripts.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from importlib.metadata import version
from itertools import chain, combinations
from pathlib import Path
from typing import Any, NamedTuple

from pydantic import Field

from lockprobe.foundation.errors import BadFile, BadValue, UnknownName
from lockprobe.foundation.formatting import listed, percent
from lockprobe.foundation.spec import Spec, spec_name
from lockprobe.foundation.storage.atomic_file import write_file
from lockprobe.interventions.asked_and_done import OwnPrompt
from lockprobe.report.format import beside, count_of, tested
from lockprobe.report.opened import open_study
from lockprobe.report.prose import rules_broken_said
from lockprobe.report.rendering import rendered
from lockprobe.report.rows import Estimate, detected_said, measured, who
from lockprobe.report.section import Lines
from lockprobe.statistics.clustered import share_of
from lockprobe.statistics.course import is_baseline
from lockprobe.statistics.design import Design
from lockprobe.statistics.differences import each_difference, independent_difference
from lockprobe.statistics.multiple_testing import holm
from lockprobe.statistics.outcomes import outcomes
from lockprobe.studies.study import SIZES, Study, arms_of, flip_axis
from lockprobe.trial.condition import Condition, Recorded
from lockprobe.trial.record import Trial

_FREE = ("name", "names", "conditions", "strategy_conditions", *SIZES)
"""Settings that may differ."""

_SHARE, _OTHER = "success_compared", "the other"
"""What a side of a difference solved of the trials compared, and the part of the side that is subtracted."""

_WORST = "whatever became of broken trials"

_NONE = "No two studies have a trial to compare under a condition that they share."


class Sample(NamedTuple):
    """The trials of one agent of a study under one condition, broken ones too.

    Attributes:
        agent: What sentences and tables call it, with the file of its prompt, if any.
        condition: Its name, equal in all studies that have it.
        luck: Seed of the study: trials of equal luck, repetition and number share labels, flips and draws.
        family: The axis on which the condition lies; empty for all conditions on none.
    """

    study: str
    agent: str
    condition: str
    luck: int
    trials: Sequence[Trial]
    family: str


class StudyRow(Estimate):
    """A number of one study, or of two."""

    study: str = Field(default="", description="The study.")
    versus_study: str = Field(default="", description="The study that is subtracted, in a comparison.")


@dataclass(frozen=True, kw_only=True)
class Comparison:
    """Studies side by side.

    Attributes:
        box: Name of the box.
        studies: In the order asked for, as JSON holds them. The name is the end of a directory's path by which it is
            told from the others; conditions that no other study has (``not_shared``) are in no number.
        rows: Success of every agent under every shared condition that it has played, and how many of its trials broke;
            differences between studies, second minus first, each followed by what both solved.
        said: The conclusion in a sentence, and what broke the rules of the box.
        unlike: What differs between agents of one spec in several studies, a line each.
    """

    box: str
    studies: tuple[dict[str, Any], ...]
    rows: tuple[StudyRow, ...]
    said: str
    unlike: tuple[str, ...]

    def plain(self) -> dict[str, Any]:
        """The comparison as JSON holds it."""
        parts = {"studies": [*self.studies], "rows": [row.plain() for row in self.rows], "unlike": [*self.unlike]}
        return {"lockprobe": version("lockprobe"), "box": self.box, "said": self.said} | parts


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
    check_same_task({directory: one.study for directory, one in zip(directories, opened, strict=True)})
    known = dict.fromkeys(agent for one in opened for agent in one.study.labels)
    for agent in agents:
        if agent not in known:
            raise UnknownName("agent of these studies", agent, known)
    own = [shared(one.study) for one in opened]
    labels = [dict.fromkeys(acting.label for acting, _ in conditions.values()) for conditions in own]
    times = _times_shared(directories, labels)
    every = {one.label: one for conditions in own for one, _ in conditions.values() if times[one.label] > 1}
    family = families(every.values())
    ends = [["/".join(path.parts[-n:]) for n in range(1, len(path.parts) + 1)] for path in resolved]
    studies, samples = [], []
    for one, conditions, names, paths in zip(opened, own, labels, ends, strict=True):
        name = next(end for end in paths if sum(end in other for other in ends) == 1)
        far = one.progress
        studies.append(
            {"name": name, "study": one.study.name, "seed": one.study.seed, "agents": [*one.study.labels]}
            | {"planned": far.planned, "finished": far.finished, "people_trials": one.finished_by_people}
            | {
                "not_shared": [name for name in names if name not in family],
                "looked_at": bool(far.every_look),
                "partial": far.partial,
            }
        )
        played: dict[tuple[str, str], list[Trial]] = {}
        for trial in one.trials:
            acting, prompt = conditions[one.study.labelled(trial.condition)]
            if acting.label in family and trial.group in (agents or known):
                called = who(trial.group) + f" with {prompt}" * bool(prompt)
                played.setdefault((acting.label, called), []).append(trial)
        for (label, agent), trials in played.items():
            samples.append(Sample(name, agent, label, one.study.seed, trials, family[label]))
    samples.sort(key=lambda one: [*family].index(one.condition))
    rules = rules_broken_said(*opened[0].rules.broken(t for one in samples for t in one.trials))
    rows = study_rows(samples)
    found = detected_said((row for row, *_ in _differences(rows)), "differences between studies")
    return Comparison(
        box=opened[0].study.boxes_in_words,
        studies=tuple(studies),
        rows=tuple(rows),
        said=" ".join(filter(None, (found or _NONE, rules))),
        unlike=tuple(_unlike(samples)),
    )


def check_same_task(studies: Mapping[Path, Study]) -> None:
    """Refuse fewer than two studies (directory -> study), and those that play another task than the first."""
    if len(studies) < 2:
        raise BadValue("directories", len(studies), "two or more, each with a study")
    first, ours = next(iter(studies.items()))
    free = _FREE if len(ours.boxes) > 1 else (*_FREE, "seed")  # of several, pairs of equal luck are compared
    for directory, theirs in studies.items():
        for name, (there, here) in ours.differences(theirs, but=free).items():
            raise BadFile(directory, f"it cannot be compared with {first}: {name} is {there}, not {here}")


def _times_shared(directories: Sequence[Path], labels: Sequence[Collection[str]]) -> Counter[str]:
    """In how many studies each condition is; a study that shares none is refused."""
    times = Counter(chain(*labels))
    for directory, names in zip(directories, labels, strict=True):
        if all(times[name] == 1 for name in names):
            has, have = (listed([*of], named=6) for of in (names, [one for one in times if one not in names]))
            raise BadFile(directory, f"it shares no condition with the other studies: it has {has}; they have {have}")
    return times


def shared(study: Study) -> dict[Condition, tuple[Condition, str]]:
    """The conditions of a study as others share them: what acts, without its name and doses of 0, and the prompt.

    A prompt, by its file, counts as part of the agent, so two prompts are compared like two agents.
    """
    found = {}
    for one in study.conditions:
        prompts = [spec for spec in one.specs if spec_name(spec) == OwnPrompt.name]
        acting = tuple(Recorded(spec=str(spec), doses=doses) for spec, doses in one.acting if str(spec) not in prompts)
        bare = replace(one, interventions=acting, name="")
        files = (Spec.parse(spec, "intervention").options.get("file", spec) for spec in prompts)
        found[one] = bare, " + ".join(files)
    return found


def families(conditions: Iterable[Condition]) -> dict[str, str]:
    """The family of each shared condition, by its label, in the order of the families.

    Flip rates of every modality are one, with the truth; the doses of every other axis are one; all others are one,
    whose name is empty. So a condition more changes nothing that is concluded of another family.
    """
    acting = list(dict.fromkeys(conditions))
    flips = frozenset(one.label for one in flip_axis(acting))
    design = Design(agents=(), arms=arms_of(acting), axis=flips)
    found = {one.label: "flip rate" for one in acting if one.label in flips}
    for axis in filter(None, (one.axis for one in design.against_controls)):
        apart = axis.doses.keys() - found.keys() - {*design.controls.values()}
        found |= {label: axis.key for label in axis.doses if label in apart}
    return found | {one.label: "" for one in acting if one.label not in found}


def study_rows(samples: Sequence[Sample]) -> list[StudyRow]:
    """The rows of a comparison; P values are corrected within each family (Holm).

    Pairs without a trial to compare are left out. Each side is at most once per condition; the order decides which side
    of a pair comes first.
    """
    played, solved = [(one, outcomes(one.trials)) for one in samples], []
    for one, own in played:
        of: dict[str, Any] = {"study": one.study, "agent": one.agent, "condition": one.condition}
        share = share_of(own.known, own.player, own.luck, own.box)
        solved.append(StudyRow(quantity="success", **of, **measured(share)))
        solved.append(StudyRow(quantity="broken", **of, value=share.broken, unit="trials"))
    subjects = [both for both in played if not is_baseline(both[0].trials[0].spec)] or played
    pairs: dict[object, list[list[StudyRow]]] = {}
    for (one, before), (two, after) in combinations(subjects, 2):
        if one.condition != two.condition or one.study == two.study:
            continue
        if (same_luck := one.luck == two.luck) and not (before.crossed or after.crossed):
            found = next((at for _, at in each_difference([before, after])), None)
        else:
            found = independent_difference(before, after, same_luck=same_luck)
        if found is None:
            continue
        of = {"study": two.study, "agent": two.agent, "condition": one.condition, "family": one.family}
        of |= {"versus_study": one.study, "versus": one.agent}
        judged = measured(found) | {"test": found.test, "note": _WORST * (found.bounds is not None)}
        gap = StudyRow(quantity="success_difference", **of, **judged | {"n": found.second.n}, unit="points")
        shares = [
            StudyRow(quantity=_SHARE, of=part, **of, value=side.value, count=side.count, n=side.n)
            for part, side in (("", found.second), (_OTHER, found.first))
        ]
        pairs.setdefault((one.study, one.agent, two.study, two.agent), []).append([gap, *shares])
    every = [rows for own_pair in pairs.values() for rows in own_pair]
    of_family = [gap.family for gap, *_ in every]
    corrected, sizes = holm([gap.p_value for gap, *_ in every], of_family), Counter(of_family)
    for rows, p in zip(every, corrected, strict=True):
        rows[0] = rows[0].model_copy(update={"p_value": p, "corrected_for": sizes[rows[0].family]})
    return [*solved, *(row for rows in every for row in rows)]


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


def _differences(rows: Sequence[StudyRow]) -> Iterator[tuple[StudyRow, StudyRow, StudyRow, str]]:
    """Every difference, what its two sides solved of the trials compared, and how many these are."""
    for i, row in enumerate(rows):
        if row.quantity == "success_difference":
            own, other = rows[i + 1 : i + 3]
            paired = row.test.startswith("McNemar")
            yield row, own, other, f"{own.n} pairs" if paired else f"{own.n} and {other.n} trials"


def write_comparison(comparison: Comparison, out: Path) -> Path:
    """Write the page in one step.

    Raises:
        BadFile: If it cannot be written.
    """
    made = {name: [*lines(comparison)] for name, lines in TABLES.items()}
    page = rendered("compare", content=comparison, lockprobe=version("lockprobe"), tables=made)
    try:
        write_file(out, page)
    except OSError as error:
        raise BadFile(out, f"cannot be written ({error.strerror})") from error
    return out


def _study_table(comparison: Comparison) -> Lines:
    yield ["study", "name", "seed", "trials finished", "of these, people's", "conditions in no other study"]
    for one in comparison.studies:
        finished = f"{one['finished']} of {one['planned']}" + " (partial)" * one["partial"]
        left = ", ".join(one["not_shared"]) or None
        yield [one["name"], one["study"], str(one["seed"]), finished, str(one["people_trials"]), left]


def _success_table(comparison: Comparison) -> Lines:
    yield ["condition", "study", "agent", "solved", "success", "broken"]
    solved = [row for row in comparison.rows if row.quantity == "success"]
    broken = [row for row in comparison.rows if row.quantity == "broken"]
    for row, broke in zip(solved, broken, strict=True):
        yield [row.condition, row.study, row.agent, count_of(row), row, f"{broke.value:.0f}"]


def _difference_table(comparison: Comparison) -> Lines:
    head = ["agent", "compared with", "condition", "trials", "success", "success of the other", "difference, points"]
    yield [*head, "P", "conclusion"]
    for row, own, other, trials in _differences(comparison.rows):
        sides = f"{row.agent} in {row.study}", f"{row.versus} in {row.versus_study}"
        shares = percent(own.value), percent(other.value)
        yield [*sides, row.condition, trials, *shares, *tested(beside(row, other, own))]


TABLES = {"success": _success_table, "differences": _difference_table, "studies": _study_table}
"""The tables of the page, by what they are of."""
