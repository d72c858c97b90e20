"""How often two agents are told apart: ``python benchmarks/comparison_rates.py [--studies 2000]``.

Simulated agents of known truth play the paper's design, 7 p and 30 trials at each, and are compared as two agents of
any study are. Luck is shared over p by no trial, half of them or all, and between the two agents by none or all.
Printed is the share of studies in which each test rejects at .05, without correction for several pairs, and the share
of 95 % intervals that hold the truth. Where the truth is no difference the share should be at most .05; a star marks
it. Success and steps are judged as the report does: the test rejects, and the interval leaves out 0. ``any p`` is the
largest of all changes, from which the report concludes. ``mean`` are flips of the signs of the changes' mean over all
higher p, which the report does not test: it does not keep its level where agents seldom differ.

A second table has agents that are equal on average and play differently, where the test alone goes wrong and why the
report asks for the interval too; studies of 10, 30 and 60 blocks of luck.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lockprobe.simulation.audit.simulate import simulate_outcomes
from lockprobe.simulation.audit.simulated_agents import Design, World
from lockprobe.statistics.agent_comparison.pair import AgentComparison, compare, corrected
from lockprobe.statistics.agent_comparison.paired import Sheet, sheets, sign_flip
from lockprobe.statistics.proportions import ALPHA

FLAT = (0.5,) * 7
PEAK = (0.23, 0.4, 0.53, 0.63, 0.67, 0.6, 0.5)
"""The rise and fall of the paper's GPT-4o: 0.23 at p = 0 and 0.67 at 0.4 are its figures."""


@dataclass(frozen=True, kw_only=True)
class Case:
    """Two agents: how often each solves the box at every p."""

    name: str
    first: tuple[float, ...]
    second: tuple[float, ...]

    @property
    def apart(self) -> float:
        """Difference over all p."""
        return float(np.mean(self.second) - np.mean(self.first))

    @property
    def changes(self) -> NDArray[np.float64]:
        """Difference of the changes from the lowest p."""
        away: NDArray[np.float64] = np.array(self.second) - np.array(self.first)
        changes: NDArray[np.float64] = away[1:] - away[0]
        return changes


CASES = (
    Case(name="equal, 0.5", first=FLAT, second=FLAT),
    Case(name="equal, rising and falling", first=PEAK, second=PEAK),
    Case(name="0.3 and 0.7, noise does nothing", first=(0.3,) * 7, second=(0.7,) * 7),
    Case(name="0.4 and 0.95, noise does nothing", first=(0.4,) * 7, second=(0.95,) * 7),
    Case(name="0.05 and 0.3, noise does nothing", first=(0.05,) * 7, second=(0.3,) * 7),
    Case(name="both rise and fall, 0.3 apart", first=PEAK, second=tuple(p + 0.3 for p in PEAK)),
    Case(name="0.5 and 0.6, noise does nothing", first=FLAT, second=(0.6,) * 7),
    Case(name="0.5, and rising and falling", first=FLAT, second=PEAK),
    Case(name="0.5, and falling to 0.2", first=FLAT, second=(0.5, 0.45, 0.4, 0.35, 0.3, 0.25, 0.2)),
)


def compared(case: Case, design: Design, shared: float, number: int, *, alike: bool) -> tuple[AgentComparison, float]:
    """One study: two agents that share luck over p, and with each other or not; and the p-value of the mean change."""
    groups = [
        simulate_outcomes(
            World(name=name, says="", success=success, shared=shared, truths=frozenset()),
            design,
            np.random.default_rng([number, 0 if alike else i]),
        )
        for i, (name, success) in enumerate((("first", case.first), ("second", case.second)))
    ]
    values, (one, two) = sheets(groups)
    found = compare(
        (("first", ""), ("second", "")), values, (one, two), "subjects", np.random.default_rng([number, 2]), budget=20
    )
    assert found is not None
    apart = two.solved - one.solved
    return corrected([found])[0], sign_flip((apart[:, 1:] - apart[:, :1]).sum(axis=1))


def judged(case: Case, found: AgentComparison, mean_p: float) -> list[float]:
    """Whether each test rejects, and how many of its intervals hold the truth."""
    moved = found.interaction
    assert moved is not None
    low, high = found.success.low, found.success.high
    held = [
        at.change.low <= truth <= at.change.high
        for at, truth in zip(moved.at, case.changes, strict=True)
        if at.change.low is not None and at.change.high is not None
    ]
    mean = moved.mean
    return [
        found.verdict != 0,
        min(at.p_adjusted or 0.0 for at in found.at) < ALPHA,
        found.steps_verdict != 0,
        moved.p_value < ALPHA,
        mean_p < ALPHA,
        low is not None and high is not None and low <= case.apart <= high,
        float(np.mean(held)),
        mean.low is not None and mean.high is not None and mean.low <= case.changes.mean() <= mean.high,
    ]


def seldom_but_wholly(blocks: int, rng: np.random.Generator) -> tuple[Sheet, Sheet]:
    """Equal shares: the first fails at p = 0 alone, in half of the blocks; the second seldom, but then at every p."""
    first, second = np.ones((2, blocks, 7))
    first[:, 0] = rng.random(blocks) < 1 / 2
    second[rng.random(blocks) < 1 / 14] = 0
    return Sheet(solved=first, steps=np.where(first > 0, 10.0, 20.0)), Sheet(
        solved=second, steps=np.where(second > 0, 10.0, 20.0)
    )


def mostly_faster(blocks: int, rng: np.random.Generator) -> tuple[Sheet, Sheet]:
    """Equal steps: the first always needs 5; the second 4, but 20 in one block of 16; alike at every p."""
    first, solved = np.full((blocks, 7), 5.0), np.ones((blocks, 7))
    second = np.repeat(np.where(rng.random((blocks, 1)) < 1 / 16, 20.0, 4.0), 7, axis=1)
    return Sheet(solved=solved, steps=first), Sheet(solved=solved, steps=second)


def lopsided(studies: int) -> None:
    """Print how often agents that are equal on average are taken for different ones."""
    print("\n| equal on average | blocks | success, test alone | success | steps, test alone | steps |\n|" + "---|" * 6)
    for world in (seldom_but_wholly, mostly_faster):
        for blocks in (10, 30, 60):
            said = []
            for number in range(studies):
                laid = world(blocks, np.random.default_rng([number, blocks]))
                rng = np.random.default_rng([number, 3])
                found = compare((("first", ""), ("second", "")), Design().p, laid, "reference", rng, budget=20)
                assert found is not None
                one = corrected([found])[0]
                rejected = [(adjusted or 0.0) < ALPHA for adjusted in (one.success_adjusted, one.steps_adjusted)]
                said.append([rejected[0], one.verdict != 0, rejected[1], one.steps_verdict != 0])
            shares = " | ".join(f"{share:.3f}" for share in np.mean(said, axis=0))
            print(f"| {world.__name__.replace('_', ' ')} | {blocks} | {shares} |", flush=True)


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description="False positives and power of the comparisons of two agents.")
    parser.add_argument("--studies", type=int, default=2000)
    parser.add_argument("--trials", type=int, default=10, help="in each of three repetitions, at every p")
    parser.add_argument("--shared", type=float, nargs="+", default=[0.0, 0.5, 1.0], help="luck shared over p")
    chosen = parser.parse_args()
    design = Design(trials=chosen.trials)
    print(
        "| agents | over p | with each other | success | success at some p | steps | changes, any p | changes, mean ",
        end="",
    )
    print("| interval of success | of a change | of the mean |\n|" + "---|" * 11)
    for case in CASES:
        for shared in chosen.shared:
            for alike in (False, True):
                rows = [judged(case, *compared(case, design, shared, i, alike=alike)) for i in range(chosen.studies)]
                said = [f"{share:.3f}" for share in np.mean(rows, axis=0)]
                same_share = abs(case.apart) < 1e-9
                same, still = case.first == case.second, np.allclose(case.changes, 0)
                for i, null in enumerate((same_share, same, same, still, still)):
                    said[i] += " *" * bool(null)
                print(f"| {case.name} | {shared:g} | {'all' if alike else 'none'} | {' | '.join(said)} |", flush=True)
    lopsided(chosen.studies)


if __name__ == "__main__":
    main()
