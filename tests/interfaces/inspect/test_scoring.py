"""Scores are those that the trial deserves; what broke has none."""

import math

import pytest
from builders import SOLUTION, make_trial, small_study

scoring = pytest.importorskip("lockprobe.interfaces.inspect.scoring")

from lockprobe.trial.trial_json import trial_from_json  # noqa: E402


def test_a_trial_that_opened_the_box_by_hand():
    trial = make_trial(SOLUTION, claims=[None, "moved", "blocked", "moved"])
    score = scoring.score_of(trial)
    assert score.value == {
        "success": 1,
        "steps": 4,
        "loop": 0,
        "loop_chance": 0.0,
        "misinterpretation": pytest.approx(1 / 3),
    }
    assert score.answer == "opened in 4 steps"
    assert trial_from_json(score.metadata["trial"]) == trial


def test_a_trial_that_ran_out_took_its_whole_budget_and_may_loop():
    score = scoring.score_of(make_trial([0, 1, 2, 0, 1, 2], budget=6))
    assert (score.value["success"], score.value["steps"], score.value["loop"]) == (0, 6, 1)
    assert score.value["loop_chance"] == 4**-3  # the second half has to be the first
    assert math.isnan(score.value["misinterpretation"])  # it was never asked


@pytest.mark.parametrize("steps", [[], [3, 2]])
@pytest.mark.parametrize(
    ("boundary", "reason"), [("reply", "invalid_response_format"), ("model", "model"), ("plant", "plant")]
)
def test_a_broken_trial_is_unscored_and_still_on_record(boundary, reason, steps):
    trial = make_trial(steps, broken=boundary)
    score = scoring.score_of(trial)
    assert math.isnan(score.value)
    assert score.reason == reason
    assert trial_from_json(score.metadata["trial"]) == trial


def test_the_table_sets_truth_beside_told_beside_said():
    trial = make_trial([3, 0], budget=2, false_at=[2], claims=[None, "blocked"], hypothesis="a | b\nc")
    lines = scoring.trial_as_markdown(trial).splitlines()
    assert lines[0] == "Not opened in 2 steps. The target is **A** (revolute-left)."
    assert lines[4:] == [
        "| 1 | D (revolute-right) | moved | moved | **did not move** (misread) | 0000 | a \\| b c |",
        "| 2 | A (revolute-left) | did not move | **moved** (false report) |  | 0001 | a \\| b c |",
    ]


def test_the_transcript_and_the_messages_say_the_same():
    (step,) = make_trial([0], budget=1, false_at=[1]).steps
    assert (
        scoring.step_as_markdown(step)
        == "Step 1: A (revolute-left). True: did not move. Told: **moved** (false report)."
    )
    assert scoring.step_metadata(step) == {
        "step": 1,
        "attempted": "A (revolute-left)",
        "true": "did not move",
        "told": "moved (false report)",
    }


@pytest.mark.parametrize(("repetitions", "cluster"), [(2, "repetition"), (1, "trial")])
def test_standard_errors_are_clustered_by_what_shares_luck(repetitions, cluster):
    study = small_study(repetitions=repetitions)
    header = scoring.metrics_header(study)
    assert list(header) == list(scoring.metrics_of(study)) == list(scoring.VALUES)
    for value, makers in scoring.metrics_of(study).items():
        assert len(header[value]) == len(makers)
        assert header[value][1] == {"name": "inspect_ai/stderr", "options": {"cluster": cluster}}
