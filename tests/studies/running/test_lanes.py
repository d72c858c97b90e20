"""Trials of one agent that are open at the same time: how many, in which order, and what ends them."""

import asyncio
from collections import deque
from types import SimpleNamespace

import pytest

from lockprobe.foundation.errors import BudgetReached, Missing
from lockprobe.studies.running.lanes import play_in_lanes


class Course:
    """Trials that take as many turns of the event loop as asked; notes how many are open at every moment."""

    def __init__(self, turns):
        self.turns = turns
        self.plans = deque(SimpleNamespace(key=number) for number in range(len(turns)))
        self.open, self.most, self.began, self.finished, self.cancelled = 0, 0, [], [], []
        self.open_while = []

    async def play(self, plan):
        plan = plan.key
        self.open += 1
        self.began.append(plan)
        try:
            for _ in range(self.turns[plan]):
                self.open_while.append((len(self.turns) - len(self.began), self.open))
                await self.turn(plan)
        except asyncio.CancelledError:
            self.cancelled.append(plan)
            raise
        finally:
            self.open -= 1
        return SimpleNamespace(key=plan), None

    async def turn(self, plan):
        await asyncio.sleep(0)

    def finish(self, trial, timing):
        self.finished.append(trial.key)

    def run(self, **how):
        asyncio.run(play_in_lanes(self.plans, self.play, self.finish, **how))


def test_so_many_are_open_and_every_one_is_played_once():
    course = Course([4, 1, 7, 2, 2, 9, 1, 3, 3, 5])
    course.run(lanes=3)
    assert sorted(course.finished) == list(range(10))
    assert course.began == list(range(10))
    assert max(opened for _, opened in course.open_while) == 3


def test_the_last_ones_are_all_opened_at_once_and_not_before():
    course = Course([5] * 20)
    course.run(lanes=3, at_the_end=6)
    assert sorted(course.finished) == list(range(20))
    before = [opened for waiting, opened in course.open_while if waiting > 6]
    assert max(before) == 3
    assert max(opened for _, opened in course.open_while) == 6 + 2  # one of three has just ended


def test_when_money_ends_no_trial_is_opened_and_those_that_can_go_on_do():
    class Costly(Course):
        async def turn(self, plan):
            await asyncio.sleep(0)
            if plan == 1:
                raise BudgetReached(1.0, 1.0, 0.5)

    course = Costly([6, 3, 6, 1, 1, 1])
    with pytest.raises(BudgetReached):
        course.run(lanes=3)
    assert sorted(course.finished) == [0, 2]
    assert course.began == [0, 1, 2]
    assert course.cancelled == []


def test_what_ends_one_otherwise_ends_all_and_is_raised_once():
    class Broken(Course):
        def finish(self, trial, timing):
            super().finish(trial, timing)
            if trial.key == 1:
                raise Missing("all broke", "mend it")

    course = Broken([50, 2, 50, 1, 1])
    with pytest.raises(Missing, match="all broke: mend it"):
        course.run(lanes=3)
    assert course.finished == [1]
    assert sorted(course.cancelled) == [0, 2]


def test_where_a_run_is_ended_from_outside_nothing_is_left_running():
    course = Course([10**6] * 4)

    async def ended():
        run = asyncio.ensure_future(play_in_lanes(course.plans, course.play, course.finish, lanes=2))
        await asyncio.sleep(0.01)
        run.cancel()
        with pytest.raises(asyncio.CancelledError):
            await run
        return asyncio.all_tasks() - {asyncio.current_task()}

    assert asyncio.run(ended()) == set()
    assert sorted(course.cancelled) == [0, 1]


def test_once_it_is_to_leave_no_trial_is_opened_and_the_others_stay():
    course = Course([1] * 5)
    course.run(leave=lambda: len(course.finished) >= 3)
    assert course.finished == [0, 1, 2]
    assert [plan.key for plan in course.plans] == [3, 4]
