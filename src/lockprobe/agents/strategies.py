"""Agents that follow a rule. They read what is told, never the truth."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from lockprobe.record import Decision, Fact, Situation

__all__ = ["HumanInspired", "RandomAgent", "RandomNoRepeat", "RoundRobin"]


def _pick(choices: list[str], rng: np.random.Generator) -> str:
    return choices[int(rng.random() * len(choices))]


class _Rule:
    facts: Mapping[str, Fact] = {}
    looks = False

    async def decide(self, situation: Situation, rng: np.random.Generator) -> Decision:
        """Choose by the rule. A rule that looks at nothing says nothing of its last action."""
        return Decision(joint=self.choose(situation, rng), claimed=situation.percept.outcome if self.looks else None)

    def choose(self, situation: Situation, rng: np.random.Generator) -> str:
        """The next joint."""
        raise NotImplementedError


class RandomAgent(_Rule):
    """Every joint with equal probability at every step. Its success is the box's chance level."""

    def choose(self, situation: Situation, rng: np.random.Generator) -> str:
        """Any joint."""
        return _pick(list(situation.task.joints), rng)


class RandomNoRepeat(_Rule):
    """Every joint but the one attempted last, with equal probability."""

    def choose(self, situation: Situation, rng: np.random.Generator) -> str:
        """Any joint but the last."""
        return _pick([joint for joint in situation.task.joints if joint != situation.percept.joint], rng)


class RoundRobin(_Rule):
    """The joints in the order in which they are listed, again and again, whatever happens."""

    def choose(self, situation: Situation, rng: np.random.Generator) -> str:
        """The next in the list."""
        return situation.task.joints[len(situation.past) % len(situation.task.joints)]


class HumanInspired(_Rule):
    """After every perceived change try the target; never retry a joint that failed until something has moved.

    The paper uses a strategy derived from human behaviour (Sec. 3.1) whose algorithm is not public. This is a
    *reconstruction*, preset ``target-first``: on ``chain-4`` it gives the paper's reference curve, 80 % by step 9
    and 100 % by step 20.

    1. Unless it has failed since the last perceived move, attempt the target.
    2. Else a joint, at random, that has neither failed since then nor been opened before.
    3. Else an opened one that has not failed since then.
    4. Else, since the reports contradict each other, any joint.
    """

    looks = True

    def choose(self, situation: Situation, rng: np.random.Generator) -> str:
        """The next joint by the rules above."""
        task = situation.task
        failed, opened = self._memory(situation)
        if task.target not in failed:
            return task.target
        untried = [joint for joint in task.joints if joint not in failed]
        fresh = [joint for joint in untried if joint not in opened]
        return _pick(fresh or untried or list(task.joints), rng)

    @staticmethod
    def _memory(situation: Situation) -> tuple[set[str], set[str]]:
        """Joints that failed since the last perceived move, and joints believed open."""
        failed: set[str] = set()
        opened: set[str] = set()
        for percept in (*(turn.percept for turn in situation.past), situation.percept):
            if percept.joint is None:
                continue
            if percept.outcome == "moved":
                failed.clear()
                opened ^= {percept.joint}
            else:
                failed.add(percept.joint)
        start = (situation.past[0].percept if situation.past else situation.percept).positions
        now = situation.percept.positions
        if start is not None and now is not None:
            opened = {j for j, s, n in zip(situation.task.joints, start, now, strict=True) if s != n}
        return failed, opened
