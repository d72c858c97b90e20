"""The report as text holds what is to be told and nothing else, in every form."""

import json
import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lockprobe import run_trial
from lockprobe.interventions.words import TextChannel
from lockprobe.trial.record import Moment, Percept, Task

FORMS, TELLS = ("words", "json"), ("state", "outcome", "both")
LABELS = ("B", "D", "A", "C", "E")
EARLIER = (Moment(was=Percept(), told=Percept()),)


def parsed(form, text, labels):
    """Joint attempted, outcome (None if it is not told), and positions, as a report in any form has them."""
    if not text:
        return None, None, None
    if form == "json":
        told = json.loads(text)
        moved = told.get("moved")
        positions = told.get("positions")
        outcome = None if moved is None else "moved" if moved else "blocked"
        return told.get("attempted"), outcome, positions and tuple(bool(positions[label]) for label in labels)
    moved, blocked, tried = (
        re.search(rf"(?:^|\. ){pattern}\.", text)
        for pattern in (r"(\w) moved", r"(\w) did not move", r"You attempted (\w)")
    )
    there = re.search(r"At 1: ([^.]+)\.", text)
    found = moved or blocked or tried
    return (
        found and found.group(1),
        "moved" if moved else "blocked" if blocked else None,
        there and tuple(label in there.group(1).split(", ") for label in labels),
    )


percepts = st.builds(
    Percept,
    joint=st.sampled_from(LABELS),
    outcome=st.sampled_from(["moved", "blocked", None]),
    positions=st.none() | st.tuples(*[st.booleans()] * len(LABELS)),
)


@given(percept=percepts, form=st.sampled_from(FORMS), tell=st.sampled_from(TELLS))
def test_every_fact_parses_back_and_no_other(percept, form, tell):
    task = Task(joints=LABELS, target="A", budget=20)
    told = TextChannel(tell=tell, form=form).perceive(percept, EARLIER, task, np.random.default_rng(1))
    assert told.outcome == (None if tell == "state" else percept.outcome)
    assert told.positions == (None if tell == "outcome" else percept.positions)
    assert told.states_only == (tell == "state")
    joint, outcome, positions = parsed(form, told.text, LABELS)
    assert (outcome, positions) == (told.outcome, told.positions)
    nothing = told.outcome is None and told.positions is None
    said_by_words = form != "words" or told.outcome is not None or tell == "state"
    assert joint == (None if nothing or not said_by_words else percept.joint)
    assert (told.text == "") == nothing


@pytest.mark.parametrize("agent", ["human-inspired", "ideal-observer", "viewer", "cognitive:perseverant"])
def test_who_compares_states_plays_the_truth_as_who_is_told_outcomes(agent):
    both = run_trial(agent=agent, trial=2)
    for form in FORMS:
        state = run_trial(agent=agent, trial=2, modality=f"symbolic?tell=state&form={form}")
        assert [step.decision for step in state.steps] == [step.decision for step in both.steps]
        for one, other in zip(state.steps, both.steps, strict=True):
            assert (one.moved, one.told_moved, one.told_state) == (other.moved, other.told_moved, other.told_state)


IN_ROWS = {
    "words": (
        "At 1: none. In row 1 of the panel from above, from left to right: A (knob), B (slider). "
        "In row 2 of the panel from above, from left to right: C (knob)."
    ),
    "json": (
        '{"positions": {"B": 0, "A": 0, "C": 0}, "panel": {"rows from above, each from left to right": '
        '[["A", "B"], ["C"]], "kinds": {"B": "slider", "A": "knob", "C": "knob"}}}'
    ),
}


@pytest.mark.parametrize("form", FORMS)
def test_where_joints_lie_is_told_in_rows_from_above_each_from_left_to_right(form):
    where = ((0.9, 0.9), (0.1, 0.9), (0.5, 0.1))
    task = Task(
        joints=("B", "A", "C"), target="A", budget=20, places=where, kinds=("prismatic", "revolute", "revolute")
    )
    look = Percept(positions=(False, False, False))
    assert TextChannel(places=True, form=form).perceive(look, (), task, np.random.default_rng(1)).text == IN_ROWS[form]
