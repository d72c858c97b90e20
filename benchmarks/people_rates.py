"""What is concluded of people whose boxes are alike: ``python benchmarks/people_rates.py [--studies 1000]``.

Simulated people play 4 p and 30 trials at each beside a simulated agent of the same truth: half of the boxes are solved
at every p. People are alike within one person, by how good that person is, or within one luck, by a share of the
variance behind each outcome; the agent's trials of one luck are alike too. ``within``: everybody plays one box at each
p; ``between``: everybody plays three or four at one p. Printed is

- the share of 95 % intervals of success that hold the truth, with people and luck taken together as the report does,
  and with luck alone, as for agents;
- the share of studies in which people and the agent are told apart over all p, though they are equal: by the report's
  test, and by exchange within luck, as for agents;
- the same of the changes with p, and of success at the lowest p;
- the share in which p is found to matter to people, which it does not;
- the share of intervals of median steps over the human median that hold the true ratio of 1.

Each should be at least .95 for intervals and at most .05 for tests.

A second table has people who play at one p only, of 7, with more boxes each: how often success is said to rise and fall
again (two lines), though nothing depends on p; and how often the interval of the finding (the clearest difference from
the lowest p) and that of success at one p hold the truth. ``alone`` takes a person's trials as independent.
"""

from __future__ import annotations

import argparse
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from lockprobe.simulation.audit.simulate import simulate_outcomes
from lockprobe.simulation.audit.simulated_agents import Design, World
from lockprobe.statistics.agent_comparison.pair import compare
from lockprobe.statistics.agent_comparison.paired import Sheet, sign_flip
from lockprobe.statistics.clustered import clustered_proportion, crossed_proportion, share_of
from lockprobe.statistics.inference.difference import any_difference
from lockprobe.statistics.inference.ushape import two_lines
from lockprobe.statistics.outcomes import Outcomes
from lockprobe.statistics.people import people
from lockprobe.statistics.proportions import ALPHA
from lockprobe.studies.running.single import run_trial
from lockprobe.trial.doses import FLIP_RATE
from lockprobe.trial.record import Trial

LUCKS, P, BUDGET = 30, (0.0, 0.2, 0.4, 0.6), 20
Array = NDArray[np.float64]
Names = NDArray[np.str_]


def seats(design: str) -> Names:
    """Who plays which trial, shape (lucks, p)."""
    made = np.empty((LUCKS, len(P)), dtype="U8")
    for luck in range(LUCKS):
        for place in range(len(P)):
            made[luck, place] = f"{(luck - place) % LUCKS}" if design == "within" else f"{place}-{luck * 8 // LUCKS}"
    return made


def latent(seat: Names, person: float, luck: float, shared: Array, rng: np.random.Generator) -> Array:
    """What decides each trial, standard normal, alike within people and within luck by these shares of its variance."""
    _, who = np.unique(seat, return_inverse=True)
    able = rng.standard_normal(int(who.max()) + 1)[who.reshape(seat.shape)]
    alone = rng.standard_normal(seat.shape)
    found: Array = person**0.5 * able + luck**0.5 * shared[:, None] + (1 - person - luck) ** 0.5 * alone
    return found


def sheet(hidden: Array, seat: Names | None = None) -> Sheet:
    """Half are solved, the sooner the higher it lies."""
    steps: Array = np.clip(np.ceil(12 - 8 * hidden), 4, BUDGET)
    solved: Array = (hidden > 0).astype(np.float64)
    return Sheet(solved=solved, steps=steps) if seat is None else Sheet(solved=solved, steps=steps, person=seat)


def rate(design: str, person: float, luck: float, studies: int, template: Trial) -> list[float]:
    """The shares of one line."""
    seat, rng = seats(design), np.random.default_rng([int(100 * person), int(100 * luck), len(design)])
    block = np.repeat(np.arange(LUCKS)[:, None], len(P), axis=1)
    counts = np.zeros(8)
    for number in range(studies):
        shared = rng.standard_normal(LUCKS)
        theirs = latent(seat, person, luck, shared, rng)
        own = latent(block.astype(np.str_), 0.4, luck, shared, rng)
        human, agent = sheet(theirs, seat), sheet(own)
        n = np.ones(human.solved.size)
        both = crossed_proportion(human.solved.ravel(), n, seat.ravel(), block.ravel())
        alone = clustered_proportion(human.solved.sum(axis=1), np.full(LUCKS, len(P)))
        found = compare((("a", ""), ("b", "")), P, (agent, human), "subjects", rng, budget=BUDGET)
        assert found is not None
        assert found.success.p_value is not None
        columns = Outcomes(
            dose=np.tile(P, LUCKS),
            repetition=np.ones(human.solved.size, dtype=np.int64),
            trial=block.ravel(),
            length=human.steps.ravel().astype(np.int64),
            solved=human.solved.ravel() > 0,
            onset=np.zeros(human.solved.size, dtype=np.int64),
            player=seat.ravel(),
        )
        matters = any_difference(columns, rng, 400).p_value
        counts += [
            both.low <= 0.5 <= both.high,
            alone.low <= 0.5 <= alone.high,
            found.success.p_value < ALPHA and found.success.clear,
            sign_flip((human.solved - agent.solved).sum(axis=1)) < ALPHA,
            found.interaction is not None and found.interaction.p_value < ALPHA,
            found.at[0].success.p_value < ALPHA,
            matters is not None and matters <= ALPHA,
            number % 4 == 0 and held(template, theirs, own, seat),
        ]
    counts[-1] *= 4
    shares: list[float] = (counts / studies).tolist()
    return shares


def held(template: Trial, theirs: Array, own: Array, seat: Names) -> bool:
    """Whether the interval of the ratio of medians holds 1, steps spread so that the median is within the budget."""
    made = []
    for (luck, place), name in np.ndenumerate(seat):
        for agent, hidden in ((f"participant:{name}", theirs), ("llm:a", own)):
            steps = int(np.clip(np.ceil(10 - 5 * hidden[luck, place]), 4, BUDGET + 1))
            made.append(
                replace(
                    template,
                    agent=agent,
                    condition=f"flip?p={P[place]:g}",
                    specs=(f"flip?p={P[place]:g}",),
                    doses={FLIP_RATE: P[place]},
                    trial=luck + 1,
                    steps=template.steps[:1] * min(steps, BUDGET),
                    ending="solved" if steps <= BUDGET else "budget",
                )
            )
    found = people(made)
    assert found is not None
    over = found.relative[-1]
    return (over.low is None or over.low <= 1) and (over.high is None or over.high >= 1)


def at_one_p(people_at_p: int, boxes: int, likeness: float, studies: int) -> list[float]:
    """The shares of one line of the second table."""
    design = Design(repetitions=1, trials=people_at_p * boxes)
    truth = World(name="people", says="", success=(0.5,) * 7, people=people_at_p, likeness=likeness, truths=frozenset())
    counts = np.zeros(6)
    for number in range(studies):
        rng = np.random.default_rng([number, people_at_p, boxes])
        columns = simulate_outcomes(truth, design, rng)
        first = columns.at(columns.dose == 0)
        together, alone = (
            any_difference(made, rng, 99).clearest
            for made in (columns, replace(columns, player=np.empty(0, dtype=np.str_)))
        )
        assert together is not None
        assert alone is not None
        of_one = share_of(first.solved, first.player, first.luck), share_of(first.solved, [], first.luck)
        counts += [
            two_lines(columns.dose, columns.solved).direction == "inverted U",
            two_lines(columns.dose, columns.solved, columns.cluster).direction == "inverted U",
            *(found.low <= 0 <= found.high for found in (alone, together)),
            *(found.low <= 0.5 <= found.high for found in of_one[::-1]),
        ]
    shares: list[float] = (counts / studies).tolist()
    return shares


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--studies", type=int, default=1000)
    studies = parser.parse_args().studies
    template = run_trial(agent="random")
    head = ("interval", "luck only", "over all p", "exchange", "changes", "lowest p", "p matters", "ratio")
    print(f"{'design':8} {'person':>6} {'luck':>6}  " + "  ".join(f"{name:>10}" for name in head))
    for design in ("within", "between"):
        for person, luck in ((0.0, 0.0), (0.2, 0.0), (0.5, 0.0), (0.0, 0.5), (0.35, 0.35)):
            shares = rate(design, person, luck, studies, template)
            row = "  ".join(f"{share:10.3f}" for share in shares)
            print(f"{design:8} {person:6.2f} {luck:6.2f}  {row}", flush=True)
    print(
        "\npeople x boxes  alike   rise and fall: alone, as reported   finding: alone, as reported   one p: alone, ..."
    )
    for people_at_p, boxes, likeness in ((30, 1, 0.0), (10, 3, 0.35), (6, 5, 0.5), (6, 10, 0.5)):
        row = "  ".join(f"{share:10.3f}" for share in at_one_p(people_at_p, boxes, likeness, studies))
        print(f"{people_at_p:6} x {boxes:<6} {likeness:5.2f}  {row}", flush=True)


if __name__ == "__main__":
    main()
