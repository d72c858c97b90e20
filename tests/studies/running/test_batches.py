"""Strategies on several processes: the records of one process, whatever happens to the others."""

from multiprocessing import active_children

import pytest
from builders import small_study

from lockprobe.studies.records.journal import Journal
from lockprobe.studies.running import batches
from lockprobe.studies.running.batches import play_in_batches
from lockprobe.trial.trial_json import trial_to_line

STUDY = small_study(["human-inspired"], trials=20)
PLANS = list(STUDY.plans("human-inspired"))
IDENTITIES = {one.label: STUDY.record_identity(one) for one in STUDY.conditions}


def played(finish, on_step=lambda key, step: None):
    play_in_batches(PLANS, 2, on_step, finish, IDENTITIES)


@pytest.fixture(scope="module")
def alone():
    """The lines of the trials, played in this process, and where each was made."""
    lines = []

    def finish(trial, timing, line=b""):
        assert not line
        lines.append(trial_to_line(trial, IDENTITIES[trial.condition]))

    played(finish)
    assert len(lines) == len(PLANS)
    return lines


@pytest.fixture
def elsewhere(monkeypatch):
    """Other processes play all but the first trial, seven at once."""
    monkeypatch.setattr(batches, "_ALONE", 0.0)
    monkeypatch.setattr(batches, "_BATCH", 7)


def test_other_processes_write_the_same_lines_in_the_same_order(alone, elsewhere):
    lines, made, steps = [], [], []

    def finish(trial, timing, line=b""):
        made.append(bool(line))
        assert (timing.key, timing.steps) == (trial.key, len(trial.steps))
        assert steps[-timing.steps :] == [(trial.key, step.step) for step in trial.steps]
        lines.append(line or trial_to_line(trial, IDENTITIES[trial.condition]))

    played(finish, lambda key, step: steps.append((key, step.step)))
    assert lines == alone
    assert made == [False] + [True] * (len(PLANS) - 1)
    assert not active_children()


def test_what_a_process_had_taken_when_it_died_is_played_by_this_one(alone, elsewhere):
    lines = []

    def finish(trial, timing, line=b""):
        lines.append(trial_to_line(trial, IDENTITIES[trial.condition]))
        if len(lines) == 9:
            for process in active_children():
                process.kill()

    played(finish)
    assert lines == alone


def test_an_interrupt_ends_the_other_processes(elsewhere):
    finished = []

    def finish(trial, timing, line=b""):
        finished.append(trial.key)
        if len(finished) == 10:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        played(finish)
    assert finished == [plan.key for plan in PLANS[:10]]
    assert not active_children()


def test_a_journal_takes_a_line_as_it_is_and_counts_replays(tmp_path, alone):
    with Journal.open(tmp_path, STUDY) as journal:
        made = []

        def finish(trial, timing, line=b""):
            made.append(trial)
            journal.append(trial, timing, alone[len(made) - 1])

        played(finish)
    assert (tmp_path / "trials.jsonl").read_bytes().splitlines() == alone
