"""The report as text holds what is to be told and nothing else, in every form."""

import json
import re
from dataclasses import fields, replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lockprobe import run_trial
from lockprobe.agents.cognitive import CHARACTERS
from lockprobe.agents.human_inspired import PRESETS
from lockprobe.interventions.words import TextChannel
from lockprobe.trial.record import Moment, Percept, Task

TASK = Task(joints=("B", "A"), target="A", budget=20)


@pytest.mark.parametrize(
    ("percept", "text"),
    [
        (Percept(positions=(True, False)), "At 1: B."),  # in the listed order
        (Percept(positions=(False, False)), "At 1: none."),
        (Percept(joint="A", outcome="moved", positions=(True, True)), "A moved. At 1: B, A."),
        (Percept(joint="A", outcome="blocked", positions=(True, False)), "A did not move. At 1: B."),
        (Percept(joint="B", outcome="blocked"), "B did not move."),
        (Percept(), ""),
    ],
)
def test_a_report_in_words(percept, text):
    assert TextChannel().perceive(percept, (), TASK, np.random.default_rng(1)).text == text


def test_told_facts_are_written_again_as_they_were():
    before = Percept(joint="A", outcome="moved", positions=(False, True))
    for told in (Percept(positions=(False, False)), before, replace(before, corrects=before), Percept(joint="A")):
        for channel in (TextChannel(), TextChannel(tell="state"), TextChannel(form="json", places=True)):
            for past in ((), (Moment(was=told, told=told),)):
                made = channel.perceive(told, past, TASK, np.random.default_rng(1))
                again = channel.written(made, TASK, first=not past)
                assert (again == made.text) is (told.corrects is None)


def test_what_is_no_text_and_not_to_be_left_out_stays():
    """Each field of a percept has a value of its own here."""
    own = {"pictures": ("picture",), "handles": (((1.0, 2.0), (3.0, 4.0)),), "unlabelled": True, "look": len}
    before = Percept(joint="A", outcome="moved", positions=(True, False), text="before", states_only=True, **own)
    told = TextChannel(tell="both").perceive(before, (), TASK, np.random.default_rng(1))
    changed = {"text": "A moved. At 1: B.", "states_only": False}
    assert told == replace(before, **changed)
    assert told.look is len
    assert {part.name for part in fields(Percept)} == {
        "joint", "outcome", "positions", "text", "states_only", "in_full", "corrects", *own
    }  # fmt: skip


FORMS, TELLS = ("words", "json", "table"), ("state", "outcome", "both")
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
    if form == "table":
        head, *lines = (re.split(r"\s{2,}", line) for line in text.splitlines())
        rows = {row["joint"]: row for line in lines for row in [dict(zip(head, line, strict=True))]}
        joint = next((label for label in labels if rows[label].get("last action", "-") != "-"), None)
        done = None if joint is None else rows[joint]["last action"]
        outcome = {"moved": "moved", "did not move": "blocked"}.get(done)
        positions = tuple(rows[label]["position"] == "1" for label in labels) if "position" in head else None
        return joint, outcome, positions
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


IN_ROWS = {
    "words": (
        "At 1: none. In row 1 of the panel from above, from left to right: A (knob), B (slider). "
        "In row 2 of the panel from above, from left to right: C (knob)."
    ),
    "json": (
        '{"positions": {"B": 0, "A": 0, "C": 0}, "panel": {"rows from above, each from left to right": '
        '[["A", "B"], ["C"]], "kinds": {"B": "slider", "A": "knob", "C": "knob"}}}'
    ),
    "table": (
        "joint  position  row from above  place from left  kind\n"
        "B      0         1               2                slider\n"
        "A      0         1               1                knob\n"
        "C      0         2               1                knob"
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


def test_places_are_told_once_as_the_panel_has_them():
    plain, trial = (
        run_trial(agent="random", modality=modality, layout="shuffled", trial=4)
        for modality in ("symbolic", "symbolic?places=yes")
    )
    panel = ", ".join(
        f"{label} ({'knob' if name.startswith('revolute') else 'slider'})"
        for label, name in zip(trial.labels, trial.joints, strict=True)
    )
    assert f"On the panel, from left to right: {panel}" in trial.opening
    assert not any("panel" in step.told for step in trial.steps)
    assert trial.actions == plain.actions


SCRIPTED = [
    "random", "random-no-repeat", "round-robin", "ideal-observer", "ideal-observer?noise=naive",
    "ideal-observer?plan=information", "viewer", "cognitive:softmax-memory?failure=4&stay=1",
    "cognitive:random-map?window=2&avoid=failed", *(f"human-inspired:{preset}" for preset in PRESETS),
    *(f"cognitive:{character}" for character in CHARACTERS),
]  # fmt: skip


@pytest.mark.parametrize("agent", SCRIPTED)
@pytest.mark.parametrize("form", FORMS)
def test_who_compares_states_plays_the_truth_as_who_is_told_outcomes(agent, form):
    for trial in (1, 2) if form == "words" else (3,):
        both = run_trial(agent=agent, trial=trial)
        state = run_trial(agent=agent, trial=trial, modality=f"symbolic?tell=state&form={form}")
        assert [step.decision for step in state.steps] == [step.decision for step in both.steps]
        for one, other in zip(state.steps, both.steps, strict=True):
            assert (one.moved, one.told_moved, one.told_state) == (other.moved, other.told_moved, other.told_state)


@pytest.mark.parametrize("agent", SCRIPTED)
def test_under_flips_everyone_goes_on_and_says_what_comparing_says(agent):
    trial = run_trial(agent=agent, p=0.4, trial=2, modality="symbolic?tell=state")
    assert trial.error is None
    if agent.startswith(("human", "cognitive", "viewer")):
        said = [None, *("moved" if step.told_moved else "blocked" for step in trial.steps)]
        assert [step.decision.claimed for step in trial.steps] == said[:-1]


def test_a_lie_about_a_state_is_taken_back_by_the_next_report_of_that_joint():
    """Compared with the last report: false if this report lies, or the last one lied of this joint, but not both."""
    for flip in ("transient", "sticky"):
        for seed in range(1, 9):
            told = run_trial(agent="random", p=0.4, flip=flip, modality="symbolic?tell=state", seed=seed)
            both = run_trial(agent="random", p=0.4, flip=flip, modality="symbolic", seed=seed)
            assert told.actions == both.actions
            assert [step.told_state for step in told.steps] == [step.told_state for step in both.steps]
            lied = {}
            for i, (step, report) in enumerate(zip(told.steps, both.steps, strict=True)):
                before = (
                    lied if flip == "sticky" else {told.steps[i - 1].joint: lied[told.steps[i - 1].joint]} if i else {}
                )
                assert step.told_falsely == (report.told_falsely != before.get(step.joint, False))
                lied[step.joint] = report.told_falsely


def test_the_record_says_what_is_told_and_how():
    channels = {
        m: run_trial(agent="random", modality=m).channels[-1] for m in ("symbolic", "symbolic?tell=state&form=json")
    }
    both = {"channel": "TextChannel", "tell": "both", "form": "words", "places": False}
    assert channels == {"symbolic": both, "symbolic?tell=state&form=json": {**both, "tell": "state", "form": "json"}}


@pytest.mark.parametrize(
    ("tell", "seen"), [("state", {"positions"}), ("outcome", {"outcome"}), ("both", {"positions", "outcome"})]
)
def test_what_words_show_of_a_percept(tell, seen):
    """A change of anything else is none; a corrected report shows what the first one showed."""
    told = Percept(joint="B", outcome="moved", positions=(True, False))
    others = {"outcome": "blocked", "positions": (False, False), "text": "Well."}
    shown = TextChannel(tell=tell).shown
    for name, value in others.items():
        changed = replace(told, **{name: value})
        assert (shown(changed) != shown(told)) == (name in seen)
        assert (shown(replace(told, corrects=changed)) != shown(replace(told, corrects=told))) == (name in seen)
        written = (
            TextChannel(tell=tell).perceive(one, (), TASK, np.random.default_rng(1)).text for one in (told, changed)
        )
        assert (len(set(written)) > 1) == (name in seen)
    assert shown(replace(told, corrects=told)) != shown(told)
