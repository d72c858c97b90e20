"""Who needs no more than the newest exchanges does not miss the others."""

import pytest

from lockprobe.agents.policy import Policy, Told
from lockprobe.interventions.history import History
from lockprobe.studies.running.single import run_trial
from lockprobe.trial.record import Decision, Percept, Turn

TURNS = tuple(Turn(percept=Percept(text=str(i)), decision=Decision(joint="A")) for i in range(5))


@pytest.mark.parametrize(("last", "left"), [(0, ()), (2, TURNS[3:]), (5, TURNS), (9, TURNS)])
def test_the_newest_are_left(last, left):
    assert History(last=last).recall(TURNS, None, None) == left


class Windowed(Policy[tuple[Told, ...]]):
    """Does what its last two reports say, and nothing else."""

    def begin(self, view):
        return ()

    def remember(self, view, memory, told):
        return (*memory, told)[-2:]

    def probabilities(self, view, memory):
        said = sum((3 * told.joint + 5 * told.moved + 7 * (told.shifted or 0)) for told in memory)
        weights = [1 + (said * (j + 2)) % 5 for j in range(view.joints)]
        return tuple(weight / sum(weights) for weight in weights)


@pytest.mark.parametrize(("agent", "last"), [("random-no-repeat", 1), ("random", 0), (Windowed(), 2), (Windowed(), 3)])
@pytest.mark.parametrize("seed", [1, 2, 3, 4, 5])
def test_a_policy_of_a_shorter_memory_plays_byte_for_byte_as_before(agent, last, seed):
    plain, short = (run_trial(agent=agent, p=0.2, seed=seed, condition=c) for c in ("", f"history?last={last}"))
    assert plain.steps == short.steps


def test_a_policy_of_a_longer_memory_plays_otherwise():
    plain, short = (run_trial(agent="human-inspired", seed=2, condition=c) for c in ("", "history?last=1"))
    assert plain.actions != short.actions
