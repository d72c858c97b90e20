"""Trials of one agent that are open at the same time: how many, in which order, and what ends them."""

import asyncio
from types import SimpleNamespace

import pytest

from lockprobe.foundation.errors import BudgetReached, Missing
from lockprobe.studies.running.lanes import play_in_lanes


class Rich:
    """A log of calls whose budget covers everything; notes which trials are open."""

    def __init__(self):
        self.open = []

    def admit(self, plan):
        self.open.append(plan.key)
        return True

    def end(self, key):
        self.open.remove(key)


class Poor(Rich):
    """Its budget covers so many trials beside each other, and so many in all."""

    def __init__(self, beside, in_all):
        super().__init__()
        self.beside, self.left = beside, in_all

    def admit(self, plan):
        if len(self.open) >= min(self.beside, self.left):
            if not self.open:
                raise BudgetReached(1.0, 1.0, 0.5, of="trial")
            return False
        return super().admit(plan)

    def end(self, key):
        super().end(key)
        self.left -= 1


class Course:
    """Trials that take as many turns of the event loop as asked; notes how many are open at every moment."""

    def __init__(self, turns, calls=None):
        self.turns, self.calls = turns, calls or Rich()
        self.plans = [SimpleNamespace(key=number) for number in range(len(turns))]
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
        asyncio.run(play_in_lanes(self.plans, self.play, self.finish, self.calls, **how))


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
        run = asyncio.ensure_future(play_in_lanes(course.plans, course.play, course.finish, course.calls, lanes=2))
        await asyncio.sleep(0.01)
        run.cancel()
        with pytest.raises(asyncio.CancelledError):
            await run
        return asyncio.all_tasks() - {asyncio.current_task()}

    assert asyncio.run(ended()) == set()
    assert sorted(course.cancelled) == [0, 1]


def test_no_trial_is_opened_that_the_budget_does_not_cover_beside_the_others():
    course = Course([5, 3, 4, 6, 2, 2, 2, 2], Poor(beside=2, in_all=5))
    with pytest.raises(BudgetReached) as reached:
        course.run(lanes=4, at_the_end=8)
    assert reached.value.of == "trial"
    assert sorted(course.finished) == course.began == [0, 1, 2, 3, 4]
    assert max(opened for _, opened in course.open_while) == 2


def test_every_trial_that_was_opened_is_closed_however_it_ends():
    class Broken(Course):
        async def turn(self, plan):
            await asyncio.sleep(0)
            if plan == 1:
                raise BudgetReached(1.0, 1.0, 0.5)
            if plan == 2:
                raise Missing("gone", "mend it")

    course = Broken([9, 1, 3, 9])
    with pytest.raises(Missing):
        course.run(lanes=4)
    assert course.calls.open == []
