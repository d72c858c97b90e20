"""What breaks is the fault of the part in which it broke; what ends the run, and our own errors, pass."""

import asyncio

import pytest

from lockprobe.foundation.errors import ChannelFault, Missing, ModelFault, PlantFault, ReplyFault, TrialFault
from lockprobe.trial.boundary import AGENT, INTERVENTIONS, PLANT


@pytest.mark.parametrize(
    ("boundary", "fault"), [(AGENT, ModelFault), (INTERVENTIONS, ChannelFault), (PLANT, PlantFault)]
)
@pytest.mark.parametrize(
    "error", [ValueError("no"), SystemExit("no"), BaseException("no"), BaseExceptionGroup("no", [OSError()])]
)
def test_anybody_s_error_is_a_fault(boundary, fault, error):
    with pytest.raises(TrialFault, match=rf"^{type(error).__name__}: no") as caught, boundary:
        raise error
    assert type(caught.value) is fault
    assert caught.value.__cause__ is error


@pytest.mark.parametrize(
    "error", [Missing("a", "b"), ReplyFault("no"), KeyboardInterrupt(), GeneratorExit(), asyncio.CancelledError()]
)
def test_what_is_ours_or_ends_the_run_passes(error):
    with pytest.raises(type(error)) as caught, PLANT:
        raise error
    assert caught.value is error


def test_boundaries_stand_inside_each_other_and_the_inner_one_counts():
    with pytest.raises(ChannelFault, match="OSError: no"), PLANT, INTERVENTIONS:
        raise OSError("no")
    with PLANT, INTERVENTIONS:
        pass
