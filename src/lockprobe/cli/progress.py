"""What a run shows while it goes on: a live display on a terminal, plain lines elsewhere, JSON lines for machines."""

from __future__ import annotations

import json as json_
import sys
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from rich.console import Console, Group
from rich.live import Live
from rich.table import Table
from rich.text import Text

from lockprobe.agents.catalogue import AgentSource
from lockprobe.record import Step, Trial
from lockprobe.studies.journal import Journal
from lockprobe.studies.stage import Timing
from lockprobe.studies.study import Study

__all__ = ["watch"]

_EVERY = 2.0
"""Seconds between plain lines about the state of a run."""

STEPS_PER_MINUTE = 400.0
"""What the embedded model was measured to play on two cores; only for the first guess of the time."""


class Tally:
    """The state of a run: what was played, solved and broken, and how fast."""

    def __init__(self) -> None:
        self.owed = self.played = self.errors = self.steps = 0
        self.solved: Counter[float] = Counter()
        self.ended: Counter[float] = Counter()
        self.agent = ""
        self.slow = False
        self._began = time.monotonic()
        self.agent_owed = 0

    def turn(self, source: AgentSource, owed: int, done: list[Trial]) -> None:
        """Another agent begins; its trials of an earlier run count as solved or not, but not as played."""
        self.agent, self.slow, self.agent_owed = source.spec, source.engine != "inline", owed
        self.played = self.steps = self.errors = 0
        self.solved.clear()
        self.ended.clear()
        self._began = time.monotonic()
        for trial in done:
            self._count(trial)

    def _count(self, trial: Trial) -> None:
        self.ended[trial.p] += trial.ending != "error"
        self.solved[trial.p] += trial.solved

    def trial(self, trial: Trial) -> None:
        """A trial is on disk."""
        self.played += 1
        self.errors += trial.ending == "error"
        self._count(trial)

    @property
    def speed(self) -> float:
        """Steps per second of this agent in this run."""
        return self.steps / max(time.monotonic() - self._began, 1e-9)

    @property
    def left(self) -> str:
        """Time left for this agent, in words."""
        if not self.played:
            return "…"
        seconds = (time.monotonic() - self._began) / self.played * (self.agent_owed - self.played)
        return f"{seconds / 60:.0f} min" if seconds > 90 else f"{seconds:.0f} s"

    def line(self) -> str:
        """The state in one line."""
        solved = ", ".join(f"p={p:g}: {self.solved[p]}/{self.ended[p]}" for p in sorted(self.ended))
        errors = f" · {self.errors} errors" if self.errors else ""
        return (
            f"{self.agent}  {self.played}/{self.agent_owed} trials · solved {solved or '-'} · "
            f"{self.speed:.1f} steps/s · {self.left} left{errors}"
        )


def told(step: Step) -> str:
    """One step in words, truth beside told."""
    truth = "moved" if step.moved else "did not move"
    lie = "" if step.told_moved == step.moved else f" (told: {'moved' if step.told_moved else 'did not move'})"
    return f"step {step.step:2}  {step.joint} {truth}{lie}"


class Plain:
    """Prints lines: the first trial's steps of every slow agent, then how it goes."""

    def __init__(self) -> None:
        self.tally = Tally()
        self._journal: Journal | None = None
        self._shown: str | None = None
        self._last = 0.0

    def say(self, text: str) -> None:
        """Print one line at once."""
        print(text, flush=True)

    def announce(self, study: Study, directory: Path, *, short: bool) -> None:
        """Say what will be played, how long it should take, and where it goes."""
        self.say(
            f"{'Short flip study' if short else 'Flip study'} on {study.box.name}: "
            f"p = {', '.join(f'{p:g}' for p in study.p)}; {study.repetitions} repetitions of {study.trials} trials of "
            f"{study.max_steps} steps; agents {', '.join(study.agents)}; seed {study.seed}"
        )
        if short:
            self.say("--full plays the paper's 7 p x 3 repetitions x 10 trials.")
        self.say(f"Records: {directory} (the same command resumes it)")

    def begin(self, study: Study, journal: Journal, owed: int) -> None:
        """Say how much is owed."""
        self._journal = journal
        if owed < study.size:
            self.say(f"{study.size - owed} of {study.size} trials are done already; {owed} are owed")

    def agent(self, source: AgentSource, owed: int) -> None:
        """An agent's turn comes."""
        assert self._journal is not None
        done = [trial for trial in self._journal.trials.values() if trial.agent == source.spec and not trial.owed_again]
        self.tally.turn(source, owed, done)
        self._shown = None
        guess = ""
        if source.engine == "process":
            guess = f", about {max(1, round(owed * 16 / STEPS_PER_MINUTE))} min on two cores"
        self.say(f"{source.spec}: {owed} trials to play{guess}")

    def step(self, key: str, step: Step) -> None:
        """Count a step; show it if it is of the first trial."""
        self.tally.steps += 1
        if self.tally.slow and self._shown in (None, key) and (self._shown == key or step.step == 1):
            self._shown = key
            self.say(f"  {key}  {told(step)}")

    def trial(self, trial: Trial, timing: Timing) -> None:
        """Count a trial; say how it goes."""
        self.tally.trial(trial)
        if self._shown == trial.key:
            self._shown = ""
        if trial.error is not None:
            self.say(f"  {trial.key}  error at {trial.error.boundary}: {trial.error.message}")
        now = time.monotonic()
        if now - self._last >= _EVERY or self.tally.played == self.tally.agent_owed:
            self._last = now
            self.say("  " + self.tally.line())

    def interrupted(self, directory: Path) -> None:
        """Say how to go on after Ctrl-C."""
        self.say(f"Stopped. Every finished trial is in {directory}; run the same command again to go on.")

    def reported(self, path: Path) -> None:
        """Name the report."""
        self.say(f"Report: {path}")


class JsonLines(Plain):
    """The same as JSON, one object a line, every step and every trial of slow agents."""

    def say(self, text: str) -> None:
        """Nothing: only :meth:`event` prints."""

    def event(self, kind: str, **facts: object) -> None:
        """Print one event."""
        print(json_.dumps({"event": kind, **facts}), flush=True)

    def announce(self, study: Study, directory: Path, *, short: bool) -> None:
        """The study's settings."""
        self.event("study", directory=str(directory), short=short, trials=study.size, settings=study.settings())

    def begin(self, study: Study, journal: Journal, owed: int) -> None:
        """What is owed."""
        super().begin(study, journal, owed)
        self.event("begin", owed=owed, done=study.size - owed)

    def agent(self, source: AgentSource, owed: int) -> None:
        """An agent's turn comes."""
        super().agent(source, owed)
        self.event("agent", agent=source.spec, owed=owed)

    def step(self, key: str, step: Step) -> None:
        """A step of a slow agent."""
        self.tally.steps += 1
        if self.tally.slow:
            self.event(
                "step",
                key=key,
                step=step.step,
                joint=step.joint,
                moved=step.moved,
                told_moved=step.told_moved,
            )

    def trial(self, trial: Trial, timing: Timing) -> None:
        """A trial is on disk."""
        self.tally.trial(trial)
        error = None if trial.error is None else {"boundary": trial.error.boundary, "message": trial.error.message}
        self.event(
            "trial",
            key=trial.key,
            ending=trial.ending,
            steps=len(trial.steps),
            seconds=round(timing.seconds, 3),
            error=error,
        )

    def interrupted(self, directory: Path) -> None:
        """Stopped by Ctrl-C."""
        self.event("interrupted", directory=str(directory))

    def reported(self, path: Path) -> None:
        """The report is written."""
        self.event("report", path=str(path))


class LiveDisplay(Plain):
    """A table that stays in place, with the latest step of every trial that is being played."""

    def __init__(self, console: Console) -> None:
        super().__init__()
        self._console = console
        self._playing: dict[str, str] = {}
        self._live: Live | None = None

    def say(self, text: str) -> None:
        """Print above the table."""
        self._console.print(Text(text))

    def agent(self, source: AgentSource, owed: int) -> None:
        """An agent's turn comes: a table of its own."""
        self.close()
        super().agent(source, owed)
        self._playing.clear()
        self._live = Live(get_renderable=self._table, console=self._console, refresh_per_second=4, transient=False)
        self._live.start()

    def close(self) -> None:
        """Leave the table as it stands."""
        if self._live is not None:
            self._live.stop()
            self._live = None

    def step(self, key: str, step: Step) -> None:
        """Remember the latest step of a trial."""
        self.tally.steps += 1
        self._playing[key] = told(step)

    def trial(self, trial: Trial, timing: Timing) -> None:
        """Count a trial."""
        self.tally.trial(trial)
        self._playing.pop(trial.key, None)
        if trial.error is not None:
            self.say(f"  {trial.key}  error at {trial.error.boundary}: {trial.error.message}")

    def interrupted(self, directory: Path) -> None:
        """Say how to go on after Ctrl-C."""
        self.close()
        super().interrupted(directory)

    def reported(self, path: Path) -> None:
        """Name the report."""
        self.close()
        super().reported(path)

    def _table(self) -> Group:
        table = Table(box=None, padding=(0, 2, 0, 0))
        for column in ("p", "solved", "played"):
            table.add_column(column, justify="right")
        for p in sorted(self.tally.ended):
            table.add_row(f"{p:g}", str(self.tally.solved[p]), str(self.tally.ended[p]))
        playing = [
            Text(f"  {key}  {latest}", style="dim", no_wrap=True, overflow="ellipsis")
            for key, latest in list(self._playing.items())[:8]
        ]
        head = Text(
            self.tally.line().split(" · solved")[0] + f" · {self.tally.speed:.1f} steps/s · {self.tally.left} left",
            style="bold",
        )
        return Group(head, table, *playing)


@contextmanager
def watch(*, json: bool) -> Iterator[Plain]:
    """The display that fits where the output goes."""
    if json:
        yield JsonLines()
    elif not sys.stdout.isatty():
        yield Plain()
    else:
        display = LiveDisplay(Console())
        try:
            yield display
        finally:
            display.close()
