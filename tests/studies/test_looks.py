"""The study ``looks``: sixteen scenes of eight factors, each at either level in half of them."""

from itertools import combinations

import numpy as np
import pytest

from lockprobe.foundation.errors import BadValue
from lockprobe.studies.options.studyfile import study

FACTORS = {
    "discs": "no", "handle_colours": "plain", "labels": "no", "clutter": "8", "light": "side", "colours": "second",
    "viewpoint": "oblique", "view_jitter": "5",
}  # fmt: skip


def test_its_scenes_are_a_factorial_design_of_all_factors_and_each_has_its_contrast():
    """No factor is mixed with another, or with an interaction of two (resolution IV)."""
    found = study("looks")
    signs = np.array([[1 if name in one.plant.options else -1 for name in FACTORS] for one in found.conditions])
    assert (signs.shape, len({*map(tuple, signs)}), {*signs[0]}) == ((16, 8), 16, {-1})
    pairs = [first * second for first, second in combinations(signs.T, 2)]
    for column in signs.T:
        assert column.sum() == 0
        assert not any(column @ pair for pair in pairs)
    assert [*found.contrasts] == [f"{name}={high}" for name, high in FACTORS.items()]
    for column, one in zip(signs.T, found.contrasts.values(), strict=True):
        named = {label for label, sign in zip([one.label for one in found.conditions], column, strict=True) if sign > 0}
        assert (one.measure, {*one.of}, len(one.minus)) == ("misreading", named, 8)
    assert len(found.conditions) == len(found.plants) == 16
    assert (found.conditions[0].label, found.plant_of(found.conditions[0])) == ("plain scene", "fast-twin")
    assert (found.layout, found.trials, found.repetitions) == ("shuffled", 10, 1)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"modality": ["rgb", "rgbd"]}, "expected one, which all conditions of looks have"),
        ({"plant": "fast-twin?discs=no"}, "one without discs=no, which this study varies"),
        ({"sweep": "plant.pose_error=0,1"}, "none with looks"),
        ({"agent": "human-inspired"}, "human-inspired"),
    ],
)
def test_what_it_refuses(options, said):
    with pytest.raises(BadValue, match=said):
        study("looks", **options)
