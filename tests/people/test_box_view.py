"""What is shown of a box is what was told of it, as text, drawn, or as pictures."""

import asyncio
from dataclasses import replace

import pytest
from seated import people_study, percept_of, under
from seen import PhotographedPlant

from lockprobe.interventions.conditions import flips
from lockprobe.people.box_view import box_to_show, panel_to_show, view_of_modality
from lockprobe.people.experiment import Experiment
from lockprobe.plants import catalogue
from lockprobe.studies.running.paused_trial import PausedTrial
from lockprobe.trial.plan import Names

STUDY = people_study(layout="shuffled", flip="integrated", modalities=("symbolic",))
PLAN = STUDY.plan("participant", STUDY.labelled("flip?p=0.4&others=kept + symbolic"), 1, 3)


def after(joints, plan=PLAN):
    """The situation after these attempts, joints by their place in the listing."""

    async def played():
        held = await PausedTrial.begin(plan)
        for joint in joints:
            await held.attempt(held.situation.task.joints[joint], "moved")
        situation = held.situation
        await held.close()
        return situation

    return asyncio.run(played())


def shown(situation, plan=PLAN, number=2, **settings):
    return box_to_show(plan, situation, experiment=Experiment(**settings), number=number, of=5)


def test_the_panel_is_drawn_from_what_was_told():
    situation = after([0, 1, 0])
    panel = panel_to_show(PLAN, situation)
    assert percept_of(panel) == situation.percept
    by_label = {label: PLAN.box.joints[i] for i, label in enumerate(Names(PLAN).labels)}
    assert [joint.label for joint in panel.joints] == list(situation.task.joints)
    assert [(joint.kind, joint.place) for joint in panel.joints] == [
        (by_label[joint.label].kind, by_label[joint.label].place) for joint in panel.joints
    ]
    assert [joint.label for joint in panel.joints if joint.target] == [situation.task.target]


def test_where_no_positions_are_told_none_are_shown():
    plan = replace(PLAN, condition=flips((0.4,), "outcome-only")[0])
    situation = after([1, 1], plan)
    panel = panel_to_show(plan, situation)
    assert {line.ones for line in shown(situation, plan).history} == {None}
    assert {joint.position for joint in panel.joints} == {None}
    assert panel.outcome in ("moved", "blocked")


def test_before_the_first_attempt_there_is_no_outcome():
    box = shown(after([]))
    assert (box.panel.last, box.panel.outcome, box.step, box.ask, box.history) == (None, None, 1, False, ())


def test_a_step_says_where_one_is_and_what_was_told():
    situation = after([2, 1, 2])
    box = shown(situation)
    assert (box.practice, box.number, box.of, box.step, box.budget, box.ask) == (False, 2, 5, 4, 12, True)
    told = [turn.percept.text for turn in situation.past[1:]] + [situation.percept.text]
    assert [(line.step, line.joint, line.told) for line in box.history] == [
        (n, turn.decision.joint, text) for n, (turn, text) in enumerate(zip(situation.past, told, strict=True), 1)
    ]
    percepts = [turn.percept for turn in situation.past[1:]] + [situation.percept]
    assert [(line.outcome, line.ones) for line in box.history] == [
        (one.outcome, tuple(label for label, at in zip(situation.task.joints, one.positions, strict=True) if at))
        for one in percepts
    ]
    assert shown(situation, history=False).history == ()
    assert shown(situation, number=0).practice


def test_nobody_is_asked_where_the_study_does_not_ask():
    plan = replace(PLAN, assessment=False)
    assert not shown(after([1, 1], plan), plan).ask


@pytest.fixture
def camera(monkeypatch):
    source = catalogue.PlantSource(spec="symbolic", make=lambda box, labels, rng: PhotographedPlant(box))
    monkeypatch.setattr("lockprobe.studies.running.trial_setup.resolve_plant", lambda spec: source)


@pytest.mark.parametrize(("modality", "pictures"), [("rgb", 1), ("rgbd", 2)])
def test_pictures_are_shown_as_they_are_and_say_themselves_what_happened(camera, modality, pictures):
    plan = replace(PLAN, condition=flips((0.0,), modalities=(modality,))[0])
    situation = after([1, 1], plan)
    box = shown(situation, plan)
    assert (box.panel.view, box.panel.told, box.panel.outcome, len(box.panel.pictures)) == (
        "pictures",
        "",
        None,
        pictures,
    )
    assert box.panel.last == situation.task.joints[1]
    assert {line.told for line in box.history} == {""}
    seen = percept_of(box.panel)
    assert [picture.png for picture in seen.pictures] == [p.png for p in situation.percept.pictures if p.shown]
    assert {(joint.position, joint.kind, joint.place) for joint in box.panel.joints} == {(None, None, None)}
    flat = [x for joint in situation.percept.handles for place in joint for x in place]
    assert [x for joint in seen.handles for place in joint for x in place] == pytest.approx(flat, abs=1e-3)


def test_a_modality_with_pictures_shows_pictures():
    assert [view_of_modality(m) for m in ("symbolic", "rgb", "rgbd?depth=height")] == [
        "panel", "pictures", "pictures",
    ]  # fmt: skip


def under_one(spec, joints, **settings):
    """The scene, and its situation, after these attempts under a condition."""
    study = under(spec, **settings)
    plan = study.plan("participant", study.conditions[0], 1, 3)
    situation = after(joints, plan)
    return shown(situation, plan), situation


def test_a_remark_stands_beside_the_report_and_stays_in_view():
    box, situation = under_one("remark?after=0", [0, 1])
    assert box.remark.startswith("Note: this panel is made of wood")
    assert [line.remark for line in box.history] == [situation.past[1].remark, box.remark] == [box.remark] * 2
    assert box.remark not in box.panel.told
    assert under_one("remark?after=0", [])[0].remark == ""


def test_a_nudge_comes_where_a_loop_is_completed():
    box, _ = under_one("nudge", [1, 2, 0, 1, 2, 0])
    assert box.remark.startswith("Note: you are repeating")
    assert [bool(line.remark) for line in box.history] == [False] * 5 + [True]
    assert under_one("nudge", [1, 2, 0])[0].remark == ""


def test_a_warning_stands_above_every_step():
    for joints in ([], [0, 1]):
        box, _ = under_one("warn?rate=0.4", joints)
        assert box.warning == "What you are told of your last action is with probability 0.4 false."
    assert under_one("truth", [0])[0].warning == ""


@pytest.mark.parametrize("spec", ["correction?p=1", "correction?p=1 + symbolic"])
def test_words_that_say_something_else_than_the_facts_are_shown_as_they_are(spec):
    box, situation = under_one(spec, [0, 1])
    assert box.panel.verbatim
    assert box.panel.told == situation.percept.text
    assert [(line.verbatim, line.told) for line in box.history] == [
        (True, situation.past[1].percept.text), (True, situation.percept.text)
    ]  # fmt: skip
    assert not under_one(spec, [])[0].panel.verbatim  # there is nothing to correct yet


@pytest.mark.parametrize("spec", ["truth", "flip?p=1", "drop?p=1", "delay", "flip?p=1 + symbolic?form=json"])
def test_all_other_words_are_those_of_the_page(spec):
    for joints in ([], [0, 1]):
        box, _ = under_one(spec, joints)
        assert not box.panel.verbatim
        assert not any(line.verbatim for line in box.history)


def test_where_nothing_is_reported_nothing_is_shown():
    box, situation = under_one("drop?p=1", [0, 1])
    assert (box.panel.told, box.panel.outcome, box.panel.last) == ("", None, situation.task.joints[1])
    assert {joint.position for joint in box.panel.joints} == {None}
    assert [(line.told, line.outcome, line.ones) for line in box.history] == [("", None, None)] * 2


def test_a_late_report_is_of_the_joint_that_it_names():
    box, situation = under_one("delay?lag=1 + symbolic", [0, 1])
    first, second = situation.task.joints[:2]
    assert [(line.joint, line.about) for line in box.history] == [(first, None), (second, first)]
    assert (box.panel.last, box.step, box.ask) == (first, 3, True)
    before, _ = under_one("delay?lag=1 + symbolic", [0])
    assert (before.panel.last, before.step, before.ask) == (None, 2, False)


def test_where_another_joint_was_attempted_the_report_is_of_that():
    box, situation = under_one("force?at=1 + symbolic", [0])
    (line,) = box.history
    assert line.joint == situation.task.joints[0] == situation.past[0].decision.joint
    assert line.about == box.panel.last == situation.percept.joint


def test_a_picture_that_is_left_out_is_no_picture(camera):
    box, _ = under_one("drop?p=1 + rgb", [0, 1], plant="fast-twin")
    assert (box.panel.view, box.panel.pictures, box.panel.told) == ("pictures", (), "")
    assert {joint.handle for joint in box.panel.joints} == {None}
    assert len(under_one("nudge + rgb", [0, 1], plant="fast-twin")[0].panel.pictures) == 1
