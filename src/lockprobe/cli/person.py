"""A person at a terminal as an agent: sees the reports that every agent gets, and chooses joints by keys."""

from __future__ import annotations

import os
import re
import select
import sys
import termios
import tty
from collections.abc import Mapping, Sequence
from types import TracebackType
from typing import Literal, Self

import numpy as np

from lockprobe.cli.printing import Screen
from lockprobe.errors import LockprobeError
from lockprobe.lockbox.box import Lockbox
from lockprobe.lockbox.sketch import panel_lines
from lockprobe.record import Decision, Fact, Outcome, Percept, Situation, Task

__all__ = ["Ended", "Keys", "Left", "Person", "ViewKind"]

ViewKind = Literal["text", "panel"]
"""How reports are shown: in words as models read them, or drawn from what is told."""

_RULES = """\
The box has {count} joints, each in one of two positions. They lock each other in a
hidden way: whether a joint can move depends on the positions of other joints.
In every step you choose one joint. If it is not locked it moves to its other
position; if it is locked, nothing happens. The box is open as soon as the
target joint, {target}, moves. You have {budget} steps."""

_TEXT = "After every step you are told whether it moved, and which joints are at position 1."

_CLAIMS: dict[str, Outcome] = {"M": "moved", "N": "blocked"}


class Left(LockprobeError):
    """Raised when the person stops in the middle of a trial."""


class Ended(Left):
    """Raised when the input ends in the middle of a trial."""


class Person:
    """Asks at every step. The panel of ``box`` is shown, not its interlock.

    ``labels`` are in panel order.
    """

    def __init__(self, box: Lockbox, labels: Sequence[str], view: ViewKind, keys: Keys, screen: Screen) -> None:
        self._box, self._labels, self._view = box, tuple(labels), view
        self._keys, self._screen = keys, screen

    @property
    def facts(self) -> Mapping[str, Fact]:
        """How it was played."""
        return {"view": self._view, "page": "terminal"}

    async def decide(self, situation: Situation, rng: np.random.Generator) -> Decision:
        """The person's choice.

        Raises:
            Left: If the person stops; as ``Ended`` if the input ends.
        """
        task, percept, step = situation.task, situation.percept, len(situation.past) + 1
        if step == 1:
            self._rules(task)
        self._screen.say()
        self._screen.say(f"Step {step} of {task.budget}", "bold")
        self._show(task, percept)
        claimed: Outcome | None = None
        if task.assessment and percept.joint is not None:
            claimed = _CLAIMS[self._ask("What did your last action do? m it moved, n it did not move: ", "MN", task)]
        joints = " ".join(label + "*" * (label == task.target) for label in task.joints)
        return Decision(joint=self._ask(f"Which joint? {joints}: ", task.joints, task), claimed=claimed)

    def _rules(self, task: Task) -> None:
        for line in _RULES.format(count=len(task.joints), target=task.target, budget=task.budget).splitlines():
            self._screen.say(line)
        legend = panel_lines(self._box, positions=[None] * len(self._labels))[-1]
        self._screen.say(f"The panel: {legend}." if self._view == "panel" else _TEXT)
        self._screen.say("Keys: the letter of a joint; ? for help; q to stop.", "dim")

    def _show(self, task: Task, percept: Percept) -> None:
        if self._view == "text":
            self._screen.say(percept.text)
            return
        if percept.joint is not None:
            self._screen.say(
                f"{percept.joint} moved." if percept.outcome == "moved" else f"{percept.joint} did not move."
            )
        told = dict(zip(task.joints, percept.positions or [None] * len(task.joints), strict=True))
        positions = [told[label] for label in self._labels]
        for line in panel_lines(self._box, labels=self._labels, positions=positions)[:-1]:
            self._screen.say(line)

    def _ask(self, question: str, choices: Sequence[str], task: Task) -> str:
        while True:
            self._screen.say(question, end="")
            key = self._keys.next()
            self._screen.say(key.strip() if key is not None else "")
            if key is None:
                raise Ended("nothing more comes")
            if key == "Q":
                raise Left("stopped")
            if key == "?":
                self._rules(task)
            elif key in choices:
                return key
            else:
                self._screen.say(f"Not a choice here; press {', '.join(choices)}, ? for help, q to stop.", "yellow")


_END = "\x04"
"""Ctrl-D, as a terminal sends it."""

_SEQUENCE = re.compile(r"\x1b(?:\[[0-?]*[ -/]*[@-~]?|O?.?)", re.DOTALL)
"""What arrows and the like send; they choose nothing."""

_PATIENCE = 0.02
"""Seconds in which the rest of an arrow key or the like comes."""

_HEED = 0.2
"""Seconds after which Ctrl-C is heeded where it came just before the wait for a key: such a wait is not interrupted."""


class Keys:
    """Standard input as keys, while it is open. On exit the terminal gets its settings back."""

    def __init__(self) -> None:
        self._terminal = sys.stdin.fileno() if sys.stdin is not None and sys.stdin.isatty() else None
        self._before: list[object] = []
        self._pressed: list[str] = []

    def __enter__(self) -> Self:
        if self._terminal is not None:
            self._before = termios.tcgetattr(self._terminal)
            tty.setcbreak(self._terminal)  # Ctrl-C stays what it is
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._terminal is not None:
            termios.tcsetattr(self._terminal, termios.TCSADRAIN, self._before)  # type: ignore[arg-type] # what was got

    def next(self) -> str | None:
        """The next key in capitals; of a line its first character. None at the end of input and for Ctrl-D."""
        if self._terminal is not None:
            return self._press(self._terminal)
        for line in sys.stdin or ():
            if line.strip():
                return line.strip()[0].upper()
        return None

    def _press(self, terminal: int) -> str | None:
        while not self._pressed:
            while not select.select([terminal], [], [], _HEED)[0]:
                pass
            read = os.read(terminal, 1024)
            if not read:
                return None
            while _SEQUENCE.search(read.decode("utf-8", "replace")) and select.select([terminal], [], [], _PATIENCE)[0]:
                read += os.read(terminal, 1024)
            plain = _SEQUENCE.sub("", read.decode("utf-8", "replace"))
            self._pressed = [key.upper() for key in plain if not key.isspace()]
        key = self._pressed.pop(0)
        return None if key == _END else key
