"""The operator, a person next to the box: answers one question at a time, at the terminal or scripted in tests."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from typing import Protocol

from lockprobe.foundation.child_processes import interruptible
from lockprobe.foundation.errors import PlantFault, UserMistake
from lockprobe.foundation.terminal_text import printable

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


class ConsentingOperator:
    """An automatic operator that agrees to everything, only for rehearsals in which nothing real moves."""

    def __init__(self) -> None:
        self._began = False

    def ask(self, question: str, answers: Sequence[str]) -> str:
        """Yes, or Enter once."""
        if ENTER not in answers:
            return "y"
        if self._began:
            raise OperatorStopped("the box does not stand as it should, and nobody is there to set it up")
        self._began = True
        return ENTER

    def tell(self, line: str) -> None:
        """Discard the line."""


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
