"""The plant ``manual``: a person moves the joint that the agent names, and says what happened.

The truth is the person's answer; with ``manual?camera=FOLDER`` of lockprobe-robot it is read from pictures. The person
sees the agent's label and the name of the joint in the box. The plant needs a terminal, so its trials are played in
this process, one at a time. The operator answers one question at a time, at the terminal or scripted in tests.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping, Sequence
from typing import Protocol

from lockprobe.boxes.box import Configuration, Lockbox
from lockprobe.foundation.child_processes import interruptible
from lockprobe.foundation.errors import PlantFault, UserMistake
from lockprobe.foundation.terminal_text import printable
from lockprobe.trial.pictures.frame import Frame
from lockprobe.trial.record import Fact, Snapshot

ENTER = ""
"""The answer of a person who only presses Enter."""


class OperatorStopped(PlantFault):
    """Raised when the operator types ``q``, the input ends, or nobody is there. It ends a trial as ``error: plant``."""


class Operator(Protocol):
    """A person who works at the box."""

    def ask(self, question: str, answers: Sequence[str]) -> str:
        """Ask in one line until one of the answers is given, in lower case; with :data:`ENTER` it may be empty.

        ``OperatorStopped`` if the person stops, or nobody is there.
        """
        ...

    def tell(self, line: str) -> None:
        """Show a line that needs no answer."""
        ...


def ask_to_begin(operator: Operator, question: str = "Press Enter when they stand so, q to stop.") -> None:
    """Ask whether the box is set up for a trial."""
    try:
        operator.ask(question, (ENTER,))
    except OperatorStopped as stopped:
        raise UserMistake(f"{stopped}; no trial had begun, so nothing is lost: the same command goes on") from None


class TerminalOperator:
    """Asks on standard error and reads lines from standard input, so that standard output stays for results."""

    def ask(self, question: str, answers: Sequence[str]) -> str:
        """The answer that is typed. Ctrl-C ends the run at once."""
        while True:
            sys.stderr.write(f"{printable(question)} ")
            sys.stderr.flush()
            with interruptible():
                line = sys.stdin.readline()
            if not line:
                sys.stderr.write("\n")
                raise OperatorStopped("the input ended before the operator answered")
            typed = line.strip().lower()
            if typed in ("q", "quit"):
                raise OperatorStopped("the operator stopped")
            if (answer := {"yes": "y", "no": "n"}.get(typed, typed)) in answers:
                return answer
            known = ", ".join("Enter" if answer == ENTER else answer for answer in answers)
            self.tell(f"Not an answer here: type {known}, or q to stop.")

    def tell(self, line: str) -> None:
        """Print one line."""
        sys.stderr.write(f"{printable(line)}\n")


class Manual:
    """A box in front of a person, whose rules only detect typing errors: they decide no outcome.

    The trial begins when the person says that the box stands in its initial configuration. Labels are in panel order.
    """

    def __init__(self, box: Lockbox, *, labels: tuple[str, ...], operator: Operator) -> None:
        self._box, self._operator = box, operator
        self._called = tuple(f"{label} ({name})" for label, name in zip(labels, box.names, strict=True))
        self._configuration: Configuration | None = None
        self._look: Callable[[], Frame] | None = None

    @property
    def facts(self) -> Mapping[str, Fact]:
        """The source of the truth."""
        return {"truth": "person"}

    def observe(self) -> Snapshot:
        """The truth now; before the first attempt the person is asked to set the box up."""
        if self._configuration is None:
            stand = ", ".join(f"{one} at {at:d}" for one, at in zip(self._called, self._box.initial, strict=True))
            self._operator.tell(f"New trial of {self._box.name}. Set the joints: {stand}.")
            self._begin()
            self._configuration = self._box.initial
        return Snapshot(configuration=self._configuration, look=self._look)

    def attempt(self, joint: int) -> Snapshot:
        """Let the person attempt a joint, by index in panel order."""
        before = self._configuration
        assert before is not None
        ask = f"Move joint {self._called[joint]} from {before[joint]:d} to {not before[joint]:d}"
        after = self._configuration = self._after(joint, before, ask)
        return Snapshot(
            configuration=after,
            joint=joint,
            outcome="moved" if after[joint] != before[joint] else "blocked",
            sensed={"truth": self.facts["truth"], "as_rules": after == self._box.attempt(before, joint)[0]},
            look=self._look,
        )

    def close(self) -> None:
        """Do nothing: there are no resources to release."""

    def _begin(self) -> None:
        """Wait until the box stands as it was asked."""
        ask_to_begin(self._operator)

    def _after(self, joint: int, before: Configuration, ask: str) -> Configuration:
        """The configuration after the person was asked to move a joint."""
        called, yes_or_no = self._called[joint], ("y", "n")
        moved = self._operator.ask(f"{ask}. Did it move? y/n, q to stop:", yes_or_no) == "y"
        if moved != (free := self._box.may_move(before, joint)):  # perhaps a typing error
            rule = f"By the rules of {self._box.name} {called} is {'free' if free else 'locked'}."
            moved = self._operator.ask(f"{rule} Did it really move? y/n, q to stop:", yes_or_no) == "y"
        return tuple(at != (moved and i == joint) for i, at in enumerate(before))
