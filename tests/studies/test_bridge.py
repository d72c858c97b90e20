"""The study ``bridge``: its arms, its defaults, and what it refuses."""

import pytest

from lockprobe.foundation.errors import BadValue
from lockprobe.studies.options.studyfile import study


def test_its_arms_and_defaults():
    found = study("bridge")
    assert [(one.label, one.spec) for one in found.conditions] == [
        ("words", "truth"),
        ("pictures", "rgb"),
        ("replayed", "yoked?p=1&claims=pictures"),
        ("shuffled", "yoked?p=1&claims=pictures&how=shuffle"),
        ("profile", "flip?p=1&like=pictures"),
        ("symmetric", "flip?p=1&like=pictures&by=total"),
    ]
    assert (found.agents, found.plant, found.layout) == (("viewer:human-inspired?acuity=7",), "fast-twin", "shuffled")
    assert (found.trials, found.repetitions) == (60, 1)


def test_the_reading_of_a_false_report_is_that_of_all_arms():
    found = study("bridge", flip="sticky", modality="rgbd?depth=height")
    assert found.conditions[1].modality == "rgbd?depth=height"
    assert all("inverts=position&others=kept" in one.spec for one in found.conditions[2:])


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"modality": "symbolic"}, "modality: got 'symbolic', expected pictures, rgb or rgbd"),
        ({"modality": ["rgb", "rgbd"]}, "expected one, whose pictures"),
        ({"flip": "independent"}, "flip: got 'independent', expected another kind"),
        ({"condition": "nudge"}, "none with bridge"),
        ({"p": [0.4]}, "none with bridge"),
        ({"full": True}, "none with bridge"),
        ({"agent": "human-inspired"}, "viewer:human-inspired plays by what it sees"),
        ({"plant": "symbolic"}, "a plant with a camera"),
    ],
)
def test_what_it_refuses(options, said):
    with pytest.raises(BadValue, match=said):
        study("bridge", **options)
