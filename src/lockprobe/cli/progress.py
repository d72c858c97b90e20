"""How a run goes: as lines for people, with a line that is renewed on a terminal, or as JSON lines for programs."""

from __future__ import annotations

import json as json_
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import nullcontext, redirect_stdout
from dataclasses import replace

from rich.console import Console
from rich.live import Live
from rich.text import Text

from lockprobe.agents.catalogue import AgentSource
from lockprobe.cli.format_cost import (
    estimate_facts,
    estimate_lines,
    in_boundaries,
    money,
    settings_line,
    spent_facts,
    spent_in_words,
)
from lockprobe.foundation.errors import AgentsGivenUp, BudgetReached, UserMistake
from lockprobe.foundation.formatting import count
from lockprobe.foundation.terminal_text import printable
from lockprobe.plants.catalogue import resolve_plant
from lockprobe.studies.costs.call_log import read_calls
from lockprobe.studies.costs.estimate import estimates
from lockprobe.studies.costs.spending import Budget, Ledger, hosted
from lockprobe.studies.decisions import LOOK_EVERY
from lockprobe.studies.records.directory import read_study
from lockprobe.studies.records.journal import Journal
from lockprobe.studies.running.executor import Observer
from lockprobe.studies.study import Study
from lockprobe.trial.model_call import Call
from lockprobe.trial.record import Step, Trial

BROKE = 1
"""The exit status if something outside the agents broke trials, which are owed again, or no trial ended validly."""

BUDGET_REACHED = 3
"""The exit status if the budget ended a study before its last trial."""

_FIRST, _EVERY = 2.0, 60.0
"""Seconds until the first line about the state of an agent, and from one to the next, whether a trial ended or not."""

_LONG = 5.0
"""Seconds after which a call that has not come back is spoken of."""


def done_of(journal: Journal, study: Study | None = None) -> int:
    """The finished trials; with a study, those that it runs, without those of people."""
    return sum(
        not one.owed_again and (study is None or one.spec in study.run_agents) for one in journal.trials.values()
    )


def _begin_lines(study: Study, journal: Journal, owed: int) -> Iterator[str]:
    """What will be played, where it goes, and what of it is done."""
    run, done = study.size - study.invited, done_of(journal, study)
    if run:
        extent = f"{count(study.repetitions, 'repetition')} of {count(study.trials, 'trial')}"
        if study.until:
            most = count(study.repetitions * study.trials, "trial")
            extent = f"until {study.until}, at most {most} per condition, looking after every {LOOK_EVERY} blocks,"
        elif study.strategy_trials is not None:
            extent += f" ({study.strategy_trials} for strategies)"
        yield (
            f"Study {study.name} on {study.boxes_in_words}: {count(len(study.conditions), 'condition')}: "
            f"{'; '.join(one.label for one in study.conditions)}; {extent} of {study.max_steps} steps; "
            f"agents {', '.join(study.labels)}; seed {study.seed}"
        )
        if study.simulated:
            source = resolve_plant(study.plant)
            drawn = study.has_pictures and owed and source.picture_size is not None
            yield f"Plant: {study.plant}" + (f"; pictures by {source.renderer()}" if drawn else "")
        if reading := [study.label_of(one) for one in study.agents if study.modalities_of(one) != study.modalities]:
            yield f"Reports only, since they look at no pictures: {', '.join(reading)}"
    if study.invited:
        said = f"People: {done_of(journal) - done} of {count(study.invited, 'trial')} played; they are not run"
        yield f"{said} but invited, by lockprobe serve {journal.directory}"
    if run:
        yield f"Records: {journal.directory} (the same command resumes it)"
        yield settings_line(read_study(journal.directory).settings_hash)
        of = "" if study.until else f" of {run}"
        if done:
            yield f"{done}{of} trials are done already; {owed} are owed{' before the next look' * (not of)}"
        elif study.shard:
            yield f"{owed} of {replace(study, shard=None).size - study.invited} trials are played here"


class Progress(Observer):
    """Tells how a run goes, every news once: as lines for people, or as an event for programs.

    Args:
        study: The study. Where its plant asks questions at this terminal, no line covers them.
        journal: Where trials are written.
        json: Whether programs read it. What agents print then goes to standard error, so that every line is JSON.
        budget: The budget of the study.
        forks: Of forks, a function of how many are owed to what is said of them at the beginning; None of a study.

    Attributes:
        ended: Trials of this run that ended, over all agents.
        broken: Agents of which trials broke outside them in this run, each with their number.
        abandoned: Agents that could not go on -> why, and how many trials they owe.
    """

    def __init__(
        self,
        study: Study,
        journal: Journal,
        *,
        json: bool = False,
        budget: Budget | None = None,
        forks: Callable[[int], Sequence[str]] | None = None,
    ) -> None:
        self._study, self._journal = study, journal
        self.ended, self._first_error = 0, ""
        self.broken: Counter[str] = Counter()
        self.abandoned: dict[str, tuple[str, int]] = {}
        self._json, self._budget, self._forks = json, budget, forks
        self._out = sys.stdout
        self._ledger: Ledger | None = None
        self._agent = ""
        self._owed = self._before = self._played = self._steps = self._solved = self._valid = 0
        self._errors: Counter[str] = Counter()
        self._began = self._due = 0.0
        self._live: Live | None = None
        if sys.stdout.isatty() and not (json or study.attended):
            shown, console = lambda: Text(printable(self._agent and self.line())), Console(emoji=False, highlight=False)
            self._live = Live(get_renderable=shown, console=console, refresh_per_second=4)

    def watch(self, play: Callable[[], None]) -> BudgetReached | None:
        """Tell of what is played, and return what ended it early if the budget did; Ctrl-C is told and raised again."""
        try:
            with redirect_stdout(sys.stderr) if self._json else self._live or nullcontext():
                play()
        except KeyboardInterrupt:
            where, facts = str(self._journal.directory), {"finished": done_of(self._journal), **self.cost()}
            first = f"Stopped. Every finished trial is in {where}; run the same command again to go on."
            self.tell("interrupted", first, *self.spent(), directory=where, **facts)
            raise
        except BudgetReached as reached:
            return reached
        except AgentsGivenUp:
            if not self._journal.trials:  # nothing was played: the command cannot be carried out
                raise
        return None

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
        if hosted(study):
            self._ledger = Ledger(read_calls(journal.directory))
            journal.calls.listener = self.call
        if self._forks is not None:
            self.tell("begin", *self._forks(owed), directory=where, owed=owed)
            return
        facts = {"owed": owed, "done": done_of(journal, study), "settings": study.settings()}
        facts |= {"trials": study.size - study.invited, "settings_hash": read_study(journal.directory).settings_hash}
        self.tell("begin", *_begin_lines(study, journal, owed), directory=where, **facts)
        if not hosted(study):
            return
        found, limit = estimates(study, journal.trials), dict[str, float]()
        lines = [line for one in found for line in estimate_lines(one)]
        if self._budget is not None:
            spent, limit = self._budget.spent, {"budget": self._budget.allowed, "spent": self._budget.spent}
            before = f", of which {money(spent)} is spent" if spent else ""
            lasts = self._budget.allowed - spent >= sum((one.dollars() or (0.0, 0.0))[1] for one in found)
            doubt = "" if lasts else "; it may not last: the study then stops, and goes on with a larger one"
            lines.append(f"Budget: {money(self._budget.allowed)}{before}{doubt}")
        self.tell("estimate", *lines, agents=[estimate_facts(one) for one in found], **limit)

    def agent(self, source: AgentSource, owed: int) -> None:
        """Tell that an agent's turn comes; trials of an earlier run count, but not for the time that is left."""
        self._agent = self._study.label_of(source.spec)
        done = [trial for trial in self._journal.trials.values() if trial.agent == source.spec and not trial.owed_again]
        self._owed, self._before, self._played, self._steps = owed, len(done), 0, 0
        self._solved, self._valid = sum(one.solved for one in done), sum(one.ending != "error" for one in done)
        self._errors.clear()
        self._began = time.monotonic()
        self._due = self._began + _FIRST
        self.tell("agent", f"{self._agent}: {count(owed, 'trial')} to play", agent=self._agent, owed=owed)

    def step(self, key: str, step: Step) -> None:
        """Count a step."""
        self._steps += 1

    def trial(self, trial: Trial, seconds: float) -> None:
        """Count a trial; tell of it, and how it goes."""
        error, lines = trial.error, list[str]()
        self._played += 1
        self._valid += error is None
        self._solved += trial.solved
        if error is not None:
            self._errors[error.boundary] += 1
            lines.append(f"  {trial.key}  error at {error.boundary}: {error.message}")
        if error is not None and trial.owed_again:
            self.broken[trial.group] += 1
            self._first_error = self._first_error or f"{error.boundary}: {error.message}"
        else:
            self.ended += 1
        why = None if error is None else {"boundary": error.boundary, "message": error.message}
        facts = {"steps": len(trial.steps), "seconds": round(seconds, 3), "error": why, **self.cost()}
        self.tell("trial", *lines, key=trial.key, ending=trial.ending, **facts)
        self._say_state(now=self._played == self._owed and self._study.until is None)

    def call(self, call: Call) -> None:
        """A call is on disk; tell of one that was repeated, and how it goes if nothing has been said for long."""
        assert self._ledger is not None
        self._ledger.add(call)
        if call.retries or call.error:
            facts = {"step": call.step, "turn": call.turn, "retries": call.retries, "seconds": round(call.seconds, 3)}
            self.tell("call", key=call.key, **facts, error=call.error or None)
        self._say_state()

    def more(self, owed: int) -> None:
        """Count the trials that follow a look."""
        self._owed += owed

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
        seconds, left, waited = max(time.monotonic() - self._began, 1e-9), "…", self._journal.calls.longest_wait
        if self._played:
            needed = seconds / self._played * (self._owed - self._played)
            left = f"{needed / 60:.0f} min" if needed > 90 else f"{needed:.0f} s"
        way = f"{count(self._journal.calls.on_their_way, 'call')} on the way, the oldest for {waited:.0f} s"
        parts = [
            f"{self._agent}  {self._before + self._played}/{self._before + self._owed} trials",
            f"{self._solved} of {self._valid} solved" * bool(self._valid),
            f"{self._steps / seconds:.1f} steps/s",
            f"{left} left",
            spent_in_words(self._ledger.total) if self._ledger is not None else "",
            way * (waited >= _LONG),
            in_boundaries(self._errors),
        ]
        return " · ".join(filter(None, parts))

    def cost(self) -> dict[str, object]:
        """What it has cost, for programs."""
        return {} if self._ledger is None else {"spent": spent_facts(self._ledger.total)}

    def spent(self) -> list[str]:
        """What it has cost, as a line; none without a call."""
        said = "" if self._ledger is None else spent_in_words(self._ledger.total)
        return [f"All calls: {said}"] if said else []

    def end(self, reached: BudgetReached | None, owed: int, trials: int) -> int:
        """Tell what broke, which agents were given up, whether the budget is spent, and how to go on.

        Args:
            reached: What ended it early, if the budget did.
            owed: Trials that are owed.
            trials: Trials in all.

        Returns:
            The exit status.
        """
        broken, lines, mended = self.broken.total(), list[str](), "when that is mended"
        if broken:
            of = f"{broken} of {broken + self.ended} trials broke and are owed, of {', '.join(self.broken)}"
            lines.append(f"{of}; the first at {self._first_error}; the same command plays them again {mended}")
        if self.abandoned:
            said = "; ".join(f"{why} ({count(left, 'trial')} owed)" for why, left in self.abandoned.values())
            lines.append(f"Given up: {said}; nothing finished is lost, the same command goes on {mended}")
        if lines:
            given_up = {agent: {"owed": left, "why": why} for agent, (why, left) in self.abandoned.items()}
            facts = {"agents": dict(self.broken), "first": self._first_error, "given_up": given_up}
            self.tell("broke", *lines, trials=broken, ended=self.ended, **facts)
        if reached is None:
            return BROKE if owed or self.abandoned else 0
        spent = reached.spent if self._budget is None else self._budget.spent  # of the calls that came back since, too
        line = (
            f"Budget reached: {money(spent)} of {money(reached.budget)} spent, too little is left for a call; "
            f"{owed} of {trials} trials are owed; the same command with a larger --budget goes on"
        )
        money_of = {"spent": spent, "budget": reached.budget, "needed": reached.needed}
        self.tell("budget", line, **money_of, owed=owed, trials=trials)
        return BUDGET_REACHED
