"""Nothing finished is lost, nothing is repeated, whenever the process dies."""

import zlib
from dataclasses import replace

import pytest
from builders import call_of, make_trial, small_study
from stored import sql, timings

from lockprobe.foundation.errors import BadFile, SettingsChanged
from lockprobe.interventions.conditions import flips
from lockprobe.studies.costs.call_log import read_calls
from lockprobe.studies.options.study_options import StudyOptions
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.records.directory import read_study
from lockprobe.studies.records.journal import Journal
from lockprobe.studies.records.read_records import load, replaced_records
from lockprobe.studies.running.runner import run

STUDY = study(StudyOptions(agent=["random"], trials=3, repetitions=2, p=[0, 0.4]))
PLANS = list(STUDY.plans("random"))


def resume(directory):
    with Journal.open(directory, STUDY) as journal:
        owed = [plan.key for plan in STUDY.plans("random") if journal.owes(plan.key)]
        run(STUDY, journal)
    return owed


def test_settings_cannot_change_once_somebody_has_joined(tmp_path):
    people = study(StudyOptions(agent=["participant"], trials=4, p=[0]))
    with Journal.open(tmp_path, people):
        pass
    sql(tmp_path, "insert into act values (1, 'aaaa01', 1, '{}', 0)")
    with (
        pytest.raises(SettingsChanged, match=r"\(conditions is 'truth' there, 'flip\?p=0.4' asked\)"),
        Journal.open(tmp_path, replace(people, agents=("random",), conditions=flips((0.4,)))),
    ):
        pass
    with Journal.open(tmp_path, replace(people, agents=("random",))):
        pass
    assert read_study(tmp_path).agents == ("random", "participant")


def test_settings_cannot_change_once_a_call_was_paid_for(tmp_path):
    call = call_of(PLANS[0])
    with Journal.open(tmp_path, STUDY) as journal:
        journal.calls.write(call)
    with (
        pytest.raises(SettingsChanged, match="trials is 3 there, 4 asked"),
        Journal.open(tmp_path, study(StudyOptions(agent=["random"], trials=4, repetitions=2, p=[0, 0.4]))),
    ):
        pass
    assert list(read_calls(tmp_path)) == [call]
    (tmp_path / "study.json").unlink()
    with pytest.raises(BadFile, match=r"holds study.db but no study.json: put it back, or give another --out"):
        resume(tmp_path)


INVITING = small_study(["participant", "random"], trials=3)
ANN, BOB = "participant:aaaa", "participant:bbbb"


def journal_of(directory, *trials):
    with Journal.open(directory, INVITING) as journal:
        for seconds, trial in enumerate(trials, 1):
            journal.append(trial, float(seconds))
    return directory


def trial(agent, number, **more):
    """One of people's trials: its key is the same whoever plays it."""
    return make_trial([0, 1, 2], agent=agent, trial=number, budget=3, **more)


@pytest.mark.parametrize(
    ("gone", "seconds"),
    [(ANN, [3.0, 4.0, 5.0]), (BOB, [1.0, 2.0, 4.0, 6.0]), ("participant:cccc", [3.0, 4.0, 5.0, 6.0])],
)
def test_who_withdraws_is_gone_and_what_others_played_of_the_same_trial_counts(tmp_path, gone, seconds):
    """The times say which record: the first two trials broke with ANN before BOB played them."""
    played = [
        trial(ANN, 1, broken="plant"), trial(ANN, 2, broken="plant"), trial(BOB, 1), trial("random", 1), trial(BOB, 2),
        trial(ANN, 3),
    ]  # fmt: skip
    journal_of(tmp_path, *played)
    with Journal.open(tmp_path, INVITING) as journal:
        journal.delete_participant(gone)
        journal.erase()
        assert {one.agent for one in journal.trials.values()} <= {ANN, BOB, "random"} - {gone}
        assert journal.owes(trial(ANN, 3).key) == (gone == ANN)
        if gone == BOB:  # while the server runs: the records that broke before count again, and somebody plays on
            journal.append(trial("participant:eeee", 1), 8.0)
            journal.delete_participant("participant:eeee")
    assert [timing.seconds for timing in timings(tmp_path)] == seconds
    assert gone not in {one.agent for one in (*load(tmp_path), *replaced_records(tmp_path))}
    assert gone.encode() not in b"".join(map(zlib.decompress, sql(tmp_path, "select record from trial")))
    with Journal.open(tmp_path, INVITING) as journal:
        journal.append(trial("participant:dddd", 3), 9.0)
    assert load(tmp_path)[-1].agent == "participant:dddd"
