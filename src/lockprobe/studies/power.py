"""Studies of a stated effect, simulated and put through the tests that a report makes: how often they detect it.

An effect draws the trials of one study and says what the report detects in them. :func:`power` counts that over many
studies of several sizes and finds the size with which it is detected often enough. Trials share no luck under different
conditions, like those of a sampled model; agents whose trials do need fewer.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import pairwise, product
from typing import ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from lockprobe.foundation.errors import BadValue, Missing
from lockprobe.foundation.seeds import generator
from lockprobe.foundation.workers import Lost, Pool
from lockprobe.statistics.course import is_baseline
from lockprobe.statistics.design import ARMS, PLANNED
from lockprobe.statistics.differences import any_difference, each_difference
from lockprobe.statistics.distributions import root
from lockprobe.statistics.outcomes import Outcomes, joined
from lockprobe.statistics.pairs import FEWEST
from lockprobe.statistics.proportions import ALPHA, Proportion, proportion
from lockprobe.statistics.shape import two_lines
from lockprobe.statistics.why import decide
from lockprobe.studies.study import Study, design_of

TARGET = 0.8
"""The power that is looked for."""

PAPER = (0.23, 0.4, 0.53, 0.63, 0.67, 0.6, 0.5)
"""Success at the flip rates 0, 0.1, … 0.6, a rise and fall like the paper's (Fig. 4). Its text gives 0.23 at 0 and 2.85
times that at 0.4; the other values are assumptions."""

_MOST = 10_000
"""The largest study that is simulated."""

_BATCH = 10
"""Studies that a process simulates before it reports."""

_WHY, _ANY, _SHAPE = "why", "any of them", "rises and falls"
"""The family of a study of controls; what the report can say of a family of doses beside its single levels."""

Flags = NDArray[np.bool_]


@dataclass(frozen=True, slots=True, kw_only=True)
class Rate:
    """The share of studies of size ``n`` in which the report detected something, and its Monte Carlo error."""

    n: int
    power: float
    error: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Needed:
    """The size with which a study reaches the target power.

    Attributes:
        measured: The power at every measured size, ascending.
        needed: Where it first reaches the target, interpolated in the logarithm of sizes; None if it does nowhere.
        low: Lower end of its 95 % interval: where the upper ends of power's Wilson intervals reach the target; None if
            they do at the smallest size, or nowhere (``needed`` is then None too).
        high: Upper end: where the lower ends reach it; None if they do not.
    """

    measured: tuple[Rate, ...]
    needed: int | None
    low: int | None
    high: int | None

    @classmethod
    def of(cls, detected: Mapping[int, int], studies: int) -> Needed:
        """What is needed if, at each size, ascending, something was detected in so many of the studies."""
        sizes, shares, rates = [*detected], list[Proportion](), list[Rate]()
        for n, count in detected.items():
            shares.append(share := proportion(count, studies))
            smooth = (count + 1) / (studies + 2)  # one study more of each outcome
            rates.append(Rate(n=n, power=share.value, error=math.sqrt(smooth * (1 - smooth) / studies)))

        def reached(powers: Sequence[float]) -> int | None:
            if powers[0] >= TARGET:
                return sizes[0]
            for (before, low), (after, high) in pairwise(zip(sizes, powers, strict=True)):
                if high >= TARGET:
                    return math.ceil(before * math.exp((TARGET - low) / (high - low) * math.log(after / before)) - 1e-9)
            return None

        low, needed, high = (reached([getattr(share, end) for share in shares]) for end in ("high", "value", "low"))
        return cls(measured=tuple(rates), needed=needed, low=None if low == sizes[0] else low, high=high)


def power(
    effects: Sequence[Effect],
    sizes: Iterable[int] = (),
    *,
    studies: int = 100,
    seed: int = 1,
    workers: Pool | None = None,
    progress: Callable[[int, int], None] = lambda done, of: None,
) -> list[dict[str, Needed]]:
    """Simulate studies of every effect, and count what the report detects.

    Args:
        effects: What is true.
        sizes: Sizes of studies; those of the first effect if there are none.
        studies: Studies of each effect and size.
        seed: Seed of everything.
        workers: A pool of processes, instead of this one; their number changes nothing.
        progress: Called with the number of batches of at most ten studies done, and of all.

    Returns:
        For each effect, what is detected -> the size that this needs.

    Raises:
        BadValue: If a study of such a size cannot be simulated.
    """
    ladder, least = sorted({*(sizes or effects[0].sizes)}), max(one.least for one in effects)
    if ladder[0] < least or ladder[-1] > _MOST:
        raise BadValue(effects[0].counted, ladder, f"numbers of at least {least} and at most {_MOST}")
    jobs: list[_Job] = [
        (place, effect, size, seed, range(studies)[first : first + _BATCH])
        for (place, effect), size, first in product(enumerate(effects), ladder, range(0, studies, _BATCH))
    ]
    found: list[dict[int, Counter[str]]] = [{size: Counter() for size in ladder} for _ in effects]
    results = workers.each(_simulator, jobs) if workers else zip(jobs, map(_simulator(), jobs), strict=True)
    for done, ((place, _, size, *_), detected) in enumerate(results, start=1):
        if isinstance(detected, Lost):
            assert workers is not None
            raise Missing(f"a worker was lost before its work was done ({detected.why})", workers.remedy)
        found[place][size].update(detected)
        progress(done, len(jobs))
    needed = []
    for effect, at in zip(effects, found, strict=True):
        every = dict.fromkeys([*effect.asked, *sorted({what for of in at.values() for what in of}, reverse=True)])
        needed.append({what: Needed.of({size: of[what] for size, of in at.items()}, studies) for what in every})
    return needed


def _simulator() -> Callable[[_Job], Counter[str]]:
    def detected(job: _Job) -> Counter[str]:
        _, effect, size, seed, numbers = job
        found = Counter[str]()
        for number in numbers:
            path: tuple[str | int, ...] = (*effect.address, size, number)
            found.update(effect.detected(size, generator(seed, *path), generator(seed, *path, "tests")))
        return found

    return detected


def _played(solved: Flags, dose: float) -> Outcomes:
    """Ended trials under one condition, from whether each was solved; shape (trials,)."""
    nothing, trial = np.zeros(len(solved), dtype=np.int64), np.arange(1, len(solved) + 1)
    at = np.full(len(solved), dose)
    return Outcomes(dose=at, repetition=nothing + 1, trial=trial, length=nothing, solved=solved, onset=nothing)


def _differing(groups: Sequence[Outcomes], agents: int = 1) -> list[int]:
    """The places of the groups that the report tells from the first one."""
    return [place for place, one in each_difference(groups, agents=agents) if one.p_value < ALPHA]


@dataclass(frozen=True, slots=True, kw_only=True)
class Conditions:
    """One agent under conditions that the report judges together.

    Attributes:
        family: Name of the dose whose levels they are, ``why`` for a study of controls; empty for all others.
        doses: Condition -> its place on the axis of the test; the control first, which has the lowest.
        success: True success under each condition, [0, 1].
        agents: Number of agents that are judged together.
    """

    counted: ClassVar[str] = "trials"
    least: ClassVar[int] = 2

    family: str
    doses: Mapping[str, float]
    success: tuple[float, ...]
    agents: int = 1

    @property
    def sizes(self) -> tuple[int, ...]:
        """Trials under each condition; a study of controls needs more."""
        return (50, 150, 300, 600) if self.family == _WHY else (15, 30, 60, 120, 240)

    @property
    def asked(self) -> list[str]:
        """Conditions that differ from the control; of doses also that any does, and that success rises and falls.

        A study of controls has verdicts instead, of which those are counted that occur.
        """
        labels = [*self.doses][1:]
        if self.family == _WHY:
            return []
        return [*labels, _ANY, _SHAPE] if self.family and len(labels) > 1 else labels

    @property
    def address(self) -> tuple[str, ...]:
        """Names its random streams."""
        return "power", "as stated", next(iter(self.doses)), self.family

    def row(self, what: str) -> dict[str, object]:
        """Family, how many comparisons are corrected together, and success under the control and this."""
        many, shares = self.agents * (len(self.success) - 1), dict(zip(self.doses, self.success, strict=True))
        head = {"family": self.family, "choices": many, "control success": self.success[0]}
        return head | {"detected": what, "success": shares.get(what)}

    def detected(self, size: int, luck: np.random.Generator, tests: np.random.Generator) -> list[str]:
        """What the report detects in a study of trials that are drawn by the stated success."""
        return self.judged(luck.random((size, len(self.success))) < np.array(self.success), tests)

    def judged(self, solved: Flags, tests: np.random.Generator) -> list[str]:
        """What the report detects in trials, shape (blocks, conditions)."""
        labels, doses = [*self.doses], [*self.doses.values()]
        groups = [_played(column, dose) for column, dose in zip(solved.T, doses, strict=True)]
        if self.family == _WHY:
            found = decide(dict(zip(labels, groups, strict=True)), agents=self.agents)
            said = [] if found.verdict == "inconclusive" else [f"verdict: {found.verdict}"]
            return [*said, *(f"claim: {claim}" for claim in found.claims)]
        if not self.family:
            return [labels[place] for place in _differing(groups, self.agents)]
        together = replace(joined(groups), dose=np.repeat(np.array(doses, dtype=np.float64), len(solved)))
        differ = {one.dose for one in any_difference(together, tests, agents=self.agents) if one.p_value < ALPHA}
        found_here = [label for label, dose in self.doses.items() if dose in differ]
        if len(doses) > 2:
            found_here += [_ANY] * bool(differ) + [_SHAPE] * (two_lines(together).direction == "inverted U")
        return found_here


def conditions_of(study: Study, success: Sequence[float]) -> list[Conditions]:
    """The families of the conditions of a study that its report has: of each modality flip rates, other doses, others.

    Args:
        study: The conditions, and agents, which are only counted.
        success: True success under each condition, in the order of the study, [0, 1].

    Raises:
        BadValue: If these are not as many shares as conditions, or nothing is compared.
    """
    design, labels, families = design_of(study), [one.label for one in study.conditions], []
    for modality, shown in design.shown.items():
        if set(PLANNED) <= {one.label for one in shown}:
            families.append((_WHY, {label: float(i) for i, label in enumerate(ARMS)}))
            continue
        for one in (one for one in design.against_controls if one.modality == modality):
            doses = {label: float(i) for i, label in enumerate(one.groups[0])} if one.axis is None else one.axis.doses
            if len(doses) > 1:
                ordered = dict(sorted(doses.items(), key=lambda both: both[1]))
                families.append((one.name if one.axis else "", ordered))
    if not families:
        raise BadValue("conditions", labels, "a control and another condition")
    if len(success) != len(labels) or not all(0 <= share <= 1 for share in success):
        expected = f"a share from 0 to 1 for each of {len(labels)} conditions: {'; '.join(labels)}"
        raise BadValue("success", ",".join(f"{share:g}" for share in success), expected)
    at, agents = dict(zip(labels, success, strict=True)), sum(not is_baseline(agent) for agent in study.agents)
    return [
        Conditions(family=family, doses=doses, success=tuple(map(at.__getitem__, doses)), agents=max(1, agents))
        for family, doses in families
    ]


FEWEST_PERSONS = 10
"""The fewest persons under a condition."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Clusters:
    """Persons, or boxes, that differ in skill or difficulty and in what a condition does to them.

    A trial of cluster i under condition c is solved with the logit a_c + u_i + v_ci. u is normal with the standard
    deviation ``sd``, and v with ``effect_sd``; under the control it is 0. a_c is such that the mean over clusters is
    the stated share. Trials of a cluster are independent given u and v: nobody learns from box to box.

    A t test on the shares of persons, with which studies are often planned, detects 3 to 10 points more often than the
    report, which clusters by person and by luck.

    Attributes:
        success: Share solved under each condition, the control first, (0, 1).
        counted: What they are, and what the size of a study counts.
        each: Trials of a cluster under each condition.
        between: Whether each person plays under one condition alone, as many boxes in all.
        sd: Standard deviation of skill or difficulty, in logits. The default of persons is chosen by eye: at a mean of
            one half, the middle two thirds open 29 to 71 % of their boxes.
        effect_sd: Standard deviation of effects, in logits; the default is chosen by eye, too.
    """

    success: tuple[float, ...]
    counted: Literal["persons", "boxes"] = "persons"
    each: int = 1
    between: bool = False
    sd: float = 1.0
    effect_sd: float = 0.5

    def __post_init__(self) -> None:
        if len(self.success) < 2 or not all(0 < share < 1 for share in self.success):
            raise BadValue("success", self.success, "two or more shares above 0 and below 1, the control first")

    @property
    def sizes(self) -> tuple[int, ...]:
        """Clusters in all."""
        return tuple(len(self.success) * each for each in (10, 20, 40, 80, 160))

    @property
    def least(self) -> int:
        """Ten persons under each condition; boxes enough for a sentence on boxes like these."""
        if self.counted == "boxes":
            return FEWEST
        return FEWEST_PERSONS * (len(self.success) if self.between else 1)

    @property
    def asked(self) -> list[str]:
        """Every condition but the control, by its place."""
        return [str(place) for place in range(2, len(self.success) + 1)]

    @property
    def address(self) -> tuple[str, ...]:
        """Names its random streams."""
        design = "boxes" if self.counted == "boxes" else "between" if self.between else "within"
        return "power", "people", design, f"{self.sd:g}", f"{self.effect_sd:g}"

    def row(self, what: str) -> dict[str, object]:
        """Design, trials of each, the assumed deviations, and the condition."""
        head: dict[str, object] = {"trials on each box": self.each}
        if self.counted == "persons":
            design = "between persons" if self.between else "within persons"
            head = {"design": design, "boxes": self.each * len(self.success)}
        return head | {"sd": self.sd, "effect sd": self.effect_sd, "condition": what}

    def detected(self, size: int, luck: np.random.Generator, tests: np.random.Generator) -> list[str]:
        """The conditions that the report tells from the control; between persons a remainder of them is left out."""
        return [str(place + 1) for place in _differing(self.groups(size, luck))]

    def groups(self, size: int, luck: np.random.Generator) -> list[Outcomes]:
        """The trials of one study under each condition."""
        within, conditions = not self.between, len(self.success)
        n, each = (size, self.each) if within else (size // conditions, self.each * conditions)
        skill, found = luck.normal(0, self.sd, (1 if within else conditions, n)), list[Outcomes]()
        for place, share in enumerate(self.success):
            logit = _intercept(share, math.hypot(self.sd, self.effect_sd * bool(place))) + skill[place * self.between]
            if place:
                logit = logit + luck.normal(0, self.effect_sd, n)
            trials = _played((luck.random((n, each)) < _chance(logit)[:, None]).reshape(-1), place)
            name = np.repeat(np.arange(n) + n * place * self.between, each).astype(np.str_)
            if self.counted == "boxes":
                found.append(replace(trials, box=name))
            else:  # nobody meets any luck twice, and under every condition somebody meets it
                number = np.roll(trials.trial.reshape(n, each), place, axis=0).reshape(-1)
                found.append(replace(trials, trial=number, player=name))
        return found


Effect = Conditions | Clusters
"""What is true of an agent, or of people or boxes. Jobs carry it to other processes."""

_Job = tuple[int, Effect, int, int, range]
"""The place of what is true, what that is, the size of studies, the seed, and the numbers of the studies."""


@lru_cache(maxsize=1000)
def _intercept(share: float, deviation: float) -> float:
    """The logit whose mean over persons, normal with this standard deviation, is a share."""
    points, weights = np.polynomial.hermite_e.hermegauss(40)
    return root(lambda a: float(weights @ _chance(a + deviation * points) / weights.sum()) - share, -200.0, 200.0)


def _chance(logit: NDArray[np.float64]) -> NDArray[np.float64]:
    """The probability of a logit, also of a large one."""
    return np.asarray(0.5 * (1 + np.tanh(logit / 2)))
