"""How often the first sentence of a report is false: ``python benchmarks/finding_rates.py [--studies 300]``.

Simulated agents of known truth. Printed is the share of studies in which an effect of p on success is found

- where other trials are solved at the lowest p than at all others, which go alike, but not more of them (*unequal
  luck*): by the permutation alone, and with the interval that has to leave out 0;
- where there is an effect, which is the price;
- where nothing depends on p, but calls fail at p = 0.6 and break long trials: by the permutation without the broken
  trials, with the interval, and over what may have become of the broken trials;

then the share of studies of thirteen agents, to whom p does nothing, in which a course is said of one at least, each
agent by itself and as one of thirteen; and the share in which loops seem to begin sooner, where half of the trials are
lost whatever p is, so that those still running at a high p are mostly lost ones (log-rank; the report names what it
assumes).
"""

from __future__ import annotations

import argparse
from dataclasses import replace

import numpy as np

from lockprobe.foundation.seeds import generator
from lockprobe.simulation.audit.simulate import simulate_columns, simulate_outcomes
from lockprobe.simulation.audit.simulated_agents import WORLDS, Design, World
from lockprobe.statistics.inference.broken_trials import completed, worst_case_difference
from lockprobe.statistics.inference.course import course
from lockprobe.statistics.inference.difference import any_difference
from lockprobe.statistics.inference.logrank import loop_onset_logrank
from lockprobe.statistics.inference.ushape import corrected, two_lines
from lockprobe.statistics.outcomes import points
from lockprobe.statistics.proportions import ALPHA, proportion

PERMUTATIONS = 400


def flat(values: int) -> World:
    """Unequal luck over so many p."""
    p = tuple(i / max(10, values - 1) for i in range(values))
    return replace(WORLDS["unequal-luck"], success=(0.5,) * values, trap=(0.0,) * values, design=Design(p=p))


def judged(truth: World, design: Design, number: int) -> list[bool]:
    """Whether one study finds an effect: by permutation alone, with the interval, over what became of broken trials."""
    counted, broken = simulate_columns(truth, design, generator(number, truth.name, design.clusters))
    rng = np.random.default_rng(number)
    found = any_difference(counted, rng, PERMUTATIONS)
    worst_case = found
    if len(broken):
        ends = [any_difference(whole, rng, PERMUTATIONS) for whole in completed(counted, broken)]
        worst_case = worst_case_difference(found, *ends)
    p_values = [min(at.exchange for at in found.at), found.p_value, worst_case.p_value]
    return [p_value is not None and p_value < ALPHA for p_value in p_values]


def thirteen(number: int) -> list[bool]:
    """Whether a course is said of some agent: each by itself, and as one of thirteen."""
    truth = WORLDS["no-effect"]
    drawn = [simulate_outcomes(truth, truth.design, generator(number, "agents", agent)) for agent in range(13)]
    said = []
    for agents in (1, len(drawn)):
        kinds = []
        for one in drawn:
            difference = any_difference(one, np.random.default_rng(number), PERMUTATIONS, agents=agents)
            lines = corrected(two_lines(one.dose, one.solved), agents)
            seen = course(points(one, by_repetition=False), difference, lines)
            assert seen is not None
            kinds.append(seen.kind)
        said.append(any(kind != "no change detectable" for kind in kinds))
    return said


def sooner(trials: int, number: int) -> list[bool]:
    """Whether loops seem to begin sooner where p changes success, and no trial loops otherwise."""
    truth = replace(WORLDS["lost-half"], success=(0.0, 0.5, 0.9, 0.97, 0.98, 0.99, 0.99))
    found = loop_onset_logrank(simulate_outcomes(truth, Design(trials=trials), generator(number, "sooner"))).primary
    return [found is not None and found.p_value is not None and found.p_value < ALPHA and found.direction > 0]


def line(name: str, rows: list[list[bool]]) -> None:
    """Print the shares of one line with their 95 % intervals."""
    shares = [proportion(int(sum(column)), len(rows)) for column in np.array(rows).T]
    said = " | ".join(f"{share.value:.3f} [{share.low:.3f}, {share.high:.3f}]" for share in shares)
    print(f"| {name} | {said} |", flush=True)


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--studies", type=int, default=300)
    studies = range(parser.parse_args().studies)
    print("| world, p x trials | permutation alone | with the interval | as reported |\n|" + "---|" * 4)
    for values, trials in ((7, 30), (11, 100), (21, 30)):
        truth = flat(values)
        design = replace(truth.design, repetitions=1, trials=trials)
        line(f"unequal luck, {values} x {trials}", [judged(truth, design, number) for number in studies])
    strong = replace(WORLDS["no-effect"], name="strong", success=(0.2, *(0.9,) * 6))
    for name, truth in (("a rise and fall like the paper's", WORLDS["loops-irrelevant"]), ("0.2, then 0.9", strong)):
        for repetitions in (10, 3):
            design = Design(trials=repetitions)
            line(f"{name}, 7 x {design.clusters}", [judged(truth, design, number) for number in studies])
    for trials in (10, 30):
        design = Design(trials=trials)
        rows = [judged(WORLDS["broken-trials"], design, number) for number in studies]
        line(f"calls fail at one p, 7 x {design.clusters}", rows)
    print("\n| thirteen agents, no effect | each by itself | together |\n|" + "---|" * 3)
    line("some course is said", [thirteen(number) for number in studies])
    print("\n| dependent censoring | loops begin sooner |\n|" + "---|" * 2)
    for trials in (10, 30):
        line(f"7 x {3 * trials}", [sooner(trials, number) for number in studies])


if __name__ == "__main__":
    main()
