"""What a run counts while it goes on, and plain lines about it."""

from __future__ import annotations

import time
from collections import Counter
from pathlib import Path

from lockprobe.agents.catalogue import AgentSource, resolve
from lockprobe.plants.catalogue import resolve_plant
from lockprobe.record import Step, Trial
from lockprobe.studies.journal import Journal, Timing
from lockprobe.studies.paper import ROBOT, is_short
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
        self.solved: Counter[str] = Counter()
        self.ended: Counter[str] = Counter()
        self.agent = ""
        self.slow = False
        self._began = time.monotonic()
        self.agent_owed = 0

    def turn(self, source: AgentSource, owed: int, done: list[Trial], *, slow: bool) -> None:
        """Another agent begins; its trials of an earlier run count as solved or not, but not as played.

        Args:
            source: The agent.
            owed: Trials that it is to play.
            done: Trials that it has played before.
            slow: Whether a step takes so long that one wants to see it.
        """
        self.agent, self.slow, self.agent_owed = source.spec, slow, owed
        self.played = self.steps = self.errors = 0
        self.solved.clear()
        self.ended.clear()
        self._began = time.monotonic()
        for trial in done:
            self._count(trial)

    def _count(self, trial: Trial) -> None:
        # keys with a modality in them are of studies with several
        several = trial.condition != f"{trial.study}/{trial.agent}/p={trial.p:g}"
        condition = trial.modality if several and not trial.p else f"p={trial.p:g}"
        self.ended[condition] += trial.ending != "error"
        self.solved[condition] += trial.solved

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
        shares = ", ".join(f"{shown}: {self.solved[shown]}/{self.ended[shown]}" for shown in sorted(self.ended))
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


def _conditions(study: Study) -> str:
    """How the box is shown, and how often reports are false, as far as the study varies it."""
    p = f"p = {', '.join(f'{p:g}' for p in study.p)}"
    if not study.has_pictures:
        return p
    shown = f"shown as {', '.join(study.modalities)}"
    return f"{shown}; {p}" if any(study.p) else shown


def _of_the_plant(study: Study, owed: int) -> list[str]:
    """What is acted on, what makes its pictures, and what a plant without a camera leaves out."""
    if not study.simulated:
        left_out = "Plant: symbolic, which has no camera: pictures are left out (--plant fast-twin has one)"
        return [left_out] if study.name == "modalities" else []
    said, settings = f"Plant: {study.plant}", resolve_plant(study.plant).settings
    if study.has_pictures and owed and settings is not None:
        from lockprobe.plants.rendering.renderers import chosen_renderer

        said += f"; pictures by {chosen_renderer(settings.renderer)}"
    robot = "; the paper's robot is --plant twin" if study.name == "modalities" and study.plant == ROBOT else ""
    return [said + robot]


def _of_agents(study: Study) -> list[str]:
    """Which agents look at no pictures."""
    reading = [agent for agent in study.agents if study.modalities_of(agent) != study.modalities]
    return [f"Reports only, since they look at no pictures: {', '.join(reading)}"] if reading else []


class Plain:
    """Prints lines: the first trial's steps of every slow agent, then how it goes."""

    def __init__(self) -> None:
        self.tally = Tally()
        self._journal: Journal | None = None
        self._simulated = False
        self._shown: str | None = None
        self._last = 0.0

    def say(self, text: str) -> None:
        """Print one line at once."""
        print(text, flush=True)

    def begin(self, study: Study, journal: Journal, owed: int) -> None:
        """Say what will be played, how long it should take, where it goes, and what of it is done."""
        self._journal, self._simulated = journal, study.simulated
        short = is_short(study)
        kind = {"flips": "Flip study", "modalities": "Modality study"}.get(study.name, f"Study {study.name}")
        self.say(
            f"{f'Short {kind.lower()}' if short else kind} on {study.box.name}: {_conditions(study)}; "
            f"{_count(study.repetitions, 'repetition')} of {_count(study.trials, 'trial')} of "
            f"{study.max_steps} steps; agents {', '.join(study.agents)}; seed {study.seed}"
        )
        for line in (*_of_the_plant(study, owed), *_of_agents(study)):
            self.say(line)
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
        self.tally.turn(source, owed, done, slow=self._simulated or source.engine != "inline")
        self._shown, self._last = None, time.monotonic()
        guess = ""
        if source.engine == "process":
            guess = f", about {minutes(owed)} min on two cores"
        self.say(f"{source.spec}: {owed} trial{'s' * (owed != 1)} to play{guess}")

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
