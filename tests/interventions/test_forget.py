"""What is forgotten stays forgotten, at every larger dose too."""

import itertools

from lockprobe.foundation.seeds import trial_stream
from lockprobe.interventions.forget import Forget
from lockprobe.trial.record import Decision, Percept, Turn

TURNS = tuple(Turn(percept=Percept(text=str(i)), decision=Decision(joint="A")) for i in range(19))


def left(p, steps=19):
    rng = trial_stream(1, 1, 1, "Forget-0")
    for done in range(steps):
        Forget(p=p).recall(TURNS[:done], None, rng)
    return {turn.percept.text for turn in Forget(p=p).recall(TURNS[:steps], None, rng)}


def test_doses_are_nested():
    found = [left(p) for p in (0.0, 0.3, 0.6, 1.0)]
    assert all(more >= fewer for more, fewer in itertools.pairwise(found))
    assert (len(found[0]), len(found[-1])) == (19, 0)


def test_what_is_gone_stays_gone():
    assert all(left(0.5, steps) == {text for text in left(0.5) if int(text) < steps} for steps in range(20))
