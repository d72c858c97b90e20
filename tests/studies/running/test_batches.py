"""Strategies on several processes: the records of one process, whatever happens to the others."""

from multiprocessing import active_children

import pytest
from builders import small_study
from stored import sql

from lockprobe.studies.records.journal import Journal
from lockprobe.studies.records.trial_rows import COLUMNS, TrialRow, row_of
from lockprobe.studies.running import batches
from lockprobe.studies.running.batches import play_in_batches

STUDY = small_study(["human-inspired"], trials=20)
PLANS = list(STUDY.plans("human-inspired"))
IDENTITIES = {one.label: STUDY.record_identity(one) for one in STUDY.conditions}


def untimed(row):
    return row._replace(seconds=0.0, cpu="")


def made_here(trial, timing):
    return untimed(row_of(trial, timing, IDENTITIES[trial.condition]))


def played(finish, on_step=lambda key, step: None):
    play_in_batches(PLANS, 2, on_step, finish, IDENTITIES)


@pytest.fixture(scope="module")
def alone():
    """The rows of the trials, played in this process."""
    rows = []

    def finish(trial, timing, row=None):
        assert row is None
        rows.append(made_here(trial, timing))

    played(finish)
    assert len(rows) == len(PLANS)
    return rows


@pytest.fixture
def elsewhere(monkeypatch):
    """Other processes play all but the first trial, seven at once."""
    monkeypatch.setattr(batches, "_ALONE", 0.0)
    monkeypatch.setattr(batches, "_BATCH", 7)


def test_other_processes_write_the_same_rows_in_the_same_order(alone, elsewhere):
    rows, made, steps = [], [], []

    def finish(trial, timing, row=None):
        made.append(row is not None)
        assert (timing.key, timing.steps) == (trial.key, len(trial.steps))
        assert steps[-timing.steps :] == [(trial.key, step.step) for step in trial.steps]
        rows.append(untimed(row) if row else made_here(trial, timing))

    played(finish, lambda key, step: steps.append((key, step.step)))
    assert rows == alone
    assert made == [False] + [True] * (len(PLANS) - 1)
    assert not active_children()


def test_what_a_process_had_taken_when_it_died_is_played_by_this_one(alone, elsewhere):
    rows = []

    def finish(trial, timing, row=None):
        rows.append(made_here(trial, timing))
        if len(rows) == 9:
            for process in active_children():
                process.kill()

    played(finish)
    assert rows == alone


def test_an_interrupt_ends_the_other_processes(elsewhere):
    finished = []

    def finish(trial, timing, row=None):
        finished.append(trial.key)
        if len(finished) == 10:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        played(finish)
    assert finished == [plan.key for plan in PLANS[:10]]
    assert not active_children()


def test_a_journal_takes_a_row_as_it_is(tmp_path, alone):
    with Journal.open(tmp_path, STUDY) as journal:
        made = []

        def finish(trial, timing, row=None):
            made.append(trial)
            journal.append(trial, timing, alone[len(made) - 1])

        played(finish)
    stored = [TrialRow(*row) for row in sql(tmp_path, f"select {COLUMNS} from trial order by id")]
    assert stored == alone
