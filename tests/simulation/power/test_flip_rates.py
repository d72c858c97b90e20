"""A stated effect is simulated, and every question that it answers with yes is asked of the tests of the report."""

import pytest

from lockprobe.foundation.errors import BadValue
from lockprobe.simulation.power.flip_rates import default_worlds, flip_power, stated_world
from lockprobe.simulation.power.simulator import Simulation

P2 = (0.0, 0.4)


def test_the_papers_effect_needs_about_nineteen_trials_a_condition():
    """By 600 studies it is 15 to 27; these 48 studies, on coarser rungs, are within 11 to 34."""
    (_, question, found), _ = flip_power(
        [stated_world((7 / 30, 20 / 30), p=P2)], Simulation(trials=(12, 24, 48), studies=16)
    )
    assert question == "success"
    assert 11 <= found.trials <= 34
    assert [rate.trials for rate in found.measured] == [12, 24, 48]
    assert found.measured[0].power < found.measured[2].power


@pytest.mark.parametrize(
    ("effect", "questions"),
    [
        ({"success": (0.2, 0.6, 0.4), "p": (0.0, 0.3, 0.6)}, ["success", "speed", "shape"]),
        ({"success": (0.5, 0.5), "p": P2, "trap": (0.4, 0.1)}, ["looping"]),
        ({"success": (0.5, 0.5), "p": P2, "trap": (0.0, 0.4)}, ["looping"]),
        ({"success": (0.5,) * 3, "p": (0.0, 0.3, 0.6), "trap": (0.4, 0.1, 0.4)}, ["looping", "looping again"]),
        ({"success": (0.5, 0.5), "p": P2}, []),
    ],
)
def test_only_questions_with_a_yes_are_answered(effect, questions):
    assert [one for _, one, _ in flip_power([stated_world(**effect)], Simulation(trials=(9,), studies=1))] == questions


def test_by_default_there_are_two_effects():
    found = flip_power(default_worlds(), Simulation(trials=(9,), studies=1))
    assert [(world.name, question) for world, question, _ in found] == [
        *(("loops-irrelevant", one) for one in ("success", "speed", "shape")),
        ("loop-trapped", "looping"),
    ]


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"success": (0.5,)}, "one share for each of 7 flip rates"),
        ({"success": (0.5, 1.0), "p": P2}, "success: got 1.0"),
        ({"success": (0.5, 0.6), "p": (0.4, 0.0)}, "ascending"),
        ({"success": (0.5, 0.6), "p": (0.5, 0.500000001)}, "0.500000001', expected values that differ by 0.000001"),
        ({"success": (0.5, 0.6, 0.5), "p": (0.0, 1e-300, 0.5)}, "differ by 0.000001"),
        ({"success": (0.5, 0.6), "p": P2, "trap": (0.1,)}, "one chance for each of 2 flip rates"),
        ({"success": (0.5, 0.6), "p": P2, "trap": (0.1, 1.1)}, "trap: got 1.1"),
        ({"success": (0.5, float("nan")), "p": P2}, "success: got nan"),
    ],
)
def test_impossible_effects_are_refused(settings, message):
    with pytest.raises(BadValue, match=message):
        stated_world(**settings)
