"""The progress of a run as a live table on a terminal, as JSON lines, or as plain lines."""

from __future__ import annotations

import json as json_
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, redirect_stdout
from dataclasses import asdict
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, TextIO

from rich.console import Console, Group
from rich.live import Live
from rich.table import Table
from rich.text import Text

from lockprobe.agents.catalogue import AgentSource
from lockprobe.cli.format_cost import estimate_facts, spent_facts
from lockprobe.cli.progress import Plain, invalid_in_words, told
from lockprobe.cli.result import result_facts
from lockprobe.foundation.errors import BudgetReached, UserMistake
from lockprobe.foundation.left_out import LeftOutSection
from lockprobe.foundation.terminal_text import printable
from lockprobe.studies.costs.budget import Budget
from lockprobe.studies.costs.estimate import Estimate
from lockprobe.studies.options.valid_conditions import Invalid
from lockprobe.studies.records.directory import read_study
from lockprobe.studies.records.journal import Journal
from lockprobe.studies.records.results_hash import StudyHashes
from lockprobe.studies.records.trial_rows import Timing
from lockprobe.studies.study import Study
from lockprobe.trial.model_call import Call
from lockprobe.trial.record import Step, Trial

if TYPE_CHECKING:
    from lockprobe.report.rows import Results


class JsonLines(Plain):
    """Prints progress as JSON, one object per line, with every step and trial of slow agents.

    What agents print meanwhile goes to the standard error stream, so that every line is JSON.
    """

    _hashes: Mapping[str, object] = MappingProxyType({})
    _lines: TextIO | None = None

    def say(self, text: str) -> None:
        """Print nothing: :meth:`event` prints everything."""

    @contextmanager
    def played(self) -> Iterator[None]:
        """Play here."""
        self._lines = sys.stdout
        try:
            with redirect_stdout(sys.stderr):
                yield
        finally:
            self._lines = None

    def event(self, kind: str, **facts: object) -> None:
        """Print one event."""
        print(json_.dumps({"event": kind, **facts}), file=self._lines, flush=True)

    def begin(self, study: Study, journal: Journal, owed: int) -> None:
        """Print the study's settings and its progress."""
        self.event(
            "begin",
            directory=str(journal.directory),
            trials=study.size - study.invited,
            owed=owed,
            done=sum(not trial.owed_again and trial.spec in study.agents for trial in journal.trials.values()),
            settings=study.settings(),
            settings_hash=read_study(journal.directory).settings_hash,
        )
        super().begin(study, journal, owed)

    def begin_forks(self, study: Study, journal: Journal, owed: int, lines: Sequence[str]) -> None:
        """Print what will be forked."""
        self.event("begin", directory=str(journal.directory), owed=owed, message=" ".join(lines))
        super().begin_forks(study, journal, owed, lines)

    def agent(self, source: AgentSource, owed: int) -> None:
        """Print that an agent begins."""
        super().agent(source, owed)
        self.event("agent", agent=self.tally.agent, owed=owed)

    def step(self, key: str, step: Step) -> None:
        """Print a step of a slow agent."""
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
        """Print a finished trial."""
        self.tally.trial(trial)
        error = None if trial.error is None else {"boundary": trial.error.boundary, "message": trial.error.message}
        self.event(
            "trial",
            key=trial.key,
            ending=trial.ending,
            steps=len(trial.steps),
            seconds=round(timing.seconds, 3),
            error=error,
            **self._cost(),
        )

    def _cost(self) -> dict[str, object]:
        return {} if self.tally.ledger is None else {"spent": spent_facts(self.tally.ledger.total)}

    def estimated(self, found: Sequence[Estimate]) -> None:
        """Print the estimated cost, before any call is made."""
        allowed, spent = (None, None) if self._budget is None else (self._budget.allowed, self._budget.spent)
        self.event("estimate", agents=[estimate_facts(one) for one in found], budget=allowed, spent=spent)

    def call(self, call: Call) -> None:
        """Print a call that its provider did not answer at once."""
        super().call(call)
        if call.retries or call.error:
            self.event(
                "call",
                key=call.key,
                step=call.step,
                turn=call.turn,
                retries=call.retries,
                seconds=round(call.seconds, 3),
                error=call.error or None,
            )

    def given_up(self, source: AgentSource, owed: int, why: UserMistake) -> None:
        """Print that an agent cannot go on."""
        super().given_up(source, owed, why)
        self.event("given-up", agent=self.tally.agent, owed=owed, message=str(why))

    def first_report(self, path: Path) -> None:
        """Print that a first report can be read."""
        self.event("first-report", path=str(path))

    def interrupted(self, directory: Path, found: Results | None = None, finished: int = 0) -> None:
        """Print that Ctrl-C stopped the run, and what the last report found of how many trials."""
        facts = {} if found is None else {"reported": found.progress.finished, **result_facts(found, directory)}
        self.event("interrupted", directory=str(directory), finished=finished, **facts, **self._cost())

    def stopped(self, reached: BudgetReached, owed: int, trials: int) -> None:
        """Print that the budget is spent."""
        self.event(
            "budget",
            spent=self._spent_at_last(reached),
            budget=reached.budget,
            needed=reached.needed,
            owed=owed,
            trials=trials,
        )

    def decided(self, lines: Sequence[str], facts: Sequence[Mapping[str, object]]) -> None:
        """Print what is decided."""
        self.event("decided", message=lines[0], answers=list(facts))

    def broke(self, *, in_vain: bool = False) -> None:
        """Print how many trials of the run broke, whether replays were in vain, and which agents were given up."""
        tally = self.tally
        self.event(
            "broke",
            trials=tally.broken_in_all,
            ended=tally.ended_in_all,
            agents=dict(tally.broken_of),
            first=tally.first_error,
            replays_in_vain=in_vain,
            given_up={agent: {"owed": owed, "why": why} for agent, (why, owed) in tally.given_up.items()},
        )

    def owed_anew(self, trials: int, boundary: str) -> None:
        """Print how many trials will be replayed on request."""
        self.event("owed-anew", trials=trials, boundary=boundary)

    def advise(self, text: str) -> None:
        """Print what is wrong and how to mend it."""
        self.event("advice", message=text)

    def invalid(self, found: Sequence[Invalid]) -> None:
        """Print the conditions without a valid trial."""
        self.event("no-valid-trial", conditions=[asdict(one) for one in found], message=invalid_in_words(found))

    def recorded(self, found: StudyHashes) -> None:
        """Keep the hashes of settings and records for the last event."""
        self._hashes = {"settings_hash": found.settings, "results_hash": found.results}

    def reported(
        self, path: Path | None, left_out: Sequence[LeftOutSection] = (), found: Results | None = None
    ) -> None:
        """Print the path of the report, or None without one, what it found, and the hashes if there are trials."""
        missing = {"left_out": [one.plain() for one in left_out]} if left_out else {}
        path_said = None if path is None else str(path)
        facts = {} if found is None or path is None else result_facts(found, path.parent)
        self.event("report", path=path_said, **facts, **missing, **self._hashes, **self._cost())


class LiveDisplay(Plain):
    """A table that is updated in place, with the latest step of every trial in progress."""

    _guesses = False  # the table says it, and renews it

    def __init__(self, console: Console, *, budget: Budget | None = None, report: bool = True) -> None:
        super().__init__(budget=budget, report=report)
        self._console = console
        self._playing: dict[str, str] = {}
        self._live: Live | None = None

    def say(self, text: str) -> None:
        """Print above the table."""
        self._console.print(Text(printable(text)))

    def agent(self, source: AgentSource, owed: int) -> None:
        """Begin a new table for an agent."""
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

    def call(self, call: Call) -> None:
        """Show the cost of a finished call in the table."""
        assert self.tally.ledger is not None
        self.tally.ledger.add(call)

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


class Attended(Plain):
    """Plain lines without steps, because the person who works the plant here must not read the agents' reports."""

    def step(self, key: str, step: Step) -> None:
        """Count a step."""
        self.tally.steps += 1


@contextmanager
def watch(
    *,
    json: bool,
    budget: Budget | None = None,
    report: bool = True,
    attended: bool = False,
) -> Iterator[Plain]:
    """The display that fits the output: JSON lines, plain lines, or a live table on a terminal.

    ``attended``: the plant asks questions at this terminal. A table would cover them, and the person who answers must
    not see reports.
    """
    if json:
        yield JsonLines(budget=budget, report=report)
    elif attended:
        yield Attended(budget=budget, report=report)
    elif not sys.stdout.isatty():
        yield Plain(budget=budget, report=report)
    else:
        display = LiveDisplay(Console(emoji=False), budget=budget, report=report)
        try:
            yield display
        finally:
            display.close()
