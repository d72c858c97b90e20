"""A run as a table that is updated in place, with the latest step of every trial in progress."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from rich.console import Console, Group
from rich.live import Live
from rich.table import Table
from rich.text import Text

from lockprobe.agents.catalogue import AgentSource
from lockprobe.cli.progress import Progress, step_in_words
from lockprobe.foundation.terminal_text import printable
from lockprobe.studies.costs.budget import Budget
from lockprobe.studies.records.trial_rows import Timing
from lockprobe.trial.record import Step, Trial


class LiveTable(Progress):
    """Shows a table for every agent, which stays as it was last, and prints all else above it."""

    _guesses = False  # the table says it, and renews it

    def __init__(self, console: Console, *, budget: Budget | None = None, report: bool = True) -> None:
        super().__init__(budget=budget, report=report)
        self._console = console
        self._playing: dict[str, str] = {}
        self._live: Live | None = None

    @contextmanager
    def played(self) -> Iterator[None]:
        """A context in which trials are played; after it no table is updated."""
        try:
            yield
        finally:
            self._close()

    def say(self, text: str) -> None:
        """Print above the table."""
        self._console.print(Text(printable(text)))

    def agent(self, source: AgentSource, owed: int) -> None:
        """Begin a new table for an agent."""
        self._close()
        super().agent(source, owed)
        self._playing.clear()
        self._live = Live(get_renderable=self._table, console=self._console, refresh_per_second=4)
        self._live.start()

    def step(self, key: str, step: Step) -> None:
        """Remember the latest step of a trial."""
        self.tally.steps += 1
        self._playing[key] = step_in_words(step)

    def trial(self, trial: Trial, timing: Timing) -> None:
        """Count a trial."""
        super().trial(trial, timing)
        self._playing.pop(trial.key, None)

    def _say_state(self, *, now: bool = False) -> None:
        """Say nothing: the table shows it."""

    def _close(self) -> None:
        if self._live is not None:
            self._live.stop()
            self._live = None

    def _table(self) -> Group:
        table = Table(box=None, padding=(0, 2, 0, 0))
        for column in ("", "solved", "played"):
            table.add_column(column, justify="right", no_wrap=bool(column))
        for shown in sorted(self.tally.ended):
            table.add_row(shown, str(self.tally.solved[shown]), str(self.tally.ended[shown]))
        playing = [
            Text(printable(f"  {key}  {latest}"), style="dim", no_wrap=True, overflow="ellipsis")
            for key, latest in list(self._playing.items())[:8]
        ]
        head = Text(printable(self.tally.line(solved=False)), style="bold")
        return Group(head, table, *playing)
