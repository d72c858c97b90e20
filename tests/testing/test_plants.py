"""The contract of plants holds for ours and finds who breaks it."""

from dataclasses import replace

import pytest

from lockprobe.plants.symbolic import SymbolicPlant
from lockprobe.testing import check_plant


def test_plants_that_keep_it():
    check_plant("symbolic")
    check_plant("fast-twin", boxes=["chain-4"], attempts=10)


def test_a_pass_says_what_was_tried(capsys):
    made, asked = [], []

    class Counted(SymbolicPlant):
        def __init__(self, *, box, labels, rng):
            super().__init__(box)
            made.append(self)

        def attempt(self, joint):
            before = self.observe().configuration
            done = super().attempt(joint)
            asked.append((before, joint, done.outcome))
            return done

    (tried,) = check_plant(Counted, boxes=["chain-3"], attempts=25)
    moved = sum(outcome == "moved" for _, _, outcome in asked)
    configurations = len({before for before, _, _ in asked})
    assert (tried.resets, tried.attempts, tried.moved) == (len(made), len(asked), moved) == (2, 25, moved)
    assert capsys.readouterr().out == (
        f"Counted on chain-3: 25 attempts at 3 joints in {configurations} configurations as the interlock says "
        f"({moved} moved, {25 - moved} blocked), 2 resets\n"
    )
    assert 1 < configurations <= 8
    assert [one.box for one in check_plant("symbolic")] == ["chain-4", "bichain-4", "gray-code"]
    assert "symbolic on gray-code: 40 attempts" in capsys.readouterr().out


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
