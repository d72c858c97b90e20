"""What a run counts while it goes on, and plain lines about it."""

from __future__ import annotations

import time
from collections import Counter
from pathlib import Path

from lockprobe.agents.catalogue import AgentSource, resolve
from lockprobe.record import Step, Trial
from lockprobe.studies.journal import Journal, Timing
from lockprobe.studies.paper import is_short
from lockprobe.studies.study import Study

__all__ = ["Plain", "Tally", "minutes", "told"]

_EVERY = 2.0
"""Seconds between plain lines about the state of a run."""

STEPS_PER_TRIAL = 17.0
STEPS_PER_MINUTE = 300.0
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

    def line(self, *, solved: bool = True) -> str:
        """The state in one line, with or without what is solved under which condition."""
        shares = ", ".join(f"p={p:g}: {self.solved[p]}/{self.ended[p]}" for p in sorted(self.ended))
        errors = f" · {self.errors} errors" if self.errors else ""
        return (
            f"{self.agent}  {self.played}/{self.agent_owed} trials · {f'solved {shares or None} · ' if solved else ''}"
            f"{self.speed:.1f} steps/s · {self.left} left{errors}"
        )


def _count(number: int, noun: str) -> str:
    return f"{number} {noun}{'' if number == 1 else 's'}"


def minutes(trials: int) -> int:
    """A first guess of how long the embedded model needs for so many trials, in whole minutes."""
    return max(1, round(trials * STEPS_PER_TRIAL / STEPS_PER_MINUTE))


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

    def begin(self, study: Study, journal: Journal, owed: int) -> None:
        """Say what will be played, how long it should take, where it goes, and what of it is done."""
        self._journal = journal
        short = is_short(study)
        self.say(
            f"{'Short flip study' if short else 'Flip study'} on {study.box.name}: "
            f"p = {', '.join(f'{p:g}' for p in study.p)}; {_count(study.repetitions, 'repetition')} of "
            f"{_count(study.trials, 'trial')} of "
            f"{study.max_steps} steps; agents {', '.join(study.agents)}; seed {study.seed}"
        )
        if short:
            engines = [resolve(spec).engine for spec in study.agents]
            trials = engines.count("process") * study.size // len(study.agents)
            time_needed = f"about {minutes(trials)} minutes on two cores" if trials else "some seconds"
            if "network" in engines:
                time_needed += " and what the provider needs"
            self.say(f"It takes {time_needed}; --full plays the paper's 7 p x 3 repetitions x 10 trials.")
        self.say(f"Records: {journal.directory} (the same command resumes it)")
        if owed < study.size:
            self.say(f"{study.size - owed} of {study.size} trials are done already; {owed} are owed")

    def agent(self, source: AgentSource, owed: int) -> None:
        """An agent's turn comes."""
        assert self._journal is not None
        done = [trial for trial in self._journal.trials.values() if trial.agent == source.spec and not trial.owed_again]
        self.tally.turn(source, owed, done)
        self._shown, self._last = None, time.monotonic()
        guess = ""
        if source.engine == "process":
            guess = f", about {minutes(owed)} min on two cores"
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
