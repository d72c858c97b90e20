"""What a run counts while it goes on, in one line."""

import pytest
from builders import SOLUTION, call_of, make_trial

from lockprobe.agents.catalogue import resolve
from lockprobe.cli.tally import Tally, in_boundaries
from lockprobe.studies.costs.call_log import Calls
from lockprobe.studies.costs.spending import Ledger
from lockprobe.studies.options.study_options import StudyOptions
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.records.store import written
from lockprobe.trial.model_call import Usage


def test_trials_are_counted_under_all_conditions_together():
    tally = Tally(study(StudyOptions(study="modalities", modality=["rgb", "rgbd"], agent=["viewer"])))
    tally.turn(resolve("viewer"), 4, [], slow=True)
    assert "solved" not in tally.line()
    tally.trial(make_trial([0], agent="viewer", modality="rgb", study="modalities", broken="plant"))
    assert "solved" not in tally.line()
    tally.turn(resolve("viewer"), 4, [], slow=True)
    for modality, joints in (("rgb", SOLUTION), ("rgb", [0] * 20), ("rgbd", SOLUTION)):
        tally.trial(make_trial(joints, agent="viewer", modality=modality, study="modalities"))
    assert "3/4 trials · 2 of 3 solved" in tally.line()
    tally = Tally(study(StudyOptions(agent=["random"])))
    tally.turn(resolve("random"), 1, [make_trial(SOLUTION, p=0.4)], slow=False)
    assert "1/2 trials · 1 of 1 solved" in tally.line()


def test_after_a_resume_trials_are_of_the_study_and_the_time_left_is_of_this_run(monkeypatch):
    now = [0.0]
    monkeypatch.setattr("lockprobe.cli.tally.time.monotonic", lambda: now[0])
    tally = Tally()
    tally.turn(resolve("random"), 3, [make_trial(SOLUTION, trial=n) for n in range(1, 53)], slow=True)
    assert tally.line().startswith("random  52/55 trials · 52 of 52 solved")
    assert "… left" in tally.line()
    now[0] = 20.0
    tally.trial(make_trial(SOLUTION, trial=53))
    assert tally.line().startswith("random  53/55 trials · 53 of 53 solved")
    assert "40 s left" in tally.line()


def test_errors_are_counted_by_boundary():
    assert in_boundaries({"reply": 1, "model": 2}) == "3 errors: model 2, reply 1"
    assert in_boundaries({"plant": 1}) == "1 error: plant 1"
    assert in_boundaries({}) == ""


def test_a_provider_that_makes_us_wait_is_spoken_of(tmp_path, monkeypatch):
    now = [0.0]
    monkeypatch.setattr("lockprobe.studies.costs.call_log.time.monotonic", lambda: now[0])
    tally = Tally()
    tally.turn(resolve("random"), 1, [], slow=True)
    with written(tmp_path) as store, Calls.open(store) as tally.calls:
        with pytest.raises(StopIteration):
            tally.calls.reserve(call_of(make_trial([0]))).send(None)
        assert "on the way" not in tally.line()
        now[0] = 42.0
        assert "1 call on the way, the oldest for 42 s" in tally.line()


def test_the_line_says_what_was_spent_in_money_or_in_tokens():
    for spec, said in (("llm:openai/gpt-4o", "$"), ("llm:openai-api/fake/model", "2,000,000 tokens in, 500 out")):
        tally = Tally()
        tally.turn(resolve(spec), 2, [], slow=True)
        assert "spent" not in tally.line()
        tally.ledger = Ledger(study(StudyOptions(agent=[spec])))
        assert "spent" not in tally.line()
        usage = Usage(calls=1, input_tokens=2_000_000, output_tokens=500)
        trial = make_trial([0], agent=spec)
        tally.ledger.add(call_of(trial, usage=usage))
        tally.ledger.add(call_of(trial, step=2, reply=None, error="500", retries=6))
        assert said.replace("2,000,000", "2 million") in tally.line()
        assert "6 retries, 1 calls failed".replace("1 calls", "1 call") in tally.line()
