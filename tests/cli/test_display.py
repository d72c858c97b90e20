"""A run as a live table."""

import io

from builders import call_of
from rich.console import Console

from lockprobe.agents.catalogue import resolve
from lockprobe.cli.display import LiveDisplay, watch
from lockprobe.cli.format_cost import money
from lockprobe.cli.progress import Plain
from lockprobe.foundation.errors import BudgetReached
from lockprobe.studies.costs.budget import Budget
from lockprobe.studies.costs.call_log import read_calls
from lockprobe.studies.costs.spending import Ledger
from lockprobe.studies.options.study_options import StudyOptions
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.records.journal import Journal
from lockprobe.trial.model_call import Usage
from lockprobe.trial.record import Decision, Step


def test_the_live_table_shows_what_was_spent(tmp_path):
    planned = study(StudyOptions(agent=["llm:openai/gpt-4o"], trials=1, p=[0], repetitions=1))
    shown = io.StringIO()
    with Journal.open(tmp_path, planned) as journal:
        display = LiveDisplay(Console(file=shown, width=200), budget=Budget(planned, 5))
        display.begin(planned, journal, 1)
        display.agent(resolve("llm:openai/gpt-4o"), 1)
        plan = next(planned.plans("llm:openai/gpt-4o"))
        usage = Usage(calls=1, input_tokens=1000, output_tokens=1000)
        journal.calls.write(call_of(plan, usage=usage, retries=2))
        display.interrupted(tmp_path)
    spent = Ledger(planned, read_calls(tmp_path)).total.dollars
    assert spent > 0
    assert f"${spent:.2g} spent, 2 retries" in shown.getvalue().split("Stopped.")[0]
    assert f"All calls: ${spent:.2g} spent, 2 retries" in shown.getvalue().split("Stopped.")[1]


def test_a_budget_counts_calls_of_unknown_cost_at_most(tmp_path, capsys):
    """The sum that counts against a budget and the sum of all calls may differ, and both lines say why."""
    planned = study(StudyOptions(agent=["llm:openai/gpt-4o"], trials=1, p=[0], repetitions=1))
    plan = next(planned.plans("llm:openai/gpt-4o"))
    with Journal.open(tmp_path, planned) as journal:
        plain = Plain()
        plain.begin(planned, journal, 1)
        usage = Usage(calls=1, input_tokens=1000, output_tokens=1000)
        journal.calls.write(call_of(plan, usage=usage))
        counted = plain.tally.ledger.total.dollars
        plain.stopped(BudgetReached(counted, 0.5, 0.4), 1, 1)
        plain.stopped(BudgetReached(counted + 0.1, 0.5, 0.4), 1, 1)
    exact, bound = (line for line in capsys.readouterr().out.splitlines() if line.startswith("Budget reached"))
    assert exact.startswith(f"Budget reached: {money(counted)} of $0.50 spent")
    assert bound.startswith(f"Budget reached: at most {money(counted + 0.1)} of $0.50 spent")


def test_who_works_the_plant_reads_no_reports(capsys):
    """A step would say what the agent was told."""
    step = Step(
        step=1,
        state="0",
        joint="a",
        moved=True,
        told_moved=False,
        told_state=None,
        told="",
        decision=Decision(joint="A"),
    )
    for attended, lines in ((False, 1), (True, 0)):
        with watch(json=False, attended=attended) as observer:
            observer.tally.slow = True
            observer.step("key", step)
        assert len(capsys.readouterr().out.splitlines()) == lines
