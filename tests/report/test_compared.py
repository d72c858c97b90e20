"""A figure of the paper beside one of ours."""

from lockprobe.analysis.summary import summarise
from lockprobe.report.compared import same_step


def test_a_step_outside_of_its_interval_is_not_compatible(modal):
    symbolic = summarise(modal).agents[2].conditions[0]
    assert same_step(symbolic, 15)[1] == "compatible"
    assert same_step(symbolic, 9)[1] == "not compatible"
