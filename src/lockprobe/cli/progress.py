"""How a run goes: as lines for people, as a table on their terminal, or as JSON lines for programs."""

from __future__ import annotations

import json as json_
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, redirect_stdout
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, TextIO

from lockprobe.agents.catalogue import AgentSource
from lockprobe.agents.llm.answer import MENDING
from lockprobe.cli.format_cost import estimate_facts, estimate_lines, money, spent_facts, spent_in_words
from lockprobe.cli.result import result_facts, result_lines
from lockprobe.cli.server_marks import ServerMarks
from lockprobe.cli.study_lines import begin_lines, done_of, invalid_in_words, minutes, results_line
from lockprobe.cli.tally import Tally
from lockprobe.foundation.errors import BudgetReached, UserMistake
from lockprobe.foundation.formatting import count
from lockprobe.foundation.left_out import LeftOutSection, without
from lockprobe.foundation.terminal_text import printable
from lockprobe.studies.costs.budget import Budget
from lockprobe.studies.costs.call_log import read_calls
from lockprobe.studies.costs.estimate import estimates
from lockprobe.studies.costs.spending import Ledger, hosted
from lockprobe.studies.records.counted import Invalid
from lockprobe.studies.records.directory import read_study
from lockprobe.studies.records.journal import Journal
from lockprobe.studies.records.results_hash import StudyHashes
from lockprobe.studies.records.trial_rows import Timing
from lockprobe.studies.running.observer import Observer
from lockprobe.studies.study import Study
from lockprobe.trial.model_call import Call
from lockprobe.trial.record import Step, Trial
from lockprobe.trial.told_outcome import in_words

if TYPE_CHECKING:
    from lockprobe.report.rows import Results

_FIRST = 2.0
"""Seconds until the first line about the state of an agent."""

_EVERY = 60.0
"""Seconds from one such line to the next, whether a trial has ended or not."""


class Progress(Observer):
    """Tells how a run goes, every news once: as lines for people, or as an event for programs.

    Lines have the steps of the first trial of every slow agent, events those of all its trials.

    Args:
        json: Whether programs read it. What agents print then goes to standard error, so that every line is JSON.
        budget: The budget of the study.
        report: Whether a report follows.
        attended: Whether the plant asks questions at this terminal: the person who answers must not see reports.
    """

    _guesses = True
    """Whether the line that begins an agent says how long it may take."""

    def __init__(
        self, *, json: bool = False, budget: Budget | None = None, report: bool = True, attended: bool = False
    ) -> None:
        self.tally = Tally()
        self._json, self._budget, self._report, self._attended = json, budget, report, attended
        self._marks = ServerMarks()
        self._hashes: dict[str, object] = {}
        self._events: TextIO | None = None
        self._journal: Journal | None = None
        self._until = False
        self._shown: str | None = None
        self._due = 0.0

    @contextmanager
    def played(self) -> Iterator[None]:
        """A context in which trials are played."""
        if not self._json:
            yield
            return
        self._events = sys.stdout
        try:
            with redirect_stdout(sys.stderr):
                yield
        finally:
            self._events = None

    def say(self, text: str) -> None:
        """Print a line for people; programs get none."""
        if not self._json:
            print(printable(text), flush=True)

    def tell(self, event: str, *lines: str, **facts: object) -> None:
        """Print lines for people, or an event with facts for programs."""
        if self._json:
            print(json_.dumps({"event": event, **facts}), file=self._events, flush=True)
        for line in lines:
            self.say(line)

    def begin(self, study: Study, journal: Journal, owed: int) -> None:
        """Tell what will be played, where it goes, what of it is done, and what it may cost."""
        self._journal, self.tally = journal, Tally(study)
        self._until = study.until is not None
        self.tell(
            "begin",
            *begin_lines(study, journal, owed),
            directory=str(journal.directory),
            trials=study.size - study.invited,
            owed=owed,
            done=done_of(study, journal),
            settings=study.settings(),
            settings_hash=read_study(journal.directory).settings_hash,
        )
        if hosted(study):
            self._count_calls(study, journal)
            self._estimate(study, journal)

    def begin_forks(self, study: Study, journal: Journal, owed: int, lines: Sequence[str]) -> None:
        """Tell what is forked, where it goes, and what of it is done; ``owed`` forks are to be played."""
        self._journal, self.tally = journal, Tally(study)
        self.tally.tells_solved = False
        self.tell("begin", *lines, directory=str(journal.directory), owed=owed, message=" ".join(lines))
        if hosted(study):
            self._count_calls(study, journal)

    def _count_calls(self, study: Study, journal: Journal) -> None:
        """Count what a provider has charged so far, and what it charges from now on."""
        self.tally.ledger, self.tally.calls = Ledger(study, read_calls(journal.directory)), journal.calls
        journal.calls.listen(self.call)

    def _estimate(self, study: Study, journal: Journal) -> None:
        """Tell what will be spent, before anything is."""
        found = estimates(study, journal.trials, read_calls(journal.directory))
        lines = [line for one in found for line in estimate_lines(one)]
        allowed = spent = None
        if self._budget is not None:
            allowed, spent = self._budget.allowed, self._budget.spent
            before = f", of which {self._at_most(spent)} is spent" if spent else ""
            lasts = allowed - spent >= sum(one.dollars(one.full, cached=False) or 0.0 for one in found)
            doubt = "" if lasts else "; it may not last: the study then stops, and goes on with a larger one"
            lines.append(f"Budget: {money(allowed)}{before}{doubt}")
        self.tell("estimate", *lines, agents=[estimate_facts(one) for one in found], budget=allowed, spent=spent)

    def call(self, call: Call) -> None:
        """A call is on disk; tell what it shows of its server, and how it goes if nothing has been said for long."""
        assert self.tally.ledger is not None
        self.tally.ledger.add(call)
        if said := self._marks.notice(self.tally.agent, call):
            self.tell("advice", said, message=said)
        if call.retries or call.error:
            self.tell(
                "call",
                key=call.key,
                step=call.step,
                turn=call.turn,
                retries=call.retries,
                seconds=round(call.seconds, 3),
                error=call.error or None,
            )
        self._say_state()

    def _say_state(self, *, now: bool = False) -> None:
        """Say how it goes, if that is due or to be said now."""
        if now or time.monotonic() >= self._due:
            self._due = time.monotonic() + _EVERY
            self.say("  " + self.tally.line())

    def agent(self, source: AgentSource, owed: int) -> None:
        """Tell that an agent's turn comes."""
        assert self._journal is not None
        done = [trial for trial in self._journal.trials.values() if trial.agent == source.spec and not trial.owed_again]
        self.tally.turn(source, owed, done)
        self._shown, self._due = None, time.monotonic() + _FIRST
        local = source.engine == "process"
        self.tally.guess = f"about {minutes(owed)} min" if local else "…"
        guess = f", {self.tally.guess}" if local and self._guesses else ""
        said = f"{self.tally.agent}: {count(owed, 'trial')} to play{guess}"
        self.tell("agent", said, agent=self.tally.agent, owed=owed)

    def step(self, key: str, step: Step) -> None:
        """Count a step; tell it if its agent is slow."""
        self.tally.steps += 1
        if not self.tally.slow:
            return
        lines = []
        if not self._attended and (self._shown == key or (self._shown is None and step.step == 1)):
            self._shown = key
            lines.append(f"  {key}  {step_in_words(step)}")
        self.tell(
            "step", *lines, key=key, step=step.step, joint=step.joint, moved=step.moved, told_moved=step.told_moved
        )

    def trial(self, trial: Trial, timing: Timing) -> None:
        """Count a trial; tell of it, and how it goes."""
        self.tally.trial(trial)
        if self._shown == trial.key:
            self._shown = ""
        error = trial.error
        self.tell(
            "trial",
            *([] if error is None else [f"  {trial.key}  error at {error.boundary}: {error.message}"]),
            key=trial.key,
            ending=trial.ending,
            steps=len(trial.steps),
            seconds=round(timing.seconds, 3),
            error=None if error is None else {"boundary": error.boundary, "message": error.message},
            **self._cost(),
        )
        self._say_state(now=self.tally.played == self.tally.agent_owed and not self._until)

    def _cost(self) -> dict[str, object]:
        return {} if self.tally.ledger is None else {"spent": spent_facts(self.tally.ledger.total)}

    def more(self, owed: int) -> None:
        """Count the trials that follow a look."""
        self.tally.agent_owed += owed

    def given_up(self, source: AgentSource, owed: int, why: UserMistake) -> None:
        """Tell that an agent cannot go on; the others do."""
        self.tally.given_up[self.tally.agent] = (str(why), owed)
        self.tell("given-up", f"  given up: {why}", agent=self.tally.agent, owed=owed, message=str(why))

    def first_report(self, path: Path) -> None:
        """Tell that a first report can be read while the run goes on."""
        self.tell("first-report", f"First report: {path} (renewed while the run goes on)", path=str(path))

    def interrupted(self, directory: Path, found: Results | None = None, finished: int = 0) -> None:
        """Tell how to go on after Ctrl-C, what it has cost, and what the last report found of which trials.

        Args:
            directory: The directory of the study.
            found: What its last report found; None without one.
            finished: The trials of the study that are finished now.
        """
        lines = [f"Stopped. Every finished trial is in {directory}; run the same command again to go on."]
        lines += self._spent()
        if self._report and finished:
            renews = f"lockprobe report {directory} {'renews' if found else 'writes'} it"
            if found is None:
                lines.append(f"No report yet; {renews}")
            elif found.progress.finished < finished:
                old = f"{directory / 'report.html'} is older than the records"
                lines.append(f"{old}: it has {count(found.progress.finished, 'trial')} of {finished}; {renews}")
            lines += result_lines(found, directory) if found is not None else []
        facts = {} if found is None else {"reported": found.progress.finished, **result_facts(found, directory)}
        self.tell("interrupted", *lines, directory=str(directory), finished=finished, **facts, **self._cost())

    def stopped(self, reached: BudgetReached, owed: int, trials: int) -> None:
        """Tell that the budget is spent, how many trials of the study are owed, and how to go on."""
        spent = reached.spent if self._budget is None else self._budget.spent  # of the calls that came back since, too
        self.tell(
            "budget",
            f"Budget reached: {self._at_most(spent)} of {money(reached.budget)} spent, too little is left for a call; "
            f"{owed} of {trials} trials are owed; the same command with a larger --budget goes on",
            spent=spent,
            budget=reached.budget,
            needed=reached.needed,
            owed=owed,
            trials=trials,
        )

    def _at_most(self, spent: float) -> str:
        """What counts against the budget, which takes calls of unknown cost at their upper bound."""
        counted = None if self.tally.ledger is None else self.tally.ledger.total.dollars
        bound = "at most " if counted is not None and money(counted) != money(spent) else ""
        return f"{bound}{money(spent)}"

    def decided(self, lines: Sequence[str], facts: Sequence[Mapping[str, object]]) -> None:
        """Tell what a study that stops when it is decided has decided; ``facts`` are the same for programs."""
        self.tell("decided", *lines, message=lines[0], answers=list(facts))

    def broke(self, *, in_vain: bool = False) -> None:
        """Tell how many trials of the run broke, which agents were given up, why, and how to go on.

        Args:
            in_vain: Whether every trial that was replayed broke again, at the same step or later.
        """
        tally, lines = self.tally, []
        if tally.broken_of:
            lines.append(self._broken(in_vain=in_vain))
        if tally.given_up:
            said = "; ".join(f"{why} ({count(owed, 'trial')} owed)" for why, owed in tally.given_up.values())
            lines.append(f"Given up: {said}; nothing finished is lost, the same command goes on when that is mended")
        self.tell(
            "broke",
            *lines,
            trials=tally.broken_of.total(),
            ended=tally.ended_in_all,
            agents=dict(tally.broken_of),
            first=tally.first_error,
            replays_in_vain=in_vain,
            given_up={agent: {"owed": owed, "why": why} for agent, (why, owed) in tally.given_up.items()},
        )

    def _broken(self, *, in_vain: bool) -> str:
        tally = self.tally
        broken = tally.broken_of.total()
        if not tally.ended_in_all:
            said = f"No trial ended: {broken} broke, the first at {tally.first_error}"
        else:
            whose = ", ".join(tally.broken_of)
            said = f"{broken} of {broken + tally.ended_in_all} trials broke and are owed, of {whose}"
            said = f"{said}; the first at {tally.first_error}"
        if in_vain:
            why = "every replay broke again at the same step or later"
            return f"{said}; the same command cannot help until the cause is mended: {why}"
        mended = "when that is mended, " if MENDING in tally.first_error else ""
        return f"{said}; {mended}the same command plays {'it' if broken == 1 else 'them'} again"

    def owed_anew(self, trials: int, boundary: str) -> None:
        """Tell how many trials are replayed on request after their agent had ended them for good."""
        said = f"Owed anew: {count(trials, 'trial')} that ended as an error at {boundary}; the earlier records stay"
        self.tell("owed-anew", said, trials=trials, boundary=boundary)

    def invalid(self, found: Sequence[Invalid]) -> None:
        """Tell which conditions have no valid trial, why, and how to go on."""
        said = invalid_in_words(found)
        self.tell("no-valid-trial", said, conditions=[asdict(one) for one in found], message=said)

    def recorded(self, found: StudyHashes) -> None:
        """Say the hash of the records after the last trial of the run; programs get it in the last event."""
        self._hashes = {"settings_hash": found.settings, "results_hash": found.results}
        self.say(results_line(found))

    def reported(
        self, path: Path | None, left_out: Sequence[LeftOutSection] = (), found: Results | None = None
    ) -> None:
        """Tell what it has cost, where the report is, and what it found.

        Args:
            path: The page; None where there is none.
            left_out: Sections that could not be made.
            found: What it found; None likewise.
        """
        assert self._journal is not None
        lines, facts = self._spent(), {}
        if path is not None:
            lines.append(f"Report: {path}{without(left_out)}")
            lines += result_lines(found, path.parent) if found is not None else []
            facts = {} if found is None else result_facts(found, path.parent)
        elif self._report:
            lines.append("No report: no trial has ended")
        else:
            lines.append(f"No report, as asked; lockprobe report {self._journal.directory} writes it")
        if left_out:
            facts["left_out"] = [one.plain() for one in left_out]
        self.tell("report", *lines, path=None if path is None else str(path), **facts, **self._hashes, **self._cost())

    def _spent(self) -> list[str]:
        said = "" if self.tally.ledger is None else spent_in_words(self.tally.ledger.total)
        return [f"All calls: {said}"] if said else []


def step_in_words(step: Step) -> str:
    """One step in words: the truth, and the report if it was false."""
    lie = f" (told: {in_words(step.told_moved)})" if step.told_falsely else ""
    return f"step {step.step:2}  {step.joint} {in_words(step.moved)}{lie}"


def watch(*, json: bool, budget: Budget | None = None, report: bool = True, attended: bool = False) -> Progress:
    """The progress that fits the output; see :class:`Progress`."""
    if json or attended or not sys.stdout.isatty():  # a table would cover the questions of a plant
        return Progress(json=json, budget=budget, report=report, attended=attended)
    from rich.console import Console

    from lockprobe.cli.live_table import LiveTable

    return LiveTable(Console(emoji=False), budget=budget, report=report)
