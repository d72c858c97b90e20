"""Sentences on one false report say what was found, or how small an effect would have been."""

from lockprobe.report.prose.excursion import excursion_said
from lockprobe.report.prose.subject import Subject
from lockprobe.statistics.excursion import Excursion, Excursions, NotEstimated


def effect(value, p_value):
    return Excursion(
        outcome="solved", among="all", effect=value, low=value - 0.03, high=value + 0.03, p_value=p_value,
        standard_error=0.015, points=2000, clusters=30, freedom=24, smallest=0.045,
    )  # fmt: skip


def found(*effects):
    return Excursions(points=100, estimates=effects, left_out=())


def test_what_was_found_is_said_with_its_size():
    said = excursion_said(found(effect(0.05, 0.002)), Subject.of("random"))
    assert said == (
        "Above a flip rate of 0, one more false report makes random more likely to solve the box (+5 points, 95 % interval +2 to +8; "
        "P = 0.002). The power to detect an effect of 4 points is 80 % (2000 reports in 30 blocks)."
    )


def test_what_was_not_found_is_not_denied():
    said = excursion_said(found(effect(0.01, 0.5)), Subject.of("participant"))
    assert said.startswith(
        "Above a flip rate of 0, no effect of one more false report on the success of people was detected"
    )


def test_an_effect_that_is_not_estimated_has_its_reason():
    none = NotEstimated(outcome="solved", among="all", reason="a covariate varies in one block alone")
    assert excursion_said(Excursions(points=100, estimates=(), left_out=(none,)), Subject.of("random")) == (
        "The effect of one false report on the success of random is not estimated: a covariate varies in one block alone."
    )
