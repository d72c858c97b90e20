"""The contract of plants holds for ours and finds who breaks it."""

from dataclasses import replace

import pytest

from lockprobe.plants.symbolic import SymbolicPlant
from lockprobe.testing import check_plant


def test_plants_that_keep_it():
    check_plant("symbolic")
    check_plant("fast-twin", boxes=["chain-4"], attempts=10)


class Plain(SymbolicPlant):
    def __init__(self, *, box, labels, rng):
        super().__init__(box)
        self.box, self.rng, self.labels = box, rng, labels


class Sticks(Plain):
    """A joint that is free sometimes does not move."""

    def attempt(self, joint):
        return (
            super().attempt(joint)
            if self.rng.random() < 0.8
            else replace(self.observe(), joint=joint, outcome="blocked")
        )


class Lies(Plain):
    def attempt(self, joint):
        return replace(super().attempt(joint), outcome="moved")


class Shared(Plain):
    """All of its boxes are one."""

    now = None

    def observe(self):
        if Shared.now is None:
            Shared.now = self.box.initial
        return replace(super().observe(), configuration=Shared.now)

    def attempt(self, joint):
        done = super().attempt(joint)
        Shared.now = done.configuration
        return done


class Elsewhere(Plain):
    def attempt(self, joint):
        return replace(super().attempt(joint), joint=0)


class Open(Plain):
    def observe(self):
        return replace(super().observe(), configuration=(True,) * 4)


class Reports(Plain):
    def observe(self):
        return replace(super().observe(), joint=1, outcome="moved")


class Senses(Plain):
    def attempt(self, joint):
        return replace(super().attempt(joint), sensed={"force": [1.0, 2.0]})


@pytest.mark.parametrize(
    ("plant", "said"),
    [
        (Sticks, "does not obey the interlock on chain-4, where the interlock lets joint"),
        (Lies, "wrong outcome on chain-4, where the interlock does not let joint"),
        (Shared, "does not start as chain-4 does"),
        (Elsewhere, "reports another joint"),
        (Open, "does not start as chain-4 does"),
        (Reports, "reports an attempt before the first"),
        (Senses, "what it senses, is no text"),
        (lambda **given: object(), "has no `facts`"),
    ],
)
def test_plants_that_break_it(plant, said):
    with pytest.raises(AssertionError, match=said):
        check_plant(plant, boxes=["chain-4"])
