"""The progress of a run in plain lines: trials, speed, errors and cost."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from lockprobe.agents.catalogue import AgentSource, is_strategy, resolve
from lockprobe.cli.format_cost import estimate_lines, money, spent_in_words
from lockprobe.cli.result import result_lines
from lockprobe.cli.server_marks import ServerMarks
from lockprobe.cli.tally import Tally
from lockprobe.foundation.errors import BudgetReached, UserMistake
from lockprobe.foundation.formatting import count
from lockprobe.foundation.left_out import LeftOutSection, without
from lockprobe.foundation.terminal_text import printable
from lockprobe.plants.catalogue import resolve_plant
from lockprobe.statistics.why.arms import CROSSED
from lockprobe.studies.costs.budget import Budget
from lockprobe.studies.costs.call_log import read_calls
from lockprobe.studies.costs.estimate import Estimate, estimates
from lockprobe.studies.costs.spending import Ledger, hosted
from lockprobe.studies.options.presets import preset
from lockprobe.studies.options.valid_conditions import Invalid
from lockprobe.studies.records.directory import read_study
from lockprobe.studies.records.journal import Journal
from lockprobe.studies.records.read_records import LeftOut
from lockprobe.studies.records.results_hash import StudyHashes
from lockprobe.studies.records.store import STORE
from lockprobe.studies.records.trial_rows import Timing
from lockprobe.studies.running.observer import Observer
from lockprobe.studies.study import Study
from lockprobe.studies.until import LOOK_EVERY
from lockprobe.trial.model_call import Call
from lockprobe.trial.record import Step, Trial
from lockprobe.trial.told_outcome import in_words

if TYPE_CHECKING:
    from lockprobe.report.rows import Results

_FIRST = 2.0
"""Seconds until the first line about the state of an agent."""

_EVERY = 60.0
"""Seconds from one such line to the next, whether a trial has ended or not."""

STEPS_PER_TRIAL = 17.0
STEPS_PER_MINUTE = 300.0
"""What the embedded model was measured to play on two cores; only for the first guess of the time."""


_KINDS = {"flips": "Flip study", "modalities": "Modality study"}
"""What the paper's studies are called."""


def minutes(trials: int) -> int:
    """A first estimate of how long the embedded model needs for these trials, in whole minutes."""
    return max(1, round(trials * STEPS_PER_TRIAL / STEPS_PER_MINUTE))


def told(step: Step) -> str:
    """One step in words: the truth, and the report if it was false."""
    lie = f" (told: {in_words(step.told_moved)})" if step.told_falsely else ""
    return f"step {step.step:2}  {step.joint} {in_words(step.moved)}{lie}"


_LOOKS = (
    f"After every {LOOK_EVERY} blocks it looks what is decided. A decision holds however often it looks; conditions "
    "that are decided are no longer played."
)


def _extent(study: Study) -> str:
    """How many trials are played."""
    if study.until:
        return f"until {study.until}, at most {count(study.repetitions * study.trials, 'trial')} per condition,"
    apart = f" ({study.strategy_trials} for strategies)" if study.strategy_trials is not None else ""
    return f"{count(study.repetitions, 'repetition')} of {count(study.trials, 'trial')}{apart}"


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
    said, source = f"Plant: {study.plant}", resolve_plant(study.plant)
    if study.has_pictures and owed and source.picture_size is not None:
        said += f"; pictures by {source.renderer()}"
    own = study.name == "modalities" and study.plant == preset("modalities").plant
    robot = "; the paper's robot is --plant twin" if own else ""
    return [said + robot]


_BLOCKS = (
    "Of studies of 50 trials a condition, 96 % or more name the right cause of an effect of the paper's size; a "
    "smaller effect needs more (lockprobe power why)"
)


def _of_agents(study: Study) -> list[str]:
    """Which agents look at no pictures, and how many trials a study of controls needs of a model."""
    reading = [study.label_of(agent) for agent in study.agents if study.modalities_of(agent) != study.modalities]
    said = [f"Reports only, since they look at no pictures: {', '.join(reading)}"] if reading else []
    crossed = {one.label for one in study.conditions} >= set(CROSSED)
    return said + [_BLOCKS] * (crossed and not all(map(is_strategy, study.agents)))


def _invited(study: Study, journal: Journal) -> str:
    """That people are invited, not run, and how many of their trials were played."""
    played = sum(not trial.owed_again for trial in journal.trials.values() if trial.player)
    return (
        f"People: {played} of {count(study.invited, 'trial')} played; they are not run but invited, by "
        f"lockprobe serve {journal.directory}"
    )


class Plain(Observer):
    """Prints lines: the first trial's steps of every slow agent, then how it goes."""

    _guesses = True
    """Whether the line that begins an agent says how long it may take."""

    def __init__(self, *, budget: Budget | None = None, report: bool = True) -> None:
        self.tally = Tally()
        self._budget, self._report = budget, report
        self._marks = ServerMarks()
        self._journal: Journal | None = None
        self._simulated = self._until = False
        self._shown: str | None = None
        self._due = 0.0

    def played(self) -> AbstractContextManager[None]:
        """A context in which trials are played."""
        return nullcontext()

    def close(self) -> None:
        """End a live table, where there is one."""

    def say(self, text: str) -> None:
        """Print one line at once."""
        print(printable(text), flush=True)

    def advise(self, text: str) -> None:
        """Say what is wrong and how to mend it, while the run goes on."""
        self.say(text)

    def begin(self, study: Study, journal: Journal, owed: int) -> None:
        """Say what will be played, how long it should take, where it goes, and what of it is done."""
        self._journal, self._simulated, self.tally = journal, study.simulated, Tally(study)
        self._until = study.until is not None
        run = study.size - study.invited
        if not run:
            self.say(_invited(study, journal))
            return
        little = preset("flips").when["short"]
        short = study.of_flips and ([*study.p], study.trials, study.repetitions) == (little.p, little.trials, 3)
        kind = _KINDS.get(study.name, f"Study {study.name}") if study.of_flips else f"Study {study.name}"
        self.say(
            f"{f'Short {kind.lower()}' if short else kind} on {study.boxes_in_words}: {_conditions(study)}; "
            f"{_extent(study)} of {study.max_steps} steps; agents {', '.join(study.labels)}; seed {study.seed}"
        )
        invited = [_invited(study, journal)] if study.invited else []
        for line in (*_of_the_plant(study, owed), *_of_agents(study), *invited):
            self.say(line)
        if short:
            engines = {spec: resolve(spec).engine for spec in study.agents}
            trials = sum(study.size_of(spec) for spec, engine in engines.items() if engine == "process")
            time_needed = f"about {minutes(trials)} minutes on two cores" if trials else "some seconds"
            if "network" in engines.values():
                time_needed += " and what the provider needs"
            self.say(f"First guess: {time_needed}; --full plays the paper's 7 flip rates x 3 repetitions x 10 trials.")
        self.say(f"Records: {journal.directory} (the same command resumes it)")
        self.say(settings_line(read_study(journal.directory).settings_hash))
        done = sum(not trial.owed_again for trial in journal.trials.values() if not trial.player)
        if study.until:
            self.say(f"{done} trials are done already; {owed} are owed before the next look" if done else _LOOKS)
        elif done:
            self.say(f"{done} of {run} trials are done already; {owed} are owed")
        elif study.shard:
            self.say(f"{owed} of {replace(study, shard=None).size - study.invited} trials are played here")
        if hosted(study):
            self._count_calls(study, journal)
            self.estimated(estimates(study, journal.trials, read_calls(journal.directory)))

    def begin_forks(self, study: Study, journal: Journal, owed: int, lines: Sequence[str]) -> None:
        """Say what is forked, where it goes, and what of it is done; ``owed`` forks are to be played."""
        self._journal, self._simulated, self.tally = journal, study.simulated, Tally(study)
        self.tally.tells_solved = False
        for line in lines:
            self.say(line)
        if hosted(study):
            self._count_calls(study, journal)

    def _count_calls(self, study: Study, journal: Journal) -> None:
        """Count what a provider has charged so far, and what it charges from now on."""
        self.tally.ledger, self.tally.calls = Ledger(study, read_calls(journal.directory)), journal.calls
        journal.calls.listen(self.call)

    def estimated(self, found: Sequence[Estimate]) -> None:
        """Say what will be spent, before anything is."""
        for line in (line for one in found for line in estimate_lines(one)):
            self.say(line)
        if self._budget is None:
            return
        before = f", of which {self._at_most(self._budget.spent)} is spent" if self._budget.spent else ""
        left = self._budget.allowed - self._budget.spent
        lasts = left >= sum(one.dollars(one.full, cached=False) or 0.0 for one in found)
        self.say(
            f"Budget: {money(self._budget.allowed)}{before}"
            f"{'' if lasts else '; it may not last: the study then stops, and goes on with a larger one'}"
        )

    def call(self, call: Call) -> None:
        """A call is on disk; say what it shows of its server, and how it goes if nothing has been said for long."""
        assert self.tally.ledger is not None
        self.tally.ledger.add(call)
        if said := self._marks.notice(self.tally.agent, call):
            self.advise(said)
        self._say_state()

    def _say_state(self, *, now: bool = False) -> None:
        """Say how it goes, if that is due or to be said now."""
        if now or time.monotonic() >= self._due:
            self._due = time.monotonic() + _EVERY
            self.say("  " + self.tally.line())

    def agent(self, source: AgentSource, owed: int) -> None:
        """An agent's turn comes."""
        assert self._journal is not None
        done = [trial for trial in self._journal.trials.values() if trial.agent == source.spec and not trial.owed_again]
        self.tally.turn(source, owed, done, slow=self._simulated or source.engine != "inline")
        self._shown, self._due = None, time.monotonic() + _FIRST
        self.tally.guess = f"about {minutes(owed)} min" if source.engine == "process" else "…"
        guess = f", {self.tally.guess}" if source.engine == "process" and self._guesses else ""
        self.say(f"{self.tally.agent}: {count(owed, 'trial')} to play{guess}")

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
        self._say_state(now=self.tally.played == self.tally.agent_owed and not self._until)

    def more(self, owed: int) -> None:
        """Count the trials that follow a look."""
        self.tally.agent_owed += owed

    def given_up(self, source: AgentSource, owed: int, why: UserMistake) -> None:
        """Say that an agent cannot go on; the others do."""
        self.tally.given_up[self.tally.agent] = (str(why), owed)
        self.say(f"  given up: {why}")

    def first_report(self, path: Path) -> None:
        """Say that a first report can be read while the run goes on."""
        self.say(f"First report: {path} (renewed while the run goes on)")

    def interrupted(self, directory: Path, found: Results | None = None, finished: int = 0) -> None:
        """Say how to go on after Ctrl-C, what it has cost, and what the last report found of which trials.

        Args:
            directory: The directory of the study.
            found: What its last report found; None without one.
            finished: The trials of the study that are finished now.
        """
        self.close()
        self.say(f"Stopped. Every finished trial is in {directory}; run the same command again to go on.")
        self._spent()
        if not self._report or not finished:
            return
        renews = f"lockprobe report {directory} {'renews' if found else 'writes'} it"
        if found is None:
            self.say(f"No report yet; {renews}")
        elif found.progress.finished < finished:
            then = count(found.progress.finished, "trial")
            self.say(f"{directory / 'report.html'} is older than the records: it has {then} of {finished}; {renews}")
        self._found(found, directory)

    def _found(self, found: Results | None, directory: Path) -> None:
        for line in result_lines(found, directory) if found is not None else ():
            self.say(line)

    def stopped(self, reached: BudgetReached, owed: int, trials: int) -> None:
        """Say that the budget is spent, how many trials of the study are owed, and how to go on."""
        self.close()
        spent = self._at_most(self._spent_at_last(reached))
        self.say(
            f"Budget reached: {spent} of {money(reached.budget)} spent, too little is left for a call; "
            f"{owed} of {trials} trials are owed; the same command with a larger --budget goes on"
        )

    def _at_most(self, spent: float) -> str:
        """What counts against the budget, which takes calls of unknown cost at their upper bound."""
        counted = None if self.tally.ledger is None else self.tally.ledger.total.dollars
        bound = "at most " if counted is not None and money(counted) != money(spent) else ""
        return f"{bound}{money(spent)}"

    def _spent_at_last(self, reached: BudgetReached) -> float:
        """What is spent when the last call has returned."""
        return reached.spent if self._budget is None else self._budget.spent

    def decided(self, lines: Sequence[str], facts: Sequence[Mapping[str, object]]) -> None:
        """Say what a study that stops when it is decided has decided; ``facts`` are the same for programs."""
        self.close()
        for line in lines:
            self.say(line)

    def broke(self, *, in_vain: bool = False) -> None:
        """Say how many trials of the run broke, which agents were given up, why, and how to go on.

        Args:
            in_vain: Whether every trial that was replayed broke again, at the same step or later.
        """
        self.close()
        if self.tally.broken_in_all:
            self.say(self._broken(in_vain=in_vain))
        if given_up := self.tally.given_up.values():
            said = "; ".join(f"{why} ({count(owed, 'trial')} owed)" for why, owed in given_up)
            self.say(f"Given up: {said}; nothing finished is lost, the same command goes on when that is mended")

    def _broken(self, *, in_vain: bool) -> str:
        tally = self.tally
        broken, played = tally.broken_in_all, tally.broken_in_all + tally.ended_in_all
        if not tally.ended_in_all:
            said = f"No trial ended: {broken} broke, the first at {tally.first_error}"
        else:
            whose = ", ".join(tally.broken_of)
            said = f"{broken} of {played} trials broke and are owed, of {whose}; the first at {tally.first_error}"
        if in_vain:
            why = "every replay broke again at the same step or later"
            return f"{said}; the same command cannot help until the cause is mended: {why}"
        return f"{said}; the same command plays {'it' if broken == 1 else 'them'} again"

    def owed_anew(self, trials: int, boundary: str) -> None:
        """Say how many trials are replayed on request after their agent had ended them for good."""
        self.say(f"Owed anew: {count(trials, 'trial')} that ended as an error at {boundary}; the earlier records stay")

    def invalid(self, found: Sequence[Invalid]) -> None:
        """Say which conditions have no valid trial, why, and how to go on."""
        self.close()
        self.say(invalid_in_words(found))

    def _spent(self) -> None:
        if self.tally.ledger is not None and (said := spent_in_words(self.tally.ledger.total)):
            self.say(f"All calls: {said}")

    def recorded(self, found: StudyHashes) -> None:
        """Say the hash of the records after the last trial of the run."""
        self.close()
        if self._report is not None:
            self.say(results_line(found))

    def reported(
        self, path: Path | None, left_out: Sequence[LeftOutSection] = (), found: Results | None = None
    ) -> None:
        """Say what it has cost, name the report, and say what it found.

        Args:
            path: The page; None where there is none.
            left_out: Sections that could not be made.
            found: What it found; None likewise.
        """
        self.close()
        self._spent()
        if self._report:
            self.say("No report: no trial has ended" if path is None else f"Report: {path}{without(left_out)}")
            if path is not None:
                self._found(found, path.parent)
        elif self._report is not None and self._journal is not None:
            self.say(f"No report, as asked; lockprobe report {self._journal.directory} writes it")


def settings_line(found: str) -> str:
    """The hash of the settings, as it is said before the first trial."""
    return f"Settings: {found} (for a preregistration; lockprobe verify DIR --settings HASH checks it)"


def results_line(found: StudyHashes) -> str:
    """The hash of the records, as it is said after the last trial."""
    so_far = "" if found.finished == found.planned else f" so far, {found.finished} of {found.planned} trials"
    return f"Results: {found.results} (for a paper{so_far}; lockprobe verify DIR --results HASH checks it)"


def foreign_in_words(left_out: LeftOut) -> str:
    """That records of other studies are in the store, how many, and which is the first; empty where none is."""
    if not left_out.foreign:
        return ""
    records = count(left_out.foreign, "record")
    return f"{records} of another study in {STORE} are not counted; the first is {left_out.first_foreign}"


def invalid_in_words(found: Sequence[Invalid]) -> str:
    """Conditions without a valid trial in one line: which, why, and what plays their trials again; at least one."""
    errors, owed = sum(one.errors for one in found), sum(one.owed for one in found)
    others = f" and {count(len(found) - 1, 'more condition')}" if len(found) > 1 else ""
    ended = "the only trial" if errors == 1 else f"all {errors} trials"
    first = f"{found[0].first.boundary}: {' '.join(found[0].first.message.split())[:200]}"
    again = " and then ".join(f"--again {name}" for name in sorted({name for one in found for name in one.final}))
    remedy = {errors: "the same command plays them again", 0: f"the same command with {again} plays them anew"}
    mixed = f"the same command plays {owed} of them again, with {again} all"
    return (
        f"No valid trial of {found[0].condition}{others}: {ended} ended as an error, the first at {first}; "
        f"{remedy.get(owed, mixed)}"
    )
