"""Power of the report's test of a condition against its control, and the trials that a design needs, by simulation.

Blocks of luck are drawn with replacement from a pool that the agent has played, or their trials at random by a stated
success. Each simulated study passes through the test of the report: conditions of a family together, in pairs of equal
luck, corrected for the family and for the agents that are judged together.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from lockprobe.agents.catalogue import is_strategy
from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.parallel import THIS_PROCESS, Pool
from lockprobe.foundation.seeds import generator
from lockprobe.simulation.montecarlo.blocks import Played, played_blocks
from lockprobe.simulation.power.flip_rates import MOST_TRIALS, TRIALS, Needed, needed
from lockprobe.simulation.power.rates import Rate
from lockprobe.statistics.course import is_baseline
from lockprobe.statistics.inference.difference import any_difference, each_difference
from lockprobe.statistics.outcomes import Outcomes
from lockprobe.statistics.proportions import ALPHA
from lockprobe.studies.study import Study
from lockprobe.studies.study_design import design_of

POOL = 1000
"""Blocks that are played of every agent."""

STATED = "as stated"
"""What results call the agent whose success a user states."""

BATCH = 10
"""Studies that a process simulates before it reports."""

Progress = Callable[[int, int], None]
"""Called with the work done and all work."""

Flags = NDArray[np.bool_]


@dataclass(frozen=True, slots=True, kw_only=True)
class Family:
    """Conditions that the report compares with their control together.

    Attributes:
        name: Name of the dose whose levels they are; empty for all others, and for the controls of all modalities.
        doses: Label -> its place on the axis of the test; the control first, which has the lowest.
    """

    name: str
    doses: Mapping[str, float]

    @property
    def control(self) -> str:
        """The condition that the others are compared with."""
        return next(iter(self.doses))


@dataclass(frozen=True, slots=True, kw_only=True)
class ConditionPower:
    """The sample size that one condition needs, for one agent: trials per condition.

    Attributes:
        agent: Name of the agent, or :data:`STATED`.
        family: Name of the dose whose level it is; empty for the family of all others.
        condition: Its label.
        control: The condition that it is compared with.
        success: True success under the condition: the pool's, or as stated, [0, 1].
        control_success: The same of the control.
        choices: Comparisons that are corrected together: conditions of the family times agents.
        needed: The power at every measured number of trials, and the number needed.
    """

    agent: str
    family: str
    condition: str
    control: str
    success: float
    control_success: float
    choices: int
    needed: Needed


def _families_of(study: Study) -> tuple[Family, ...]:
    """The families of a study's conditions, as the report has them: flip rates, other axes, all others; by modality."""
    design = design_of(study)
    rates = {one.label: one.p for one in study.flip_axis if one.p is not None}
    found = []
    for modality in design.modalities:
        of = design.comparison(modality)
        flips = {label: rates[label] for label in (of.control, *of.flips) if label in rates}
        others = {label: float(i) for i, label in enumerate((of.control, *of.others))}
        found += [Family(name="flip rate", doses=dict(sorted(flips.items(), key=lambda both: both[1])))]
        found += [Family(name=axis.axis.name, doses=axis.doses) for axis in of.axes]
        controls = {label: float(i) for i, label in enumerate((of.control, *of.controls))}
        found += [Family(name="", doses=others), Family(name="", doses=controls)]
    return tuple(one for one in found if len(one.doses) > 1)


def detected(solved: Flags, family: Family, rng: np.random.Generator, agents: int = 1) -> dict[str, bool]:
    """Which conditions of a family the report would say differ from the control.

    Args:
        solved: Whether each trial was solved, shape (blocks, conditions of the family).
        family: The family.
        rng: The stream of the permutations.
        agents: Number of agents that are judged together.

    Returns:
        Condition -> whether a difference is detected.
    """
    blocks, many = solved.shape
    block, nothing = np.repeat(np.arange(1, blocks + 1), many), np.zeros(solved.size, dtype=np.int64)
    doses = list(family.doses.values())
    columns = Outcomes(
        dose=np.tile(np.array(doses), blocks),
        repetition=np.ones_like(nothing),
        trial=block,
        length=nothing,
        solved=solved.reshape(-1),
        onset=nothing,
    )
    if family.name:
        tested = any_difference(columns, rng, agents=agents)
    else:
        groups = [columns.at(columns.dose == dose) for dose in doses]
        tested = tuple(one for _, one in each_difference(groups, rng, agents=agents))
    found = {one.dose: one.p_value < ALPHA for one in tested}
    return {label: found.get(dose, False) for label, dose in list(family.doses.items())[1:]}


@dataclass(frozen=True, slots=True, kw_only=True)
class _Source:
    """Where trials of one agent under the conditions of a family come from.

    Attributes:
        agent: Its name in results.
        family: The family.
        agents: Number of agents judged together.
        success: True success under each condition of the family.
        pool: Blocks that it played, shape (blocks, conditions of the family); None for a stated success.
        shared: For a stated success, the share of blocks in which one number decides under all conditions.
    """

    agent: str
    family: Family
    agents: int
    success: tuple[float, ...]
    pool: Flags | None = None
    shared: float = 0.0

    def drawn(self, trials: int, rng: np.random.Generator) -> Flags:
        """One simulated study: whether each trial was solved, shape (trials, conditions)."""
        if self.pool is not None:
            return self.pool[rng.integers(len(self.pool), size=trials)]
        own, common = rng.random((trials, len(self.success))), rng.random((trials, 1))
        alike = rng.random((trials, 1)) < self.shared
        found: Flags = np.where(alike, common, own) < np.array(self.success)
        return found


@dataclass(frozen=True, slots=True, kw_only=True)
class _StudyRange:
    """Some studies of one size, by their numbers: the work of one job."""

    source: _Source
    trials: int
    seed: int
    numbers: range


def condition_power(
    study: Study,
    *,
    success: Sequence[float] | None = None,
    shared: float = 0.0,
    trials: Sequence[int] = TRIALS,
    target: float = 0.8,
    studies: int = 100,
    pool: int = POOL,
    workers: Pool = THIS_PROCESS,
    playing: Progress = lambda done, of: None,
    progress: Progress = lambda done, of: None,
) -> list[ConditionPower]:
    """The power to detect the difference of every condition from its control, and the trials that this needs.

    Args:
        study: Agents, conditions and seed. Agents are played, and have to be strategies that ship; with
            ``success`` they are only counted.
        success: True success under each condition, in the order of the study, [0, 1].
        shared: With ``success``, the share of blocks of luck in which one number decides under all conditions, [0, 1]:
            0 as for a sampled model, 1 if trials differ by the conditions alone.
        trials: Trials per condition to measure at, 2 to :data:`lockprobe.simulation.power.flip_rates.MOST_TRIALS`.
        target: Power to be reached, (0, 1).
        studies: Simulated studies of each size.
        pool: Blocks to be played of each agent.
        workers: The pool of processes.
        playing: Called with the number of blocks played.
        progress: Called with the number of studies simulated.

    Raises:
        BadValue: If a number is out of range, an agent cannot be played here, or nothing is compared.
    """
    sizes, families = sorted(set(trials)), _families_of(study)
    if not sizes or sizes[0] < 2 or sizes[-1] > MOST_TRIALS:
        raise BadValue("trials per condition", list(trials), f"numbers of at least 2 and at most {MOST_TRIALS}")
    if not 0 < target < 1:
        raise BadValue("target power", target, "a number between 0 and 1")
    if not families:
        raise BadValue("conditions", [one.label for one in study.conditions], "a control and another condition")
    if success is None:
        sources = _played(study, families, _played_pools(study, pool, workers, playing))
    else:
        _check_stated(study, success, shared)
        sources = _stated(study, families, success, shared)
    return [
        one
        for source, rejected in zip(
            sources, _rejected(sources, sizes, studies, study.seed, workers, progress), strict=True
        )
        for one in _powers(replace(source, agent=study.label_of(source.agent)), rejected, studies, target)
    ]


def _rejected(
    sources: Sequence[_Source], sizes: Sequence[int], studies: int, seed: int, workers: Pool, progress: Progress
) -> list[dict[int, Counter[str]]]:
    """For each source, number of trials -> condition -> studies in which its difference is detected."""
    jobs = [
        (place, _StudyRange(source=one, trials=size, seed=seed, numbers=range(studies)[first : first + BATCH]))
        for place, one in enumerate(sources)
        for size in sizes
        for first in range(0, studies, BATCH)
    ]
    found = [{size: Counter[str]() for size in sizes} for _ in sources]
    done = 0
    for (place, job), rejected in zip(jobs, workers.map(_batch, [job for _, job in jobs]), strict=True):
        found[place][job.trials] += rejected
        done += len(job.numbers)
        progress(done, studies * len(sources) * len(sizes))
    return found


def _powers(
    source: _Source, rejected: Mapping[int, Counter[str]], studies: int, target: float
) -> Iterator[ConditionPower]:
    """The power for every condition of a family but the control."""
    control = source.success[0]
    for label, success in list(zip(source.family.doses, source.success, strict=True))[1:]:
        rates = [
            Rate(
                world=source.agent,
                trials=size,
                question="success",
                test=label,
                truth=success != control,
                studies=studies,
                rejected=shown[label],
            )
            for size, shown in rejected.items()
        ]
        yield ConditionPower(
            agent=source.agent,
            family=source.family.name,
            condition=label,
            control=source.family.control,
            success=success,
            control_success=control,
            choices=source.agents * (len(source.family.doses) - 1),
            needed=needed(rates, target),
        )


def _check_stated(study: Study, success: Sequence[float], shared: float) -> None:
    """Refuse what is no success under the conditions of a study, or no share of shared luck.

    Raises:
        BadValue: If it is none.
    """
    labels = [one.label for one in study.conditions]
    if len(success) != len(labels) or not all(0 <= share <= 1 for share in success):
        expected = f"a share from 0 to 1 for each of {len(labels)} conditions: {'; '.join(labels)}"
        raise BadValue("success", ",".join(f"{share:g}" for share in success), expected)
    if not 0 <= shared <= 1:
        raise BadValue("shared", shared, "a share from 0 to 1")


def _stated(study: Study, families: Sequence[Family], success: Sequence[float], shared: float) -> list[_Source]:
    at = dict(zip((one.label for one in study.conditions), success, strict=True))
    agents = max(1, sum(not is_baseline(agent) for agent in study.agents))
    return [
        _Source(
            agent=STATED,
            family=family,
            agents=agents,
            success=tuple(at[label] for label in family.doses),
            shared=shared,
        )
        for family in families
    ]


def _played_pools(study: Study, blocks: int, workers: Pool, progress: Progress) -> list[Flags]:
    """Blocks of luck that every agent of a study plays under all its conditions.

    Raises:
        BadValue: If an agent cannot be played here.
    """
    for agent in study.agents:
        if not is_strategy(agent):
            raise BadValue("agent", agent, "a strategy that ships, or --success for any other")
    asked = [Played(study=study, agent=agent, conditions=study.conditions) for agent in study.agents]
    return played_blocks(asked, blocks, workers=workers, progress=progress)


def _played(study: Study, families: Sequence[Family], pools: Sequence[Flags]) -> list[_Source]:
    labels = [one.label for one in study.conditions]
    found = [
        (agent, family, solved[:, [labels.index(label) for label in family.doses]])
        for agent, solved in zip(study.agents, pools, strict=True)
        for family in families
    ]
    heeding = Counter(_judged(agent, family) for agent, family, solved in found if (solved != solved[:, :1]).any())
    return [
        _Source(
            agent=agent,
            family=family,
            agents=max(1, heeding[_judged(agent, family)]),
            success=tuple(solved.mean(axis=0).tolist()),
            pool=solved,
        )
        for agent, family, solved in found
    ]


def _judged(agent: str, family: Family) -> tuple[bool | str, ...]:
    """What is judged together: agents that the study is about, or baselines, in one family of contrasts."""
    return is_baseline(agent), family.name, *family.doses


def _batch(job: _StudyRange) -> Counter[str]:
    """In how many studies the difference of each condition is detected."""
    rejected: Counter[str] = Counter()
    for number in job.numbers:
        source = job.source
        place = (job.seed, "power", source.agent, source.family.control, source.family.name, job.trials, number)
        found = detected(
            source.drawn(job.trials, generator(*place)), source.family, generator(*place, "tests"), source.agents
        )
        rejected.update(label for label, shown in found.items() if shown)
    return rejected
