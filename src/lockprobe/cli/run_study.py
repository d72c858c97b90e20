"""Plays the study that a command line asks for, and tells how it goes: in lines for people, or JSON for programs.

On a terminal, people see a line that is renewed.
"""

from __future__ import annotations

import json as json_
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import nullcontext, redirect_stdout
from dataclasses import replace
from functools import partial
from importlib import import_module
from pathlib import Path
from threading import Thread

import typer
from rich.console import Console
from rich.live import Live
from rich.text import Text

from lockprobe.agents.catalogue import AgentSource
from lockprobe.cli.format_cost import estimate_lines, in_boundaries, money, settings_line, spent_facts, spent_in_words
from lockprobe.cli.result import decided, write
from lockprobe.foundation.errors import AgentsGivenUp, BudgetReached, UserMistake
from lockprobe.foundation.formatting import count
from lockprobe.foundation.terminal_text import printable
from lockprobe.studies import SETTINGS
from lockprobe.studies.costs.estimate import estimates
from lockprobe.studies.costs.spending import Budget, Spending, hosted, total
from lockprobe.studies.decisions import LOOK_EVERY, planned_now
from lockprobe.studies.options.study_options import read_options
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.records.directory import extended, read_study
from lockprobe.studies.records.journal import Journal
from lockprobe.studies.records.read_records import load, results_hash, stored_records
from lockprobe.studies.running.executor import Limits, Observer
from lockprobe.studies.running.runner import next_plans
from lockprobe.studies.running.runner import run as play_trials
from lockprobe.studies.study import SIZES, Study
from lockprobe.trial.record import Step, Trial

BROKE = 1
"""The exit status if something outside the agents broke trials, which are owed again, or no trial ended validly."""

BUDGET_REACHED = 3
"""The exit status if the budget ended a study before its last trial."""

_FIRST, _EVERY = 2.0, 60.0
"""Seconds until the first line about the state of an agent, and from one to the next, whether a trial ended or not."""


def planned_study(name: str, asked: Mapping[str, object], out: Path | None) -> tuple[Study, Path]:
    """The study of a name or file with the options of the command line, and its directory.

    Without an agent, those of an existing study play; if nothing is said of its size, it stays as large as it is.
    """
    request = read_options(name, asked)
    planned = study(request)
    directory = out or Path("lockprobe-runs") / f"{planned.name}-{planned.identity}"
    if not (directory / SETTINGS).exists():
        return planned, directory
    there = read_study(directory)
    if not {*SIZES, "full"} & request.model_fields_set:
        planned = replace(planned, **{name: getattr(there, name) for name in SIZES})
    if request.agent is None and there.run_agents:
        planned = replace(planned, agents=there.run_agents, names=there.names)
    return extended(planned.ordered_as(there), directory), directory


def play_study(
    planned: Study, directory: Path, limits: Limits, budget: float | None, *, report: bool = True, json: bool = False
) -> None:
    """Play the trials that a study owes, and write its report.

    Args:
        planned: The study.
        directory: The directory of the study, existing or new.
        limits: How much is played at once.
        budget: The budget of the study, US dollars.
        report: Whether to write the report after the run.
        json: Whether to print events as JSON.

    Raises:
        Exit: With the exit status, if that is not 0. Of a run of which nothing was kept no directory is left behind.
    """
    with Journal.open(directory, planned) as journal:
        progress = Progress(planned, journal, json=json, budget=budget)
        progress.watch(partial(play_trials, planned, journal, limits=limits, observer=progress))
        if planned.until and journal.trials:
            lines, answers = decided(planned, load(directory))
            progress.tell("decided", *lines, message=lines[0], answers=answers)
        if planned.size == planned.invited and not journal.trials:
            return  # people have yet to be invited
        facts, path = dict[str, object](), None
        if journal.trials:
            there, finished = journal.study, done_of(journal)
            records = results_hash(there, stored_records(journal.store))
            whole = planned_now(there, load(directory) if there.until else ())
            so_far = "" if finished == whole else f" so far, {finished} of {whole} trials"
            progress.say(f"Results: {records} (for a paper{so_far}; lockprobe verify DIR --results HASH checks it)")
            facts = {"settings_hash": there.settings_hash, "results_hash": records}
        if not report:
            lines = [f"No report, as asked; lockprobe report {directory} writes it"]
        elif not journal.trials:
            lines = ["No report: no trial has ended"]
        else:
            page, (lines, found) = write(directory)
            facts, path = facts | found, str(page)
        progress.tell("report", *progress.spent(), *lines, path=path, **facts, **progress.cost())
        valid = not journal.trials or any(trial.ending != "error" for trial in journal.trials.values())
        owed = 0
        if progress.reached or progress.broken or progress.abandoned:
            plans = next_plans(planned, journal)
            owed = sum(journal.owes(plan.key) for agent in planned.run_agents for plan in plans(agent))
        status = progress.end(owed, planned.size - planned.invited) or (0 if valid else BROKE)
        if status:
            raise typer.Exit(status)


def done_of(journal: Journal, study: Study | None = None) -> int:
    """The finished trials; with a study, those that it runs, without those of people."""
    return sum(
        not one.owed_again and (study is None or one.spec in study.run_agents) for one in journal.trials.values()
    )


def _begin_lines(study: Study, journal: Journal, owed: int) -> Iterator[str]:
    """What will be played, where it goes, and what of it is done."""
    run, done, whole = study.size - study.invited, done_of(journal, study), replace(study, shard=None)
    if study.invited:
        said = f"People: {done_of(journal) - done} of {count(study.invited, 'trial')} played; they are not run"
        yield f"{said} but invited, by lockprobe serve {journal.directory}"
    if not run:
        return
    plant = f" as {study.plant}" * study.simulated
    extent, most = f"{count(study.repetitions, 'repetition')} of {count(study.trials, 'trial')}", ""
    if study.until:
        each, most = count(study.repetitions * study.trials, "trial"), "at most "
        extent = f"until {study.until}, at most {each} per condition, looking after every {LOOK_EVERY} blocks,"
    elif study.strategy_trials is not None:
        extent += f" ({study.strategy_trials} for strategies)"
    yield (
        f"Study {study.name} on {study.boxes_in_words}{plant}: {count(len(study.conditions), 'condition')}: "
        f"{'; '.join(one.label for one in study.conditions)}; {extent} of {study.max_steps} steps; "
        f"agents {', '.join(study.labels)}; seed {study.seed}; "
        f"{most}{count(whole.size - whole.invited, 'trial')} in all"
    )
    yield f"Records: {journal.directory} (the same command resumes it)"
    yield settings_line(journal.study.settings_hash)
    if done or study.shard:
        yield f"{done} of {most}{run} trials are done already; {owed} are owed{' before the next look' * bool(most)}"


class Progress(Observer):
    """Tells how a run goes, every news once: as lines for people, or as an event for programs.

    Args:
        study: The study. Where its plant asks questions at this terminal, no line covers them.
        journal: Where trials are written.
        json: Whether programs read it. What agents print then goes to standard error, so that every line is JSON.
        budget: What its calls may cost, US dollars.
        forks: What is said of forks at the beginning; None of a study.

    Attributes:
        broken: Agents of which trials broke outside them in this run, each with their number.
        abandoned: Agents that could not go on -> why, and how many trials they owe.
        reached: What ended the run early, if the budget did.
    """

    def __init__(
        self,
        study: Study,
        journal: Journal,
        *,
        json: bool = False,
        budget: float | None = None,
        forks: Sequence[str] | None = None,
    ) -> None:
        self._study, self._journal = study, journal
        self._json, self._forks, self._out = json, forks, sys.stdout
        self._budget = journal.calls.budget = None if budget is None else Budget(study, budget)
        self.broken, self.abandoned = Counter[str](), dict[str, tuple[str, int]]()
        self.reached: BudgetReached | None = None
        self._ended, self._first_error, self._agent = 0, "", ""
        self._now, self._errors = Counter[str](), Counter[str]()  # of the present agent
        self._began = self._due = 0.0
        self._live: Live | None = None
        if sys.stdout.isatty() and not (json or study.attended):
            shown, console = lambda: Text(printable(self._agent and self.line())), Console(emoji=False, highlight=False)
            self._live = Live(get_renderable=shown, console=console, refresh_per_second=4)

    def watch(self, play: Callable[[], None]) -> None:
        """Tell of what is played within the budget; Ctrl-C is told and raised again."""
        try:
            with redirect_stdout(sys.stderr) if self._json else self._live or nullcontext():
                play()
        except KeyboardInterrupt:
            where, facts = str(self._journal.directory), {"finished": done_of(self._journal), **self.cost()}
            first = f"Stopped. Every finished trial is in {where}; run the same command again to go on."
            self.tell("interrupted", first, *self.spent(), directory=where, **facts)
            raise
        except BudgetReached as reached:
            self.reached = reached
        except AgentsGivenUp:
            if not self._journal.trials:  # nothing was played: the command cannot be carried out
                raise

    def say(self, text: str) -> None:
        """Print a line for people; programs get none."""
        if self._live and self._live.is_started:
            self._live.console.print(Text(printable(text)))
        elif not self._json:
            print(printable(text), file=self._out, flush=True)

    def tell(self, event: str, *lines: str, **facts: object) -> None:
        """Print lines for people, or an event with facts for programs."""
        if self._json:
            print(json_.dumps({"event": event, **facts}), file=self._out, flush=True)
        for line in lines:
            self.say(line)

    def begin(self, study: Study, journal: Journal, owed: int) -> None:
        """Tell what will be played, where it goes, what of it is done, and what it may cost."""
        where = str(journal.directory)
        if self._forks is not None:
            self.tell("begin", *self._forks, directory=where, owed=owed)
            return
        facts = {"owed": owed, "done": done_of(journal, study), "settings": study.settings()}
        facts |= {"trials": study.size - study.invited, "settings_hash": journal.study.settings_hash}
        self.tell("begin", *_begin_lines(study, journal, owed), directory=where, **facts)
        if not hosted(study):
            return
        found, limit = estimates(study, journal.trials), dict[str, float]()
        lines = [line for one in found for line in estimate_lines(one)]
        if self._budget is not None:
            spent = journal.calls.most
            limit = {"budget": self._budget.allowed, "spent": spent}
            before = f", of which {money(spent)} is spent" if spent else ""
            lasts = self._budget.allowed - spent >= sum((one.dollars() or (0.0, 0.0))[1] for one in found)
            doubt = "" if lasts else "; it may not last: the study then stops, and goes on with a larger one"
            lines.append(f"Budget: {money(self._budget.allowed)}{before}{doubt}")
        self.tell("estimate", *lines, agents=[one.facts() for one in found], **limit)

    def agent(self, source: AgentSource, owed: int) -> None:
        """Tell that an agent's turn comes; trials of an earlier run count, but not for the time that is left."""
        if source.engine != "inline":  # this process will wait: meanwhile it loads what draws the report
            Thread(target=import_module, args=("lockprobe.report.figures.drawing",)).start()
        self._agent = self._study.label_of(source.spec)
        done = [trial for trial in self._journal.trials.values() if trial.agent == source.spec and not trial.owed_again]
        solved, valid = sum(one.solved for one in done), sum(one.ending != "error" for one in done)
        self._now, self._errors = Counter(owed=owed, before=len(done), solved=solved, valid=valid), Counter()
        self._began = time.monotonic()
        self._due = self._began + _FIRST
        self.tell("agent", f"{self._agent}: {count(owed, 'trial')} to play", agent=self._agent, owed=owed)

    def step(self, key: str, step: Step) -> None:
        """Count a step, and tell how it goes if nothing has been said for long."""
        self._now["steps"] += 1
        self._say_state()

    def trial(self, trial: Trial, seconds: float) -> None:
        """Count a trial; tell of it, and how it goes."""
        error, lines = trial.error, list[str]()
        self._now.update(played=1, valid=int(error is None), solved=int(trial.solved))
        self._ended += not trial.owed_again
        if error is not None:
            self._errors[error.boundary] += 1
            lines.append(f"  {trial.key}  error at {error.boundary}: {error.message}")
            if trial.owed_again:
                self.broken[trial.group] += 1
                self._first_error = self._first_error or f"{error.boundary}: {error.message}"
        why = None if error is None else {"boundary": error.boundary, "message": error.message}
        facts = {"steps": len(trial.steps), "seconds": round(seconds, 3), "error": why, **self.cost()}
        self.tell("trial", *lines, key=trial.key, ending=trial.ending, **facts)
        self._say_state(now=self._now["played"] == self._now["owed"] and self._study.until is None)

    def more(self, owed: int) -> None:
        """Count the trials that follow a look."""
        self._now["owed"] += owed

    def given_up(self, source: AgentSource, owed: int, why: UserMistake) -> None:
        """Tell that an agent cannot go on; the others do."""
        self.abandoned[self._agent] = (str(why), owed)
        self.tell("given-up", f"  given up: {why}", agent=self._agent, owed=owed, message=str(why))

    def _say_state(self, *, now: bool = False) -> None:
        """Say how it goes, if that is due or to be said now and no line on the terminal shows it."""
        if (now or time.monotonic() >= self._due) and self._live is None:
            self._due = time.monotonic() + _EVERY
            self.say(f"  {self.line()}")

    def line(self) -> str:
        """The state of the present agent in one short line."""
        now, seconds, left = self._now, max(time.monotonic() - self._began, 1e-9), "…"
        if now["played"]:
            needed = seconds / now["played"] * (now["owed"] - now["played"])
            left = f"{needed / 60:.0f} min" if needed > 90 else f"{needed:.0f} s"
        number, waited = self._journal.calls.on_their_way
        way = f"{count(number, 'call')} on the way, the oldest for {waited:.0f} s"
        parts = [
            f"{self._agent}  {now['before'] + now['played']}/{now['before'] + now['owed']} trials",
            f"{now['solved']} of {now['valid']} solved" * bool(now["valid"]),
            f"{now['steps'] / seconds:.1f} steps/s",
            f"{left} left",
            spent_in_words(self._spent),
            way * (waited >= 5.0),  # seconds, which most calls do not take
            in_boundaries(self._errors),
        ]
        return " · ".join(filter(None, parts))

    @property
    def _spent(self) -> Spending:
        return total(self._journal.calls.spent.values())

    def cost(self) -> dict[str, object]:
        """What it has cost, for programs; nothing without a call."""
        return {"spent": spent_facts(self._spent)} if self._journal.calls.spent else {}

    def spent(self) -> list[str]:
        """What it has cost, as a line; none without a call."""
        said = spent_in_words(self._spent)
        return [f"All calls: {said}"] if said else []

    def end(self, owed: int, trials: int) -> int:
        """Tell what broke, which agents were given up, whether the budget is spent, and how to go on.

        Args:
            owed: Trials that are owed.
            trials: Trials in all.

        Returns:
            The exit status.
        """
        broken, lines, mended = self.broken.total(), list[str](), "when that is mended"
        if broken:
            of = f"{broken} of {broken + self._ended} trials broke and are owed, of {', '.join(self.broken)}"
            lines.append(f"{of}; the first at {self._first_error}; the same command plays them again {mended}")
        if self.abandoned:
            said = "; ".join(f"{why} ({count(left, 'trial')} owed)" for why, left in self.abandoned.values())
            lines.append(f"Given up: {said}; nothing finished is lost, the same command goes on {mended}")
        if lines:
            facts = {"agents": dict(self.broken), "first": self._first_error}
            self.tell("broke", *lines, trials=broken, ended=self._ended, **facts)
        if self.reached is None or self._budget is None:
            return BROKE if owed or self.abandoned else 0
        spent, allowed = self._journal.calls.most, self._budget.allowed  # of the calls that came back since, too
        line = (
            f"Budget reached: {money(spent)} of {money(allowed)} spent, too little is left for a call; "
            f"{owed} of {trials} trials are owed; the same command with a larger --budget goes on"
        )
        self.tell("budget", line, spent=spent, budget=allowed, needed=self.reached.needed, owed=owed, trials=trials)
        return BUDGET_REACHED
