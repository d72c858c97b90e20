"""What interventions change is counted in the loop: as far as the agent gets it, by whichever of them did it."""

from dataclasses import dataclass, replace

import pytest

from lockprobe.interventions.conditions import interventions_of
from lockprobe.testing import make_trial

ROUND = [0, 1, 0, 1, 2, 0] * 2
"""Attempts at chain-4 that open nothing; twelve steps, so eleven reports are read."""


@dataclass(frozen=True, kw_only=True)
class OutcomeAlone:
    """Says the opposite outcome, and leaves positions as they are."""

    def perceive(self, percept, past, task, rng):
        opposite = {"moved": "blocked", "blocked": "moved", None: None}
        return replace(percept, outcome=opposite[percept.outcome])


@dataclass(frozen=True, kw_only=True)
class Rebuilt:
    """Remembers an equal past, made anew."""

    def recall(self, turns, past, task, rng):
        return tuple(replace(turn) for turn in turns)


def played(condition, **options):
    one = interventions_of(condition) if isinstance(condition, str) else condition
    return make_trial(ROUND, condition=one, **options)


@pytest.mark.parametrize(
    "condition",
    [
        "flip?p=0", "flip?p=1&at=12", "flip?p=1&at=13", "flip?p=1&only=moved&at=1", "drop?p=0.5&at=12", "tremble?p=0",
        "history?last=50", "history?last=12", "nudge?after=9", "hypothesis?ask=before", "flip?p=1 + flip?p=1",
        [OutcomeAlone()], [Rebuilt()],
    ],
)  # fmt: skip
def test_what_changes_nothing_is_counted_as_nothing(condition):
    trial = played(condition)
    assert trial.changed
    assert trial.changed_steps == 0


@pytest.mark.parametrize(
    ("condition", "counts"),
    [
        ("flip?p=1", [10]),  # the second of two false outcomes of one joint shows it where it is
        ("flip?p=1&at=11", [1]),
        ("drop?p=1", [11]),
        ("tremble?p=1", [12]),
        ("history?last=2", [9]),
        ("warn", [12]),
        ("distract?p=1", [11]),
        ("correction?p=1", [11]),
        ("hypothesis?ask=off", [12]),
        ("flip?p=1 + drop?p=1", [0, 11]),
        ("drop?p=1 + flip?p=1", [11, 0]),
        ("drop?p=1 + drop?p=1", [11, 0]),
        ("flip?p=1 + flip?p=1", [11, 11]),
        ("history?last=50 + flip?p=1", [0, 10]),
        ("history?last=2 + history?last=1", [0, 10]),
        ("tremble?p=1 + warn + history?last=2 + flip?p=0", [12, 12, 9, 0]),
    ],
)
def test_each_is_counted_for_the_steps_that_it_changes_beside_the_others(condition, counts):
    trial = played(condition)
    assert list(trial.changed.values()) == counts
    assert len(counts) > 1 or trial.changed_steps == counts[0]


def test_an_intervention_that_comes_again_is_counted_apart():
    assert list(played("flip?p=1 + flip?p=1").changed) == ["flip?p=1", "flip?p=1 (2)"]
