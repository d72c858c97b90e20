"""The study ``looks``: sixteen scenes of eight factors, each at either level in half of them."""

import pytest

from lockprobe.foundation.errors import BadValue
from lockprobe.statistics.factorial import factorial_of
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.study_design import design_of

FACTORS = {
    "discs": "no", "handle_colours": "plain", "labels": "no", "clutter": "8", "light": "side", "colours": "second",
    "viewpoint": "oblique", "view_jitter": "5",
}  # fmt: skip


def test_its_scenes_are_a_factorial_design_of_all_factors():
    found = study("looks")
    design = factorial_of(design_of(found).shown("rgb"))
    assert design.levels == {f"plant.{name}": high for name, high in FACTORS.items()}
    assert len(found.conditions) == len(found.plants) == 16
    assert (found.conditions[0].label, found.plant_of(found.conditions[0])) == ("plain scene", "fast-twin")
    assert (found.layout, found.trials, found.repetitions) == ("shuffled", 10, 1)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"modality": "symbolic"}, "expected pictures, rgb or rgbd, whose looks vary"),
        ({"modality": ["rgb", "rgbd"]}, "expected one, which all conditions of looks have"),
        ({"plant": "fast-twin?discs=no"}, "one without discs=no, which this study varies"),
        ({"plant": "symbolic"}, "one whose camera takes pictures: fast-twin or twin"),
        ({"sweep": "plant.pose_error=0,1"}, "none with looks"),
        ({"agent": "human-inspired"}, "human-inspired"),
    ],
)
def test_what_it_refuses(options, said):
    with pytest.raises(BadValue, match=said):
        study("looks", **options)
