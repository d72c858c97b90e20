"""The named interlocks are what the literature says, and as hard as was computed for it."""

import pytest

from lockprobe.boxes.families import box, named_boxes
from lockprobe.boxes.solve import optimum, random_no_repeat_success, random_success
from lockprobe.boxes.state_space import fault_of
from lockprobe.boxes.structures import FAMILIES, STRUCTURES


@pytest.mark.parametrize(
    ("name", "steps", "random", "no_repeat"),
    [
        ("chain-4", 4, 0.39, 0.69),
        ("bichain-4", 4, 0.33, 0.55),
        ("fork", 3, 0.56, 0.73),
        ("converge", 4, 0.38, 0.64),
        ("reset", 5, 0.23, 0.48),
        ("gray-code", 8, 0.02, 0.09),
    ],
)
def test_the_candidate_structures_are_as_hard_as_published(name, steps, random, no_repeat):
    assert optimum(box(name)) == steps
    assert round(random_success(box(name)), 2) == random
    assert round(random_no_repeat_success(box(name)), 2) == no_repeat


def test_chain_4_is_byte_for_byte_what_studies_were_played_on():
    assert box("chain-4").as_data() == {
        "name": "chain-4",
        "joints": [
            {"name": "revolute-left", "kind": "revolute", "place": [0.125, 0.5]},
            {"name": "slider-1", "kind": "prismatic", "place": [0.375, 0.5]},
            {"name": "slider-2", "kind": "prismatic", "place": [0.625, 0.5]},
            {"name": "revolute-right", "kind": "revolute", "place": [0.875, 0.5]},
        ],
        "interlock": {
            "revolute-left": [{"slider-1": 1}],
            "slider-1": [{"slider-2": 1}],
            "slider-2": [{"revolute-right": 1}],
        },
        "initial": "0000",
        "target": "revolute-left",
    }


@pytest.mark.parametrize("name", named_boxes())
def test_every_named_box_can_be_played_and_is_described(name):
    assert fault_of(box(name), shortest=2) is None
    assert any(name == family or name.startswith(f"{family}-") for family in FAMILIES)
    assert STRUCTURES[name]() == STRUCTURES[name]()
