"""What breaks is the fault of the part in which it broke; what ends the run, and our own errors, pass."""

import asyncio
import json

import pytest

from lockprobe.foundation.errors import ChannelFault, Missing, ModelFault, PlantFault, ReplyFault, TrialFault
from lockprobe.trial.boundary import AGENT, INTERVENTIONS, PLANT

OF_A_PERSON = """
import json


def own():
    return json.loads("{")


def given(call):
    return call()
"""


class Mute(Exception):
    """Breaks when it is printed."""

    def __str__(self):
        raise ValueError


@pytest.mark.parametrize(
    ("boundary", "fault"), [(AGENT, ModelFault), (INTERVENTIONS, ChannelFault), (PLANT, PlantFault)]
)
@pytest.mark.parametrize(
    "error", [ValueError("no"), SystemExit("no"), BaseException("no"), BaseExceptionGroup("no", [OSError()]), Mute()]
)
def test_anybody_s_error_is_a_fault(boundary, fault, error):
    said = type(error).__name__ + (": no" if type(error) is not Mute else "$")
    with pytest.raises(TrialFault, match=rf"^(in the agent \(.*\): )?{said}") as caught, boundary:
        raise error
    assert type(caught.value) is fault
    assert caught.value.__cause__ is error


@pytest.mark.parametrize("error", [Missing("a", "b"), ReplyFault("no"), KeyboardInterrupt(), GeneratorExit()])
def test_what_is_ours_or_ends_the_run_passes(error):
    with pytest.raises(type(error)) as caught, PLANT:
        raise error
    assert caught.value is error


def test_the_end_of_the_task_passes_and_a_cancellation_of_the_agent_s_own_is_a_fault():
    async def cancelled(by_us):
        if by_us:
            asyncio.current_task().cancel()
        with AGENT:
            await asyncio.sleep(0)
            raise asyncio.CancelledError

    with pytest.raises(asyncio.CancelledError):
        asyncio.run(cancelled(by_us=True))
    with pytest.raises(ModelFault, match=r"in the agent \(.*\): CancelledError$"):
        asyncio.run(cancelled(by_us=False))
    with pytest.raises(PlantFault, match=r"^CancelledError$"), PLANT:  # in a thread without tasks
        raise asyncio.CancelledError


def test_an_error_in_a_person_s_agent_names_its_file_and_the_line_that_led_to_it(tmp_path):
    """Also where a library raises, or Lockprobe when it is called with nonsense; a folder is never named."""
    mine: dict = {"__name__": "mine"}
    exec(compile(OF_A_PERSON, tmp_path / "mine.py", "exec"), mine)
    for call, line in ((mine["own"], 6), (lambda: mine["given"](mine["own"]), 6), (lambda: mine["given"](1), 10)):
        with pytest.raises(ModelFault) as caught, AGENT:
            call()
        assert str(caught.value).startswith(f"in the agent (mine.py, line {line}): ")
        assert str(tmp_path) not in str(caught.value)


def test_an_error_in_lockprobe_or_a_library_names_no_line():
    ours: dict = {"__name__": "lockprobe.agents.some"}
    exec("def own(loads): return loads('{')", ours)
    with pytest.raises(ModelFault) as caught:
        exec("with AGENT: own(loads)", {**ours, "AGENT": AGENT, "loads": json.loads})
    assert str(caught.value).startswith("JSONDecodeError: ")


def test_boundaries_stand_inside_each_other_and_the_inner_one_counts():
    with pytest.raises(ChannelFault, match="OSError: no"), PLANT, INTERVENTIONS:
        raise OSError("no")
    with PLANT, INTERVENTIONS:
        pass
