"""Power of every test at a stated effect, and the trials that a design needs, by simulation."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.parallel import THIS_PROCESS, Pool
from lockprobe.simulation.power.rates import Progress, Rate, measure
from lockprobe.simulation.power.worlds import Design, P, World
from lockprobe.statistics.inference.over_doses import Question
from lockprobe.statistics.proportions import proportion

TRIALS = (15, 30, 60, 120, 240)
"""Trials per p at which power is measured."""

MOST_TRIALS = 10_000
"""Trials per p up to which a study is simulated."""

REPETITIONS = 3


@dataclass(frozen=True, slots=True, kw_only=True)
class Needed:
    """The sample size that one test needs for one effect: trials per p.

    Attributes:
        world: The effect.
        question: The question of the test.
        test: Name of the test.
        measured: Its power at every measured number of trials, ascending.
        trials: Trials per p at which the target is reached, interpolated; None if it is not.
        low: Lower end of its 95 % interval: the number at which the upper ends of power's Wilson intervals reach the
            target; None if the smallest number does.
        high: Upper end: the number at which the lower ends reach it; None if they do not.
        below: Whether the smallest measured number of trials reaches the target.
    """

    world: str
    question: Question
    test: str
    measured: tuple[Rate, ...]
    trials: int | None
    low: int | None
    high: int | None
    below: bool


def default_worlds() -> tuple[World, ...]:
    """The default effects: a rise and fall of success like the paper's (Fig. 4), and a trap of loops (Sec. 3.3).

    The paper's text gives 0.23 at p = 0 and 2.85 times that at 0.4; the other values are assumptions.
    """
    return (
        World(
            name="loops-irrelevant",
            says="Success rises and falls, so that trials differ in length; actions are random and loops irrelevant.",
            success=(0.23, 0.4, 0.53, 0.63, 0.67, 0.6, 0.5),
            truths=frozenset({"success", "speed", "shape"}),
        ),
        World(
            name="loop-trapped",
            says="Told the truth the agent falls into cycles; false reports free it.",
            success=(0.85,) * 7,
            trap=(0.5, 0.25, 0.12, 0.06, 0.03, 0.03, 0.03),
            truths=frozenset({"looping"}),
        ),
    )


def stated_world(success: Sequence[float], *, p: Sequence[float] = P, trap: Sequence[float] = ()) -> World:
    """The simulated agent with the effect that a user states.

    Args:
        success: Probability of solving the box at each p, [0, 1).
        p: Flip probabilities, ascending, 0.000001 or more apart.
        trap: Probability per step of falling into a cycle at each p, [0, 1]; 0 by default.
    """
    if len(success) != len(p):
        raise BadValue(
            "success", ",".join(f"{value:g}" for value in success), f"one share for each of {len(p)} flip rates"
        )
    if trap and len(trap) != len(p):
        raise BadValue("trap", ",".join(f"{value:g}" for value in trap), f"one chance for each of {len(p)} flip rates")
    _check_p(p)
    for name, values, limit in (("success", success, "below 1"), ("trap", trap, "to 1")):
        for value in values:
            if not 0 <= value <= 1 or (name == "success" and value == 1):
                raise BadValue(name, value, f"a number from 0 {limit}")
    chances = tuple(trap) or (0.0,) * len(p)
    return World(
        name="stated",
        says="As stated.",
        success=tuple(success),
        trap=chances,
        truths=_truths(success, chances),
    )


def _check_p(p: Sequence[float]) -> None:
    """Refuse flip probabilities that make no design, such as nearly equal ones, which allow no trend."""
    if list(p) != sorted(set(p)) or len(p) < 2 or not all(0 <= value <= 1 for value in p):
        raise BadValue("p", ",".join(f"{value:g}" for value in p), "two values or more from 0 to 1, ascending")
    if any(round(high - low, 9) < 1e-6 for low, high in pairwise(p)):
        raise BadValue("p", ",".join(map(str, p)), "values that differ by 0.000001 or more")


def _truths(success: Sequence[float], trap: Sequence[float]) -> frozenset[Question]:
    """The questions whose true answer is yes."""
    found: set[Question] = set()
    if len(set(success)) > 1:
        found |= {"success", "speed"}
    top = success.index(max(success))
    if success[top] > success[0] and success[top] > success[-1]:
        found.add("shape")
    if len(set(trap)) > 1:
        found.add("looping")
    if min(trap) < min(trap[0], trap[-1]):
        found.add("looping again")
    return frozenset(found)


def power(
    worlds: Sequence[World],
    *,
    p: Sequence[float] = P,
    trials: Sequence[int] = TRIALS,
    target: float = 0.8,
    studies: int = 100,
    seed: int = 1,
    workers: Pool = THIS_PROCESS,
    progress: Progress = lambda done, of: None,
) -> list[Needed]:
    """The power of every test whose true answer is yes, and the trials per p that it needs.

    Simulated trials share no luck over p, like those of a sampled model. With shared luck, differences of success need
    fewer trials, and tests of speed and loops need other numbers.

    Args:
        worlds: Effects; each gives success at every ``p``.
        p: Flip probabilities.
        trials: Trials per p to measure at, 2 to ``MOST_TRIALS``; rounded up to three whole repetitions.
        target: Power to be reached, (0, 1).
        studies: Studies per world and number of trials.
        seed: Seed of everything.
        workers: The pool of processes that simulates the studies.
        progress: Called with the number of studies done.
    """
    if not 0 < target < 1:
        raise BadValue("target power", target, "a number between 0 and 1")
    if not trials or min(trials) < 2 or max(trials) > MOST_TRIALS:
        raise BadValue("trials per flip rate", list(trials), f"numbers of at least 2 and at most {MOST_TRIALS}")
    _check_p(p)
    designs = [
        Design(p=tuple(p), repetitions=REPETITIONS, trials=each)
        for each in sorted({math.ceil(count / REPETITIONS) for count in trials})
    ]
    rates = measure(worlds, designs, studies=studies, seed=seed, workers=workers, progress=progress)
    found: dict[tuple[str, str], list[Rate]] = {}
    for rate in rates:
        if rate.truth:
            found.setdefault((rate.world, rate.test), []).append(rate)
    return [needed(measured, target) for measured in found.values()]


def needed(measured: Sequence[Rate], target: float) -> Needed:
    """The number of trials at which a test's power first reaches the target, interpolated in its logarithm."""
    first = measured[0]
    trials = [rate.trials for rate in measured]
    shares = [proportion(rate.rejected, rate.studies) for rate in measured]
    low = _crossing(trials, [share.high for share in shares], target)
    return Needed(
        world=first.world,
        question=first.question,
        test=first.test,
        measured=tuple(measured),
        trials=_crossing(trials, [share.value for share in shares], target),
        low=None if low == first.trials else low,
        high=_crossing(trials, [share.low for share in shares], target),
        below=first.rate >= target,
    )


def _crossing(trials: Sequence[int], power_at: Sequence[float], target: float) -> int | None:
    """The first number of trials at which interpolated power reaches the target; None if none does."""
    if power_at[0] >= target:
        return trials[0]
    for (n, low), (more, high) in pairwise(zip(trials, power_at, strict=True)):
        if high >= target:
            way = (target - low) / (high - low)
            return math.ceil(math.exp(math.log(n) + way * math.log(more / n)) - 1e-9)
    return None
