"""Proportions and success curves have known values, stay in range, and leave errors out."""

from dataclasses import replace

import numpy as np
import pytest
from builders import SOLUTION, make_trial

from lockprobe.boxes.families import box
from lockprobe.boxes.solve import optimum, random_curve
from lockprobe.foundation.errors import BadValue
from lockprobe.statistics.curves import relative, success_curve


def trials():
    detour = (0, 0, *SOLUTION)
    return [
        make_trial(SOLUTION, trial=1),
        make_trial(SOLUTION, trial=2),
        make_trial(detour, trial=3),
        make_trial([0] * 20, trial=4),
        make_trial([0], trial=5, broken="model"),
    ]


def test_curve_counts_by_hand():
    curve = success_curve(trials()[:4])
    assert (curve.n, curve.solved_at) == (4, (4, 4, 6))
    assert curve.steps == tuple(range(21))
    assert curve.share[3:7] == (0.0, 0.5, 0.5, 0.75)
    assert (curve.steps_to(0.5), curve.steps_to(0.75), curve.steps_to(0.8)) == (4, 6, None)
    assert (curve.median_steps, curve.mean_steps) == (4.0, pytest.approx(14 / 3))


def test_curve_of_nothing_solved():
    curve = success_curve([make_trial([0] * 20)])
    assert set(curve.share) == {0.0}
    assert curve.median_steps is None
    assert success_curve([]).n == 0


PLAYED = make_trial(SOLUTION)


def solved_at(steps, *, n, budget=20):
    """Trials solved at these steps, and others that are not, n in all."""
    waits = [make_trial([0] * (step - 4) + list(SOLUTION), budget=budget) for step in steps]
    return waits + [make_trial([0] * budget, budget=budget)] * (n - len(steps))


def test_the_median_is_over_all_trials():
    curve = success_curve(solved_at([4, 5, 9], n=6))
    assert (curve.median_steps, curve.km_median) == (5.0, 9)
    assert success_curve(solved_at([4, 5, 9], n=7)).km_median is None
    assert curve.restricted_mean_steps == pytest.approx((4 + 5 + 9 + 3 * 20) / 6)
    assert success_curve([]).restricted_mean_steps is None


def test_steps_to_a_share_lie_in_their_interval():
    curve = success_curve(solved_at(range(4, 20), n=20))
    early, late = curve.steps_to_interval(0.5)
    assert early <= curve.steps_to(0.5) <= late
    assert curve.high[early - 1] < 0.5 <= curve.high[early]
    assert curve.low[late - 1] < 0.5 <= curve.low[late]
    assert curve.steps_to_interval(0.8)[1] is None
    assert success_curve(solved_at([], n=30)).steps_to_interval(0.5) == (None, None)


def stand_ins(steps, budget, solved=None):
    """As far as curves and tests look: trials of these lengths."""
    solved = np.full(len(steps), True) if solved is None else solved
    return [
        replace(PLAYED, steps=PLAYED.steps[:1] * n, ending="solved" if s else "budget", budget=budget)
        for n, s in zip(steps, solved, strict=True)
    ]


def test_budgets_may_differ():
    curve = success_curve(solved_at([], n=2, budget=5) + solved_at([10], n=2))
    assert curve.share[9:11] == (0.0, 0.5)
    assert success_curve(solved_at([4], n=2, budget=5) + solved_at([10], n=2)).share[10] == 1 - 0.75 * 0.5


CHAIN = box("chain-4")
CHANCE = random_curve(CHAIN)


def test_chance_is_nought_and_the_shortest_plan_is_one():
    best = relative(success_curve(solved_at([4] * 30, n=30)), CHANCE, optimum(CHAIN))
    assert best.value == pytest.approx(1.0)
    assert best.low < 1 <= best.high + 1e-12
    assert best.steps == best.optimal_steps == 4
    assert best.random_steps == pytest.approx(20 - sum(CHANCE[:-1]))
    assert relative(success_curve(solved_at([], n=30)), CHANCE, optimum(CHAIN)).value < 0

    rng = np.random.default_rng(4)
    at = np.searchsorted(CHANCE, rng.random(20000), side="left")
    found = relative(success_curve(stand_ins(np.minimum(at, 20), 20, at <= 20)), CHANCE, optimum(CHAIN))
    assert abs(found.value) < 0.03
    assert found.low <= 0 <= found.high
    assert found.steps == pytest.approx(found.random_steps, abs=0.2)


def test_without_room_or_trials_nothing_is_relative():
    curve = success_curve(solved_at([4], n=2))
    assert relative(success_curve([make_trial([0], broken="model")]), CHANCE, 4) is None
    assert relative(curve, CHANCE, None) is None
    assert relative(curve, CHANCE, 21) is None
    assert relative(curve, [0.0] + [1.0] * 20, 1) is None
    with pytest.raises(BadValue, match="20 steps"):
        relative(curve, CHANCE[:-1], 4)


def test_the_band_of_people_counts_those_of_one_person_together():
    trials = [make_trial(SOLUTION if i < 15 else (0,) * 20, agent="llm:a", trial=i) for i in range(30)]
    people = [replace(trial, agent=f"participant:{trial.trial // 5:04d}") for trial in trials]
    alone, together = success_curve(trials), success_curve(people)
    assert together.share == alone.share
    assert together.low[-1] < alone.low[-1]
    assert together.high[-1] > alone.high[-1]
