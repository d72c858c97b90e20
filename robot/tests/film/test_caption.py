"""The strip under the picture says truth beside told, and nothing that a model wrote."""

from dataclasses import replace

import numpy as np
from builders import make_trial
from lockprobe_robot.film.caption import WIDTH, CaptionLine, captioned, opening_lines, outcome_lines

PICTURE = np.full((420, WIDTH, 3), 90, np.uint8)


def texts(lines):
    return [line.text for line in lines]


def test_it_says_what_is_attempted_and_what_came_of_it():
    trial = make_trial([0, 3, 2], false_at=[2], claims=[None, "blocked", "moved"], hypothesis="HIDDEN", budget=3)
    assert texts(opening_lines(trial)) == [
        "random on chain-4, symbolic?tell=state, trial 1.1",
        "Target: A (revolute-left); 3 steps",
    ]
    told = [outcome_lines(trial, at) for at in range(3)]
    assert texts(told[0]) == [
        "Step 1 of 3: A (revolute-left)", "truth blocked, told blocked", "the agent then says blocked",
    ]  # fmt: skip
    assert texts(told[1])[1:] == ["truth moved, told blocked", "the agent then says moved"]
    assert texts(told[2])[1:] == ["truth moved, told moved", ""]
    assert [[line.alarming for line in lines] for lines in told] == [
        [False, False, False], [False, True, False], [False, False, False],
    ]  # fmt: skip


def test_a_claim_and_a_verdict_that_are_wrong_are_marked():
    trial = make_trial([0, 3], claims=[None, "moved"])
    assert outcome_lines(trial, 0)[2] == CaptionLine("the agent then says moved", alarming=True)
    robot = replace(trial.steps[0], sensed={"verdict": "moved", "peak_force": 3.0})
    seen = outcome_lines(replace(trial, steps=(robot, trial.steps[1])), 0)
    assert seen[1] == CaptionLine("truth blocked, told blocked, robot says moved at 3 N", alarming=True)
    shown = replace(trial.steps[0], pictures={"rgb": f"{'0' * 20}.png"})
    assert outcome_lines(replace(trial, steps=(shown,)), 0)[1] == CaptionLine("truth blocked")
    false = replace(shown, told_moved=True)
    assert outcome_lines(replace(trial, steps=(false,)), 0)[1] == CaptionLine(
        "truth blocked, told moved", alarming=True
    )
    odd = replace(trial.steps[0], sensed={"verdict": "<anything else>"})
    assert outcome_lines(replace(trial, steps=(odd,)), 0)[1].text == "truth blocked, told blocked"


def test_the_end_is_said():
    assert outcome_lines(make_trial([3, 2, 1, 0]), 3)[2].text == "solved"


def test_a_picture_of_any_size_gets_a_strip():
    for height, width in ((360, 480), (480, 640), (64, 80), (48, 200)):
        film = captioned(np.zeros((height, width, 3), np.uint8), [CaptionLine("a" * 200)], corner="4x")
        assert film.shape[1] == WIDTH
        assert film.shape[0] % 2 == 0
        assert film.dtype == np.uint8
        strip = film[-90:]
        assert (strip[:, -4:] > 200).all()  # text ends before the edge
        assert strip.min() < 80


def test_words_are_drawn_and_alarms_are_red():
    plain, alarmed = (
        captioned(PICTURE, [CaptionLine("truth"), CaptionLine("told", alarming=alarm)]) for alarm in (False, True)
    )
    assert (plain[:420] == PICTURE).all()
    assert (plain[:450] == alarmed[:450]).all()
    differs = alarmed[450:][(alarmed != plain)[450:].any(axis=-1)]
    assert len(differs) > 20
    assert (differs[:, 0] >= differs[:, 1]).all()
