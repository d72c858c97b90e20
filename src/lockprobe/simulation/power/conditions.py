"""Power of the report's test of a condition against its control, and the trials that a design needs.

Blocks of luck are drawn with replacement from a pool that the agent has played, or their trials at random by a stated
success. Each simulated study passes through the test of the report: conditions of a family together, in pairs of equal
luck, corrected for the family and for the agents that are judged together.
"""

from __future__ import annotations

import asyncio
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from lockprobe.agents.catalogue import is_strategy, resolve
from lockprobe.agents.policy import Policy
from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.workers import THIS_PROCESS, Pool
from lockprobe.interventions.flip import OutcomeFlip
from lockprobe.interventions.words import TextChannel
from lockprobe.simulation.population import population
from lockprobe.simulation.power.simulator import Flags, Needed, Progress, Simulation, detections, needed, played
from lockprobe.statistics.course import is_baseline
from lockprobe.statistics.differences import any_difference, each_difference
from lockprobe.statistics.proportions import ALPHA
from lockprobe.studies.modality import interventions_for
from lockprobe.studies.running.trial_setup import play_timed
from lockprobe.studies.study import Study
from lockprobe.studies.study_design import design_of
from lockprobe.trial.condition import Condition

POOL = 1000
"""Blocks that are played of every agent."""

BATCH = 250
"""Trials that a process plays before it reports."""

STATED = "as stated"
"""What results call the agent whose success a user states."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Family:
    """Conditions that the report compares with their control together.

    Attributes:
        name: Name of the dose whose levels they are; empty for all others, and for the controls of all modalities.
        doses: Label -> its place on the axis of the test; the control first, which has the lowest.
    """

    name: str
    doses: Mapping[str, float]


def families_of(study: Study) -> tuple[Family, ...]:
    """The families of a study's conditions, as the report has them: flip rates, other axes, all others; by modality."""
    design = design_of(study)
    rates = {one.label: one.p for one in study.flip_axis if one.p is not None}
    found = []
    for modality in design.modalities:
        of = design.comparisons[modality]
        flips = {label: rates[label] for label in (of.control, *of.flips) if label in rates}
        found += [Family(name="flip rate", doses=dict(sorted(flips.items(), key=lambda both: both[1])))]
        found += [Family(name=axis.axis.name, doses=axis.doses) for axis in of.axes]
        for labels in (of.others, of.controls):
            found += [Family(name="", doses={label: float(i) for i, label in enumerate((of.control, *labels))})]
    return tuple(one for one in found if len(one.doses) > 1)


@dataclass(frozen=True, slots=True, kw_only=True)
class Contrasts:
    """One agent under the conditions of a family against their control.

    Attributes:
        agent: Its name in results.
        family: The family.
        success: True success under each condition of the family, the control first.
        agents: Number of agents that are judged together.
        pool: Blocks that it played, shape (blocks, conditions of the family); None for a stated success.
        shared: For a stated success, the share of blocks in which one number decides under all conditions.
    """

    agent: str
    family: Family
    success: tuple[float, ...]
    agents: int = 1
    pool: Flags | None = None
    shared: float = 0.0

    @property
    def address(self) -> tuple[str, ...]:
        """Names its random streams."""
        return "power", self.agent, next(iter(self.family.doses)), self.family.name

    @property
    def asked(self) -> list[str]:
        """The conditions that are compared with the control."""
        return list(self.family.doses)[1:]

    @property
    def choices(self) -> int:
        """Comparisons that are corrected together: conditions of the family times agents."""
        return self.agents * len(self.asked)

    def detected(self, trials: int, luck: np.random.Generator, tests: np.random.Generator) -> list[str]:
        """The conditions that differ from the control in one study, by the report."""
        if self.pool is not None:
            return self.differing(self.pool[luck.integers(len(self.pool), size=trials)], tests)
        own, common = luck.random((trials, len(self.success))), luck.random((trials, 1))
        alike = luck.random((trials, 1)) < self.shared
        return self.differing(np.where(alike, common, own) < np.array(self.success), tests)

    def differing(self, solved: Flags, rng: np.random.Generator) -> list[str]:
        """The conditions that the report would say differ from the control.

        Args:
            solved: Whether each trial was solved, shape (blocks, conditions of the family).
            rng: The stream of the permutations.
        """
        doses = list(self.family.doses.values())
        if self.family.name:
            tested = any_difference(played(solved, doses), rng, agents=self.agents)
        else:
            groups = [played(solved[:, [i]], [dose]) for i, dose in enumerate(doses)]
            tested = tuple(one for _, one in each_difference(groups, rng, agents=self.agents))
        found = {one.dose for one in tested if one.p_value < ALPHA}
        return [label for label in self.asked if self.family.doses[label] in found]


def condition_power(
    study: Study,
    how: Simulation,
    *,
    success: Sequence[float] | None = None,
    shared: float = 0.0,
    playing: Progress = lambda done, of: None,
) -> list[tuple[Contrasts, dict[str, Needed]]]:
    """The power to detect the difference of every condition from its control, and the trials that this needs.

    Args:
        study: Agents, conditions and seed. Agents are played, and have to be strategies that ship; with
            ``success`` they are only counted.
        how: How much is simulated.
        success: True success under each condition, in the order of the study, [0, 1].
        shared: With ``success``, the share of blocks of luck in which one number decides under all conditions, [0, 1]:
            0 as for a sampled model, 1 if trials differ by the conditions alone.
        playing: Called with the number of trials played, and of all.

    Returns:
        By agent and family, condition -> what its detection needs.

    Raises:
        BadValue: If a number is out of range, an agent cannot be played here, or nothing is compared.
    """
    families, labels = families_of(study), [one.label for one in study.conditions]
    if not families:
        raise BadValue("conditions", labels, "a control and another condition")
    if success is None:
        effects = _played(study, families, how.workers, playing)
    elif len(success) != len(labels) or not all(0 <= share <= 1 for share in success):
        expected = f"a share from 0 to 1 for each of {len(labels)} conditions: {'; '.join(labels)}"
        raise BadValue("success", ",".join(f"{share:g}" for share in success), expected)
    elif not 0 <= shared <= 1:
        raise BadValue("shared", shared, "a share from 0 to 1")
    else:
        at, agents = dict(zip(labels, success, strict=True)), sum(not is_baseline(agent) for agent in study.agents)
        stated = [(family, tuple(at[label] for label in family.doses)) for family in families]
        effects = [
            Contrasts(agent=STATED, family=family, success=shares, agents=max(1, agents), shared=shared)
            for family, shares in stated
        ]
    found = zip(effects, detections(effects, how, study.seed), strict=True)
    return [
        (replace(one, agent=study.label_of(one.agent)), {label: needed(of, label, how) for label in one.asked})
        for one, of in found
    ]


def _played(study: Study, families: Sequence[Family], workers: Pool, progress: Progress) -> list[Contrasts]:
    """Every agent of a study in every family, by blocks of luck that it plays under all conditions."""
    for agent in study.agents:
        if not is_strategy(agent):
            raise BadValue("agent", agent, "a strategy that ships, or --success for any other")
    pools = played_blocks(study, POOL, workers=workers, progress=progress)
    labels, found = [one.label for one in study.conditions], list[Contrasts]()
    for agent, pool in zip(study.agents, pools, strict=True):
        for family in families:
            solved = pool[:, [labels.index(label) for label in family.doses]]
            shares = tuple(solved.mean(axis=0).tolist())
            found.append(Contrasts(agent=agent, family=family, success=shares, pool=solved))

    def judged(one: Contrasts) -> tuple[bool | str, ...]:
        """What is judged together: agents that the study is about, or baselines, in one family."""
        return is_baseline(one.agent), one.family.name, *one.family.doses

    heeding = Counter(judged(one) for one in found if one.pool is not None and (one.pool != one.pool[:, :1]).any())
    return [replace(one, agents=max(1, heeding[judged(one)])) for one in found]


_Job = tuple[Study, str, Condition, range]
"""Some trials of an agent under a condition, by their numbers; all of them where the kernel plays them."""


def played_blocks(
    study: Study, blocks: int, *, workers: Pool = THIS_PROCESS, progress: Progress = lambda done, of: None
) -> list[Flags]:
    """Play blocks of luck: one trial under each condition of a study, of equal repetition and number.

    Args:
        study: Agents that cost nothing to ask, conditions, settings and seed, whatever number of trials it asks for.
        blocks: Number of blocks of each agent.
        workers: The pool of processes that plays them; their number changes nothing.
        progress: Called with the number of trials played and their total.

    Returns:
        For each agent, whether each trial was solved, shape (blocks, conditions).
    """
    jobs = list[_Job]()
    for agent, condition in product(study.agents, study.conditions):
        many = blocks if _flip_alone(study, condition) else BATCH
        numbers = range(1, blocks + 1)
        jobs += [(study, agent, condition, numbers[first : first + many]) for first in range(0, blocks, many)]
    solved = list[bool]()
    for part in workers.map(_solved, jobs):
        solved += part
        progress(len(solved), blocks * len(study.agents) * len(study.conditions))
    table = np.array(solved).reshape(len(study.agents), len(study.conditions), blocks)
    return list(table.swapaxes(1, 2))


def _solved(job: _Job) -> list[bool]:
    """Whether each trial was solved. The kernel plays all at once where it can, and the same as the loop."""
    study, name, condition, numbers = job
    agent = resolve(name).make()
    if isinstance(agent, Policy) and (flip := _flip_alone(study, condition)) is not None:
        found = population(
            agent, study.box, p=flip.p, flip=flip, modality=condition.modality, trials=len(numbers), seed=study.seed,
            max_steps=study.max_steps, shuffle=study.shuffle,
        )  # fmt: skip
        return [bool(solved) for solved in found.solved]

    async def play() -> list[bool]:
        plans = (study.plan(name, condition, 1, number) for number in numbers)
        return [(await play_timed(plan, agent))[0].solved for plan in plans]

    return asyncio.run(play())


def _flip_alone(study: Study, condition: Condition) -> OutcomeFlip | None:
    """The flip, if nothing else acts in the trials; None if something does."""
    *acting, channel = interventions_for(condition)
    if (study.plant_of(condition), study.layout, len(study.boxes)) != ("symbolic", "fixed", 1):
        return None
    if type(channel) is not TextChannel or len(acting) > 1:
        return None
    flip = acting[0] if acting else OutcomeFlip()
    return flip if type(flip) is OutcomeFlip and flip == flip.at_rate(flip.p) else None
