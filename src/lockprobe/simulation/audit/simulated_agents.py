"""Simulated agents with known truth (worlds), and their designs.

A *world* states the success at each p, the agent's tendency to fall into cycles, and whether a complete loop makes
solving less likely. Nothing else differs between conditions. :mod:`lockprobe.simulation.audit.simulate` plays them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache

from lockprobe.interventions.conditions import flips
from lockprobe.statistics.inference.verdict import Question
from lockprobe.trial.condition import Condition

__all__ = ["WORLDS", "Design", "P", "World"]

P = (0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6)
MANY_P = tuple(i / 20 for i in range(21))


@dataclass(frozen=True, slots=True, kw_only=True)
class Design:
    """The size of a study; the paper's flip study by default (Sec. 3.2).

    Attributes:
        p: Flip probabilities, ascending.
        repetitions: Repetitions of the design.
        trials: Trials per repetition and p.
    """

    p: tuple[float, ...] = P
    repetitions: int = 3
    trials: int = 10

    @property
    def conditions(self) -> tuple[Condition, ...]:
        """A condition for every p."""
        return _conditions(self.p)

    @property
    def clusters(self) -> int:
        """Trials per p."""
        return self.repetitions * self.trials


@cache
def _conditions(p: tuple[float, ...]) -> tuple[Condition, ...]:
    """The conditions of all designs with these flip rates: every simulated trial asks for its own."""
    return flips(p, modalities=("symbolic",))


@dataclass(frozen=True, slots=True, kw_only=True)
class World:
    """A world: the truth about a simulated agent. ``success`` and ``trap`` have one value per p, ascending.

    Attributes:
        name: Its name.
        says: The truth in one sentence.
        success: Probability of solving the box within the budget if loops do no harm, [0, 1].
        trap: Probability per step of falling into a cycle of three or four actions, [0, 1]; 0 acts at random
            throughout.
        harm: Factor on the probability of solving once a loop is complete; 1 if loops are irrelevant, below 1 if they
            hurt.
        shared: Share of trials with the same luck at every p, [0, 1].
        apart: Whether the lowest p has different luck in spite of ``shared``: success is equal at every p, but in
            different trials.
        people: People who play at each p, each at a single p; 0 for an agent.
        likeness: Intraclass correlation of one person's trials, on the latent scale, [0, 1).
        breaks: Probability per step that a call fails and ends the trial as error, at each p, [0, 1).
        repeats: Whether an action may be repeated at once outside of cycles.
        lost: Share of trials in which the agent falls into cycles and hardly ever solves the box, at any p, [0, 1].
        slow: Share of blocks of luck in which the box opens with the last step at every p but the lowest, [0, 1). At
            the lowest p it takes five to seven steps, and in the other blocks so many less that means are equal. 0 if
            the time to solve is drawn as ``success`` states, which is 1 otherwise.
        leaves: Probability that a person who has not solved a box leaves and plays none of the others, [0, 1].
        design: The default design.
        truths: Questions whose true answer is yes.
    """

    name: str
    says: str
    success: tuple[float, ...]
    truths: frozenset[Question]
    trap: tuple[float, ...] = (0.0,) * len(P)
    harm: float = 1.0
    shared: float = 0.0
    apart: bool = False
    people: int = 0
    likeness: float = 0.0
    breaks: tuple[float, ...] = ()
    repeats: bool = False
    lost: float = 0.0
    slow: float = 0.0
    leaves: float = 0.0
    design: Design = Design()


WORLDS: Mapping[str, World] = {
    made.name: made
    for made in (
        World(
            name="no-effect",
            says="Nothing depends on the flip rate, and loops are irrelevant.",
            success=(0.5,) * 7,
            truths=frozenset(),
        ),
        World(
            name="shared-luck",
            says="Nothing depends on the flip rate, loops are irrelevant, and half of the trials go alike at every "
            "flip rate.",
            success=(0.5,) * 7,
            shared=0.5,
            truths=frozenset(),
        ),
        World(
            name="loops-irrelevant",
            says="Success rises and falls, so that trials differ in length; actions are random and loops irrelevant.",
            success=(0.23, 0.4, 0.53, 0.63, 0.67, 0.6, 0.5),
            truths=frozenset({"success", "speed", "shape"}),
        ),
        World(
            name="loop-trapped",
            says="Told the truth the agent falls into cycles, and a loop keeps it from solving; false reports free it.",
            success=(0.85,) * 7,
            trap=(0.5, 0.25, 0.12, 0.06, 0.03, 0.03, 0.03),
            harm=0.1,
            truths=frozenset({"success", "speed", "looping", "harm"}),
        ),
        World(
            name="uniform",
            says="Nothing depends on the flip rate, loops are irrelevant, and any action may follow any, the same too.",
            success=(0.5,) * 7,
            repeats=True,
            truths=frozenset(),
        ),
        World(
            name="loops-return",
            says="The agent falls into cycles at low and at high flip rates, least often at 0.3; loops are irrelevant.",
            success=(0.5,) * 7,
            trap=(0.5, 0.25, 0.1, 0.03, 0.1, 0.25, 0.5),
            truths=frozenset({"looping", "looping again"}),
        ),
        World(
            name="saturating",
            says="Success rises and stays; loops are irrelevant.",
            success=(0.23, 0.45, 0.57, 0.63, 0.66, 0.67, 0.67),
            truths=frozenset({"success", "speed"}),
        ),
        World(
            name="inverted-u",
            says="Success rises to 0.9 and falls to 0.2; loops are irrelevant.",
            success=(0.2, 0.55, 0.8, 0.9, 0.8, 0.55, 0.2),
            truths=frozenset({"success", "speed", "shape"}),
        ),
        World(
            name="lost-half",
            says="Nothing depends on the flip rate, and loops change nothing; but in half of the trials the agent is "
            "lost, and then it both loops and fails: success is rarer after a loop, and not because of it.",
            success=(0.9,) * 7,
            lost=0.5,
            truths=frozenset({"harm"}),
        ),
        World(
            name="many-p",
            says="Nothing depends on the flip rate, of which there are 21, and loops are irrelevant.",
            success=(0.5,) * 21,
            trap=(0.0,) * 21,
            design=Design(p=MANY_P),
            truths=frozenset(),
        ),
        World(
            name="unequal-luck",
            says="Success is the same at every flip rate, but other trials are solved at the lowest than at all "
            "others, which go alike.",
            success=(0.5,) * 7,
            shared=1.0,
            apart=True,
            truths=frozenset(),
        ),
        World(
            name="unequal-luck-many-p",
            says="The same with 21 flip rates.",
            success=(0.5,) * 21,
            trap=(0.0,) * 21,
            shared=1.0,
            apart=True,
            design=Design(p=MANY_P),
            truths=frozenset(),
        ),
        World(
            name="people",
            says="Nothing depends on the flip rate; at each six people play five boxes each, and are "
            "unequally good (0.5).",
            success=(0.5,) * 7,
            people=6,
            likeness=0.5,
            truths=frozenset(),
        ),
        World(
            name="people-60",
            says="The same with ten boxes each.",
            success=(0.5,) * 7,
            people=6,
            likeness=0.5,
            design=Design(trials=20),
            truths=frozenset(),
        ),
        World(
            name="skewed-steps",
            says="Every trial is solved, and the mean number of steps is the same at every flip rate; but at all "
            "except the lowest one block of trials in 20 takes the whole budget, and the others take less.",
            success=(1.0,) * 7,
            slow=0.05,
            truths=frozenset(),
        ),
        World(
            name="dropout",
            says="Nothing depends on the flip rate; at each ten people, unequally good (0.5), are given six boxes "
            "each, and after each that they do not open half of them leave.",
            success=(0.5,) * 7,
            people=10,
            likeness=0.5,
            leaves=0.5,
            design=Design(trials=20),
            truths=frozenset(),
        ),
        World(
            name="broken-trials",
            says="Nothing depends on the flip rate and loops are irrelevant, but at 0.6 a call fails with probability "
            "0.08, which breaks long trials.",
            success=(0.5,) * 7,
            breaks=(0.0,) * 6 + (0.08,),
            truths=frozenset(),
        ),
        World(
            name="seldom-broken",
            says="The same with a probability of 0.02, so that few trials break.",
            success=(0.5,) * 7,
            breaks=(0.0,) * 6 + (0.02,),
            truths=frozenset(),
        ),
    )
}
"""Worlds by name, in the paper's design unless a world states another."""
