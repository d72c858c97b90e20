"""How a run goes: what is counted, what people read in lines or in a live table, and what programs read."""

import io
import json

import pytest
from builders import SOLUTION, call_of, make_trial, write_study
from rich.console import Console

from lockprobe.agents.catalogue import resolve
from lockprobe.cli.format_cost import money
from lockprobe.cli.live_table import LiveTable
from lockprobe.cli.progress import Progress, watch
from lockprobe.cli.server_marks import ENOUGH
from lockprobe.cli.tally import Tally
from lockprobe.foundation.errors import BudgetReached
from lockprobe.studies.costs.budget import Budget
from lockprobe.studies.costs.call_log import Calls, read_calls
from lockprobe.studies.costs.spending import Ledger
from lockprobe.studies.options.study_options import StudyOptions
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.records.journal import Journal
from lockprobe.studies.records.store import written
from lockprobe.trial.model_call import Usage
from lockprobe.trial.record import Decision, Step

MODEL = "llm:openai/gpt-4o"
ONE = study(StudyOptions(agent=[MODEL], trials=1, p=[0], repetitions=1))
USED = Usage(calls=1, input_tokens=1000, output_tokens=1000)


@pytest.fixture
def clock(monkeypatch):
    now = [0.0]
    for module in ("cli.tally", "studies.costs.call_log"):
        monkeypatch.setattr(f"lockprobe.{module}.time.monotonic", lambda: now[0])
    return now


def test_trials_are_counted_under_all_conditions_together():
    tally = Tally(study(StudyOptions(study="modalities", modality=["rgb", "rgbd"], agent=["viewer"])))
    tally.turn(resolve("viewer"), 4, [])
    tally.trial(make_trial([0], agent="viewer", modality="rgb", study="modalities", broken="plant"))
    assert "solved" not in tally.line()
    assert tally.line().endswith("1 error: plant 1")
    tally.turn(resolve("viewer"), 4, [])
    for modality, joints in (("rgb", SOLUTION), ("rgb", [0] * 20), ("rgbd", SOLUTION)):
        tally.trial(make_trial(joints, agent="viewer", modality=modality, study="modalities"))
    assert "3/4 trials · 2 of 3 solved" in tally.line()


def test_after_a_resume_trials_are_of_the_study_and_the_time_left_is_of_this_run(clock):
    tally = Tally()
    tally.turn(resolve("random"), 3, [make_trial(SOLUTION, trial=n) for n in range(1, 53)])
    assert tally.line().startswith("random  52/55 trials · 52 of 52 solved")
    assert "… left" in tally.line()
    clock[0] = 20.0
    tally.trial(make_trial(SOLUTION, trial=53))
    assert tally.line().startswith("random  53/55 trials · 53 of 53 solved")
    assert "40 s left" in tally.line()


def test_a_provider_that_makes_us_wait_is_spoken_of(tmp_path, clock):
    tally = Tally()
    with written(tmp_path) as store, Calls.open(store) as tally.calls:
        with pytest.raises(StopIteration):
            tally.calls.reserve(call_of(make_trial([0]))).send(None)
        assert "on the way" not in tally.line()
        clock[0] = 42.0
        assert "1 call on the way, the oldest for 42 s" in tally.line()


def test_a_live_table_shows_what_was_spent_and_says_above_it_what_is_wrong(tmp_path):
    shown = io.StringIO()
    with Journal.open(tmp_path, ONE) as journal:
        table = LiveTable(Console(file=shown, width=200), budget=Budget(ONE, 5))
        with table.played():
            table.begin(ONE, journal, 1)
            table.agent(resolve(MODEL), 1)
            for step in range(1, ENOUGH + 1):
                reply = 'Hm</think>{"joint": "A"}'
                journal.calls.write(call_of(next(ONE.plans(MODEL)), step, reply=reply, usage=USED, retries=2))
        table.interrupted(tmp_path)
    spent = f"${Ledger(ONE, read_calls(tmp_path)).total.dollars:.2g} spent, {2 * ENOUGH} retries"
    during, after = shown.getvalue().split("Stopped.")
    assert spent in during
    assert f"All calls: {spent}" in after
    assert during.count("every reply so far holds marks") == 1


def test_a_budget_counts_calls_of_unknown_cost_at_most(tmp_path, capsys):
    """The sum that counts against a budget and the sum of all calls may differ, and both lines say why."""
    with Journal.open(tmp_path, ONE) as journal:
        progress = Progress()
        progress.begin(ONE, journal, 1)
        journal.calls.write(call_of(next(ONE.plans(MODEL)), usage=USED))
        counted = progress.tally.ledger.total.dollars
        progress.stopped(BudgetReached(counted, 0.5, 0.4), 1, 1)
        progress.stopped(BudgetReached(counted + 0.1, 0.5, 0.4), 1, 1)
    exact, bound = (line for line in capsys.readouterr().out.splitlines() if line.startswith("Budget reached"))
    assert exact.startswith(f"Budget reached: {money(counted)} of $0.50 spent")
    assert bound.startswith(f"Budget reached: at most {money(counted + 0.1)} of $0.50 spent")


def test_who_works_the_plant_reads_no_reports(capsys):
    """A step would say what the agent was told."""
    step = Step(
        step=1, state="0", joint="a", moved=True, told_moved=False, told_state=None, told="", decision=Decision(joint="A")
    )  # fmt: skip
    for attended, lines in ((False, 1), (True, 0)):
        progress = watch(json=False, attended=attended)
        progress.tally.slow = True
        progress.step("key", step)
        assert len(capsys.readouterr().out.splitlines()) == lines


def test_trials_of_people_are_not_among_those_that_a_run_has_done(tmp_path, capsys):
    mixed = study(StudyOptions(agent=["participant", "random"], box="chain-4", trials=2, p=[0], repetitions=1))
    played = [make_trial(SOLUTION, trial=1), make_trial(SOLUTION, agent="participant:aaaa", trial=1)]
    with Journal.open(write_study(tmp_path / "s", mixed, played), mixed) as journal:
        Progress().begin(mixed, journal, 1)
        assert "1 of 2 trials are done already; 1 are owed" in capsys.readouterr().out
        Progress(json=True).begin(mixed, journal, 1)
    begun = json.loads(capsys.readouterr().out)
    assert (begun["trials"], begun["done"], begun["owed"]) == (2, 1, 1)
