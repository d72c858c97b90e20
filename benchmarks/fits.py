"""Fits of cognitive models: what one would write with SciPy against Lockprobe, on the same choices, in one run.

    OMP_NUM_THREADS=1 python benchmarks/fits.py [--trials 2100]

CPU time. The model is ``softmax-memory``, with eight parameters. One would first replay the policy, trial by trial;
then compute all choices at once with NumPy; both are maximised by L-BFGS-B of SciPy from one start. Lockprobe goes from
four starts. The last row is all that ``lockprobe fit`` does with these trials, eleven models with intervals and ten
folds, of which it takes 20 000 choices at random.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray
from recovery import Study
from scipy.optimize import minimize

from lockprobe.agents.cognitive import SoftmaxMemory
from lockprobe.simulation.fit import fit_agents
from lockprobe.simulation.fit.candidate_models import RIVALS
from lockprobe.simulation.fit.choices import Choices, Heard, choices_of, hear
from lockprobe.simulation.fit.likelihood import BOUND
from lockprobe.simulation.fit.optimise import maximum

AGENT = "cognitive:softmax-memory?target=1&closed=0.5&failure=2&decay=0.8&reset=0.5&recent=-1&stay=0.5&position=0.5"
NAMES = ("target", "closed", "failure", "recent", "stay", "position", "decay", "reset")
BOUNDS = [(-BOUND, BOUND)] * 6 + [(0.0, 1.0)] * 2
START = (0.0,) * 6 + (0.9, 0.5)
REPLAYED = 20
"""One trial in so many is replayed, because replaying all takes minutes."""

Values = NDArray[np.float64]


def replayed(heard: Sequence[Heard]) -> Callable[[Values], float]:
    """Minus the log-likelihood, by the agent itself, which hears every trial again."""

    def fall(values: Values) -> float:
        agent = SoftmaxMemory(**dict(zip(NAMES, map(float, values), strict=True)))
        found = 0.0
        for one in heard:
            memory = agent.begin(one.view)
            for joint, told in zip(one.chosen, one.told, strict=True):
                found -= float(np.log(max(agent.probabilities(one.view, memory)[joint], 1e-300)))
                assert told is not None
                memory = agent.remember(one.view, memory, told)
        return found

    return fall


def at_once(choices: Choices) -> Callable[[Values], float]:
    """Minus the log-likelihood of all choices, by NumPy."""
    rows, ever, age = np.arange(len(choices)), choices.age >= 0, np.maximum(choices.age, 0)

    def fall(values: Values) -> float:
        target, closed, failure, recent, stay, position, decay, reset = values
        trace = ever * decay**age * (1 - reset) ** choices.moves
        pulls = target * choices.target + closed * choices.closed - failure * trace
        pulls = pulls + recent * choices.last + stay * choices.stayed - position * choices.place
        pulls = pulls - pulls.max(axis=1, keepdims=True)
        return float((np.log(np.exp(pulls).sum(axis=1)) - pulls[rows, choices.chosen]).sum())

    return fall


def main() -> None:
    """Prints the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--trials", type=int, default=2100, help="trials, a multiple of 7")
    asked = parser.parse_args()
    trials = Study(agent=AGENT, seed=1, repetitions=1, trials=asked.trials // 7).play()
    heard = [hear(trial) for trial in trials]
    choices = choices_of(trials, heard)
    some = heard[::REPLAYED]
    share = len(choices) / sum(len(one.chosen) for one in some)

    def by_scipy(fall: Callable[[Values], float]) -> float:
        return -float(minimize(fall, START, method="L-BFGS-B", bounds=BOUNDS).fun)

    def by_lockprobe() -> float:
        return maximum(RIVALS["softmax-memory"].versions(choices, heard)["softmax-memory"]).log_likelihood

    ways: list[tuple[str, float, Callable[[], float]]] = [
        ("the policy replayed, SciPy", share, lambda: share * by_scipy(replayed(some))),
        ("all choices at once with NumPy, SciPy", 1.0, lambda: by_scipy(at_once(choices))),
        ("Lockprobe, four starts", 1.0, by_lockprobe),
        ("Lockprobe, all models", 1.0, lambda: fit_agents(trials).agents[0].rivals[0].log_likelihood),
    ]
    print(
        f"{len(trials)} trials, {len(choices)} choices\n\n| way | CPU s | ratio | log-likelihood |\n|---|---|---|---|"
    )
    first = 0.0
    for way, times, work in ways:
        began = time.process_time()
        found = work()
        seconds = times * (time.process_time() - began)
        first = first or seconds
        guess = ", from one trial in 20" if times > 1 else ""
        print(f"| {way}{guess} | {seconds:.2f} | {first / seconds:,.0f} | {found:.2f} |")


if __name__ == "__main__":
    main()
