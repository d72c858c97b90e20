"""A sentence when a loop is complete, and its control at the same moments."""

import pytest

from lockprobe.agents.prompt import conversation
from lockprobe.interventions.nudge import NUDGE, loops_completed
from lockprobe.interventions.remark import REMARK
from lockprobe.studies.running.single import run_trial
from lockprobe.trial.briefing import Briefing
from lockprobe.trial.record import Decision, Moment, Percept, Situation, Task, Turn


def moments(chosen):
    nothing = Percept()
    return (Moment(was=nothing, told=nothing), *(Moment(was=nothing, told=nothing, chosen=c) for c in chosen))


@pytest.mark.parametrize(
    ("chosen", "copies", "due"),
    [("", 2, False), ("ABC", 2, False), ("ABCABC", 2, True), ("ABCDABC", 2, True), ("ABABA", 2, False),
     ("ABCABCA", 2, False), ("ABCABC", 3, False), ("ABCABCABC", 3, True), ("ABCABCDABC", 3, False)],
)  # fmt: skip
def test_it_is_due_when_a_copy_is_complete(chosen, copies, due):
    assert loops_completed(moments(chosen), copies) is due


def test_nudge_and_remark_are_said_at_the_same_steps_and_change_no_blind_agent():
    plain, nudged, remarked = (
        run_trial(agent="round-robin", box="chain-7", condition=c) for c in ("", "nudge?after=2", "remark?after=2")
    )
    said = [[step.step for step in trial.steps if step.remark] for trial in (nudged, remarked)]
    assert said[0] == said[1] != []
    assert {step.remark for step in nudged.steps} == {"", NUDGE}
    assert {step.remark for step in remarked.steps} == {"", REMARK}
    assert plain.actions == nudged.actions == remarked.actions


def test_a_language_model_reads_it_beside_the_report_and_has_it_in_its_past():
    task = Task(joints=("A", "B"), target="A", budget=20)
    told = Percept(joint="B", outcome="moved", positions=(False, True), text="B moved.")
    turn = Turn(
        percept=Percept(positions=(False, False), text="At 1: none."), decision=Decision(joint="B", replies=("r",))
    )
    now = Situation(task=task, past=(turn,), percept=told, briefing=Briefing(remark=NUDGE))
    assert conversation(now)[-1].text == f"B moved. {NUDGE}"
    later = Situation(
        task=task,
        past=(turn, Turn(percept=told, decision=turn.decision, remark=NUDGE)),
        percept=told,
        briefing=Briefing(),
    )
    assert [message.text for message in conversation(later)][2::2] == [f"B moved. {NUDGE}", "B moved."]
