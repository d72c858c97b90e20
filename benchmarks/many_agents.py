"""How often what a report says of many agents is false, where nothing differs; and what is found where something does.

A sentence that names those of many agents that change, or the best of them, is false if one of its parts is. Simulated
agents of known truth play whole studies, suites or crossings, and what the report would say of them is counted. Studies
pass through the same functions as a user's. ``audit.py`` runs this.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from lockprobe.foundation.parallel import THIS_PROCESS, Pool
from lockprobe.foundation.seeds import generator
from lockprobe.simulation.audit.rates import standard_error, within_error
from lockprobe.simulation.audit.simulate import simulate_outcomes
from lockprobe.simulation.audit.simulated_agents import WORLDS, Design, World
from lockprobe.statistics.conditions.effects import interactions
from lockprobe.statistics.conditions.series import Crossing
from lockprobe.statistics.inference.course import course
from lockprobe.statistics.inference.difference import any_difference
from lockprobe.statistics.inference.ushape import corrected, two_lines
from lockprobe.statistics.outcomes import Outcomes, points, solved_in_pairs
from lockprobe.statistics.proportions import proportion
from lockprobe.statistics.suite.ranks import possible_ranks
from lockprobe.statistics.suite.scores import change_of_success, share_over_levels

_BATCH = 5
"""Studies that a process plays before it reports."""

_NULL = replace(WORLDS["no-effect"], success=(0.5,) * 2, trap=(0.0,) * 2)


@dataclass(frozen=True, slots=True, kw_only=True)
class ManyAgents:
    """A world of several agents, and what a report would say of them.

    Attributes:
        name: Its name.
        says: The truth in one sentence.
        agents: Number of agents.
        sentences: Sentence -> whether it is true.
        play: Plays one study: number of agents and a stream -> sentence -> whether the report says it.
    """

    name: str
    says: str
    agents: int
    sentences: Mapping[str, bool]
    play: Callable[[int, np.random.Generator], dict[str, bool]]


@dataclass(frozen=True, slots=True, kw_only=True)
class SentenceRate:
    """The share of studies in which a report says something of many agents.

    Attributes:
        world: Name of the world.
        agents: Number of agents.
        sentence: What is said.
        truth: Whether it is true: False for a false-positive rate, True for power.
        studies: Number of studies.
        said: Studies in which it is said.
    """

    world: str
    agents: int
    sentence: str
    truth: bool
    studies: int
    said: int

    @property
    def rate(self) -> float:
        """The share of studies in which it is said, [0, 1]."""
        return self.said / self.studies

    @property
    def error(self) -> float:
        """Monte Carlo standard error of the rate, after adding one study of each outcome."""
        return standard_error(self.said, self.studies)

    @property
    def valid(self) -> bool | None:
        """Whether a false-positive rate is at most 0.05 within Monte Carlo error; None for power."""
        return None if self.truth else within_error(self.said, self.studies)


CHANGES = "some agent changes"
GIVEN = "a given agent changes"
ORDER = "one agent is more competent than another"
MOVED = "false reports change the competence of the best"
MISSED = "the interval of some agent leaves out its competence"
DEPENDS = "some interaction differs from 0"


def _flips(world: World, design: Design) -> Callable[[int, np.random.Generator], dict[str, bool]]:
    """Studies of flip rates, or of as many conditions: what the first sentence says of the agents."""

    def play(agents: int, rng: np.random.Generator) -> dict[str, bool]:
        changed = [_changes(simulate_outcomes(world, design, rng), rng, agents) for _ in range(agents)]
        return {CHANGES: any(changed), GIVEN: changed[0]}

    return play


def _changes(found: Outcomes, rng: np.random.Generator, agents: int) -> bool:
    difference = any_difference(found, rng, agents=agents)
    lines = corrected(two_lines(found.dose, found.solved), agents)
    seen = course(points(found, by_repetition=False), difference, lines)
    return seen is not None and seen.kind not in ("no change detectable", "not tested")


_LEVELS = (0.8, 0.65, 0.5, 0.3)
"""Success at each level of the simulated suites."""

_ABLE = (0.99, 0.99, 0.98, 0.96)
"""The same of agents that open nearly every box."""

_PAIRS = 36
"""Trials of a level with true reports, and as many with false ones."""


def _suite(
    drop: float = 0.0, levels: Sequence[float] = _LEVELS
) -> Callable[[int, np.random.Generator], dict[str, bool]]:
    """Suites of equal agents whose success false reports lower by so much."""

    def level(success: float, rng: np.random.Generator) -> Outcomes:
        ones = np.ones(_PAIRS, dtype=np.int64)
        solved = rng.random(_PAIRS) < success
        trial = np.arange(1, _PAIRS + 1)
        return Outcomes(dose=np.zeros(_PAIRS), repetition=ones, trial=trial, length=ones, solved=solved, onset=0 * ones)

    def play(agents: int, rng: np.random.Generator) -> dict[str, bool]:
        told = [[level(one, rng) for one in levels] for _ in range(agents)]
        best = max(told, key=lambda own: sum(float(one.solved.mean()) for one in own))
        misled = [level(one - drop, rng) for one in levels]
        moved = change_of_success([solved_in_pairs(*both) for both in zip(best, misled, strict=True)], agents)
        sizes = [
            share_over_levels([proportion(int(one.solved.sum()), len(one)) for one in own], agents) for own in told
        ]
        truth = sum(levels) / len(levels)
        return {
            ORDER: any(ranks != (1, agents) for ranks in possible_ranks(told)),
            MOVED: moved is not None and (moved.low > 0 or moved.high < 0),
            MISSED: any(not size.low <= truth <= size.high for size in sizes),
        }

    return play


_CROSSED = [
    Crossing(neither="truth", first=one, second=other, both=one + other)
    for i, one in enumerate("abcd")
    for other in "abcd"[i + 1 :]
]
"""Six crossings of four interventions."""


def _crossings(agents: int, rng: np.random.Generator) -> dict[str, bool]:
    names = ["truth", *"abcd", *(one.both for one in _CROSSED)]
    found = {name: simulate_outcomes(_ONE, Design(p=(0.0,), repetitions=1, trials=30), rng) for name in names}
    interplays, _ = interactions(_CROSSED, (), found, agents)
    return {DEPENDS: any(one.detectable for one in interplays)}


_ONE = replace(_NULL, success=(0.5,), trap=(0.0,))
_FOUR = replace(_NULL, success=(0.5,) * 4, trap=(0.0,) * 4)
_RAISED = replace(_NULL, success=(0.23, 0.63), trap=(0.0,) * 2)

MANY_AGENTS: Mapping[str, ManyAgents] = {
    made.name: made
    for made in (
        ManyAgents(
            name="ten-agents",
            says="Nothing depends on the flip rate; two flip rates with 18 trials each.",
            agents=10,
            sentences={CHANGES: False},
            play=_flips(_NULL, Design(p=(0.0, 0.4), repetitions=1, trials=18)),
        ),
        ManyAgents(
            name="ten-agents-four-conditions",
            says="Nothing depends on the condition, of which there are four with 30 trials each.",
            agents=10,
            sentences={CHANGES: False},
            play=_flips(_FOUR, Design(p=(0.0, 0.2, 0.4, 0.6), repetitions=1, trials=30)),
        ),
        ManyAgents(
            name="ten-agents-raised",
            says="Success rises from 0.23 to 0.63 for every agent; two flip rates with 30 trials each.",
            agents=10,
            sentences={CHANGES: True, GIVEN: True},
            play=_flips(_RAISED, Design(p=(0.0, 0.4), repetitions=1, trials=30)),
        ),
        *(
            ManyAgents(
                name=f"suite-of-{agents}",
                says="Agents are equally competent, and false reports change nothing.",
                agents=agents,
                sentences={ORDER: False, MOVED: False, MISSED: False},
                play=_suite(),
            )
            for agents in (1, 5, 10, 20)
        ),
        ManyAgents(
            name="suite-of-20-able",
            says="Agents are equally competent and open nearly every box, and false reports change nothing.",
            agents=20,
            sentences={ORDER: False, MOVED: False, MISSED: False},
            play=_suite(levels=_ABLE),
        ),
        ManyAgents(
            name="suite-of-10-lowered",
            says="Agents are equally competent, and false reports lower the success of each by 20 points.",
            agents=10,
            sentences={ORDER: False, MOVED: True, MISSED: False},
            play=_suite(0.2),
        ),
        ManyAgents(
            name="six-crossings",
            says="Four interventions, alone and in pairs, change nothing; 30 trials of one agent under each condition.",
            agents=1,
            sentences={DEPENDS: False},
            play=_crossings,
        ),
    )
}
"""Worlds of many agents by name."""


@dataclass(frozen=True, slots=True, kw_only=True)
class _Range:
    """Studies of one world, the work of one job: numbers ``first`` to ``end`` - 1."""

    world: str
    seed: int
    first: int
    end: int


def sentence_rates(
    names: Sequence[str],
    *,
    studies: int,
    seed: int = 1,
    workers: Pool = THIS_PROCESS,
) -> list[SentenceRate]:
    """Simulate studies of many agents and count what a report would say.

    Args:
        names: Keys of :data:`MANY_AGENTS`.
        studies: Studies of each world, at least 1.
        seed: Seed of everything; the number of workers changes nothing.
        workers: The pool of processes that simulates the studies.
    """
    jobs = [
        _Range(world=name, seed=seed, first=first, end=min(first + _BATCH, studies))
        for name in names
        for first in range(0, studies, _BATCH)
    ]
    said = Counter[tuple[str, str]]()
    for job, found in zip(jobs, workers.map(_played, jobs), strict=True):
        said.update({(job.world, sentence): count for sentence, count in found.items()})
    return [
        SentenceRate(
            world=name,
            agents=MANY_AGENTS[name].agents,
            sentence=sentence,
            truth=truth,
            studies=studies,
            said=said[name, sentence],
        )
        for name in names
        for sentence, truth in MANY_AGENTS[name].sentences.items()
    ]


def _played(job: _Range) -> dict[str, int]:
    world, said = MANY_AGENTS[job.world], Counter[str]()
    for number in range(job.first, job.end):
        found = world.play(world.agents, generator(job.seed, "audit", world.name, number))
        said.update(sentence for sentence, says in found.items() if says)
    return dict(said)
