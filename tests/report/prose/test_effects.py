"""Sentences on effects and interactions of conditions: detected, not detected, and not estimated."""

from types import SimpleNamespace

import pytest
from builders import SOLUTION, make_trial

from lockprobe.interventions.conditions import read_condition
from lockprobe.report.prose.effects import effects_said, grid_said
from lockprobe.statistics.conditions.dose_grid import grid_summary, grids
from lockprobe.statistics.conditions.effects import effects
from lockprobe.statistics.conditions.series import Crossing
from lockprobe.statistics.outcomes import outcomes
from lockprobe.statistics.proportions import proportion
from lockprobe.studies.study_design import arms_of

NAMES = ("truth", "nudge", "warn", "nudge + warn")
CROSSING = Crossing(neither="truth", first="nudge", second="warn", both="nudge + warn")


def trials(solved, trial=0):
    """Forty trials, the first so many solved; ``trial`` is added to their numbers, so that they share no luck."""
    return [make_trial(SOLUTION if i < solved else (0,) * 20, trial=i + 1 + trial) for i in range(40)]


def sentences(*solved):
    found = effects(dict(zip(NAMES, map(trials, solved), strict=True)), "truth", [CROSSING])
    share = SimpleNamespace(success=proportion(solved[0], 40))
    return effects_said(found, {(found.agent, "truth"): share})


def test_every_effect_is_told_and_the_control_stands_beside():
    more, less, share, hidden, corrected, _ = sentences(20, 36, 4, 21)
    assert "solved the box more often under nudge (+40 points" in more
    assert "solved the box less often under warn (\N{MINUS SIGN}40 points" in less
    assert share.endswith("solved 20 of 40 trials (50 %) under truth.")
    assert hidden.startswith("No difference from truth was detected for random under nudge + warn (")
    assert "corrected for comparing 3 conditions with truth" in corrected


@pytest.mark.parametrize(
    ("solved", "said"),
    [
        ((4, 4, 4, 36), "The effect of warn depends on nudge (interaction +80 points"),
        ((4, 8, 8, 12), "No interaction between nudge and warn was detected (0 points"),
    ],
)
def test_an_interaction_of_two_interventions(solved, said):
    assert sentences(*solved)[-1].startswith(said)


def summary(apart=False, **solved):
    """Of flip rates 0 and 0.4 crossed with tremble rates 0 and 0.1; those that are named were played."""
    specs = {"neither": "truth", "flip": "flip?p=0.4", "tremble": "tremble?p=0.1", "both": "flip?p=0.4 + tremble?p=0.1"}
    arms = arms_of(read_condition(spec) for spec in specs.values())
    (grid,) = grids(arms)
    played = {specs[name]: outcomes(trials(count, 100 * i * apart)) for i, (name, count) in enumerate(solved.items())}
    return grid_summary(grid, played)


def test_an_interaction_of_two_doses():
    found = summary(neither=4, flip=4, tremble=4, both=36)
    said = grid_said(found)
    assert said.startswith(
        "The effect of tremble p depends on flip rate: the effect of tremble p (0 to 0.1) at flip rate"
    )
    assert "0.4 minus that at flip rate 0 is +80 points (95 % interval " in said
    assert grid_said(summary(neither=4, flip=8, tremble=8, both=12)).startswith("No interaction between flip rate and ")


def test_an_interaction_that_cannot_be_estimated_says_why():
    said = "The interaction between flip rate and tremble p is not estimated: "
    assert grid_said(summary(apart=True, neither=4, flip=4, tremble=4, both=4)) == (
        f"{said}no trial has ended under every combination."
    )
