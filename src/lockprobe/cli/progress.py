"""A run in plain lines."""

from __future__ import annotations

import time
from collections.abc import Sequence
from pathlib import Path

from lockprobe.agents.catalogue import AgentSource, resolve
from lockprobe.call import Call
from lockprobe.cli.format_cost import estimate_lines, money, spent_in_words
from lockprobe.cli.run_state import Tally, count, invalid_in_words
from lockprobe.errors import BudgetReached
from lockprobe.plants.catalogue import resolve_plant
from lockprobe.record import Step, Trial
from lockprobe.spec import PEOPLE
from lockprobe.studies.call_log import read_calls
from lockprobe.studies.estimate import Estimate, estimates
from lockprobe.studies.journal import Journal, Timing
from lockprobe.studies.paper import ROBOT, is_short
from lockprobe.studies.spending import Budget, Ledger, hosted
from lockprobe.studies.study import Study
from lockprobe.studies.valid import Invalid
from lockprobe.terminal_text import printable

__all__ = ["Plain", "minutes", "told"]

_EVERY = 2.0
"""Seconds between plain lines about the state of a run."""

_QUIET = 30.0
"""Seconds after which one is due although no trial has ended."""

STEPS_PER_TRIAL = 17.0
STEPS_PER_MINUTE = 300.0
"""What the embedded model was measured to play on two cores; only for the first guess of the time."""


_KINDS = {"flips": "Flip study", "modalities": "Modality study"}
"""What the paper's studies are called."""


def minutes(trials: int) -> int:
    """A first guess of how long the embedded model needs for so many trials, in whole minutes."""
    return max(1, round(trials * STEPS_PER_TRIAL / STEPS_PER_MINUTE))


def told(step: Step) -> str:
    """One step in words, truth beside told."""
    truth = "moved" if step.moved else "did not move"
    lie = "" if not step.told_falsely else f" (told: {'moved' if step.told_moved else 'did not move'})"
    return f"step {step.step:2}  {step.joint} {truth}{lie}"


def _conditions(study: Study) -> str:
    """How the box is shown, and how often reports are false, as far as the study varies it."""
    if not study.of_flips:
        return f"{count(len(study.conditions), 'condition')}: {'; '.join(one.label for one in study.conditions)}"
    p = f"flip rate {', '.join(f'{p:g}' for p in study.p)}"
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
        from lockprobe.plants.rendering.choose_renderer import chosen_renderer

        said += f"; pictures by {chosen_renderer(settings.renderer)}"
    robot = "; the paper's robot is --plant twin" if study.name == "modalities" and study.plant == ROBOT else ""
    return [said + robot]


def _of_agents(study: Study) -> list[str]:
    """Which agents look at no pictures."""
    reading = [agent for agent in study.agents if study.modalities_of(agent) != study.modalities]
    return [f"Reports only, since they look at no pictures: {', '.join(reading)}"] if reading else []


def _of_people(study: Study, journal: Journal) -> str:
    """That people are invited, not run, and how many of their trials were played."""
    played = sum(trial.group == PEOPLE and not trial.owed_again for trial in journal.trials.values())
    return (
        f"People: {played} of {count(study.invited, 'trial')} played; they are not run but invited, by "
        f"lockprobe serve {journal.directory}"
    )


def _when(study: Study, owed: int) -> str:
    """When there is a report to read."""
    slow = study.simulated or any(resolve(spec).engine in {"process", "network"} for spec in study.agents)
    return "(within a minute, and renewed while the run goes on)" if slow and owed else "(at the end)"


class Plain:
    """Prints lines: the first trial's steps of every slow agent, then how it goes."""

    def __init__(self, *, batch: bool = False, budget: Budget | None = None, report: bool = True) -> None:
        self.tally = Tally()
        self._batch, self._budget, self._report = batch, budget, report
        self._journal: Journal | None = None
        self._simulated = False
        self._shown: str | None = None
        self._last = 0.0

    def say(self, text: str) -> None:
        """Print one line at once."""
        print(printable(text), flush=True)

    def begin(self, study: Study, journal: Journal, owed: int) -> None:
        """Say what will be played, how long it should take, where it goes, and what of it is done."""
        self._journal, self._simulated, self.tally = journal, study.simulated, Tally(study)
        run = study.size - study.invited
        if not run:
            self.say(_of_people(study, journal))
            return
        short = is_short(study)
        kind = _KINDS.get(study.name, f"Study {study.name}") if study.of_flips else f"Study {study.name}"
        self.say(
            f"{f'Short {kind.lower()}' if short else kind} on {study.box.name}: {_conditions(study)}; "
            f"{count(study.repetitions, 'repetition')} of {count(study.trials, 'trial')} of "
            f"{study.max_steps} steps; agents {', '.join(study.agents)}; seed {study.seed}"
        )
        invited = [_of_people(study, journal)] if study.invited else []
        for line in (*_of_the_plant(study, owed), *_of_agents(study), *invited):
            self.say(line)
        if short:
            engines = [resolve(spec).engine for spec in study.agents]
            trials = engines.count("process") * study.size // len(study.agents)
            time_needed = f"about {minutes(trials)} minutes on two cores" if trials else "some seconds"
            if "network" in engines:
                time_needed += " and what the provider needs"
            self.say(f"It takes {time_needed}; --full plays the paper's 7 flip rates x 3 repetitions x 10 trials.")
        self.say(f"Records: {journal.directory} (the same command resumes it)")
        if self._report:
            self.say(f"Report: {journal.directory / 'report.html'} {_when(study, owed)}")
        if owed < run:
            self.say(f"{run - owed} of {run} trials are done already; {owed} are owed")
        self._costs(study, journal)

    def _costs(self, study: Study, journal: Journal) -> None:
        """What it has cost, and what it should still cost, if somebody charges for it."""
        if not hosted(study):
            return
        self.tally.ledger, self.tally.calls = Ledger(study, read_calls(journal.directory)), journal.calls
        journal.calls.listen(self.call)
        self.estimated(estimates(study, journal.trials, read_calls(journal.directory), batch=self._batch))

    def estimated(self, found: Sequence[Estimate]) -> None:
        """Say what will be spent, before anything is."""
        for line in (line for one in found for line in estimate_lines(one)):
            self.say(line)
        if self._budget is None:
            return
        before = f", of which {money(self._budget.spent)} is spent" if self._budget.spent else ""
        left = self._budget.allowed - self._budget.spent
        lasts = left >= sum(one.dollars(one.full, cached=False) or 0.0 for one in found)
        self.say(
            f"Budget: {money(self._budget.allowed)}{before}"
            f"{'' if lasts else '; it may not last: the study then stops, and goes on with a larger one'}"
        )

    def call(self, call: Call) -> None:
        """A call is on disk; if nothing has been said for long, say how it goes."""
        assert self.tally.ledger is not None
        self.tally.ledger.add(call)
        if time.monotonic() - self._last >= _QUIET:
            self._last = time.monotonic()
            self.say("  " + self.tally.line())

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
        """Say how to go on after Ctrl-C, and what it has cost."""
        self.say(f"Stopped. Every finished trial is in {directory}; run the same command again to go on.")
        self._spent()

    def stopped(self, reached: BudgetReached, owed: int, trials: int) -> None:
        """Say that the budget is spent, and how to go on.

        Args:
            reached: What was spent, and allowed.
            owed: Trials that are still owed.
            trials: Trials of the study.
        """
        self.say(
            f"Budget reached: {money(reached.spent)} of {money(reached.budget)} spent, too little is left for a call; "
            f"{owed} of {trials} trials are owed; the same command with a larger --budget goes on"
        )
        self.tally.ledger = None  # what was spent is said

    def broke(self) -> None:
        """Say that not one trial of the run ended, why, and how to go on."""
        self.say(
            f"No trial ended: {self.tally.broken_in_all} broke, the first at {self.tally.first_error}; "
            "the same command plays them again"
        )

    def owed_anew(self, trials: int) -> None:
        """Say how many trials are played anew on request, though an unusable reply had ended them for good."""
        self.say(f"Owed anew: {count(trials, 'trial')} that ended as an error at reply; the earlier records stay")

    def invalid(self, found: Sequence[Invalid]) -> None:
        """Say which conditions have no valid trial, why, and how to go on."""
        self.say(invalid_in_words(found))

    def _spent(self) -> None:
        if self.tally.ledger is not None and (said := spent_in_words(self.tally.ledger.total)):
            self.say(f"Calls: {said}")

    def reported(self, path: Path | None) -> None:
        """Say what it has cost, and name the report; None where there is none."""
        self._spent()
        if self._report:
            self.say("No report: no trial has ended" if path is None else f"Report: {path}")
        elif self._journal is not None:
            self.say(f"No report, as asked; lockprobe report {self._journal.directory} writes it")
