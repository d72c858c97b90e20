"""What is shown of a box is what was told of it, as text, drawn, or as pictures."""

import asyncio
from dataclasses import replace

import pytest
from seated import people_study, percept_of
from seen import PhotographedPlant

from lockprobe.interventions.condition import flips
from lockprobe.people.box_view import box_to_show, panel_to_show, view_of_modality
from lockprobe.people.experiment import Experiment
from lockprobe.plan import Names
from lockprobe.plants import catalogue
from lockprobe.studies.paused_trial import PausedTrial

STUDY = people_study(layout="shuffled", flip="sticky", modalities=("symbolic",))
PLAN = STUDY.plan("participant", STUDY.labelled("flip?p=0.4&persistence=sticky + symbolic"), 1, 3)


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
    panel = panel_to_show(PLAN, situation, "panel")
    assert percept_of(panel) == situation.percept
    by_label = {label: PLAN.box.joints[i] for i, label in enumerate(Names(PLAN).labels)}
    assert [joint.label for joint in panel.joints] == list(situation.task.joints)
    assert [(joint.kind, joint.place) for joint in panel.joints] == [
        (by_label[joint.label].kind, by_label[joint.label].place) for joint in panel.joints
    ]
    assert [joint.label for joint in panel.joints if joint.target] == [situation.task.target]


def test_as_text_it_has_no_places():
    panel = panel_to_show(PLAN, after([0]), "text")
    assert (panel.view, panel.outcome is not None, panel.told.startswith(panel.last)) == ("text", True, True)
    assert {(joint.kind, joint.place, joint.handle) for joint in panel.joints} == {(None, None, None)}
    assert all(joint.position in (0, 1) for joint in panel.joints)


def test_where_no_positions_are_told_none_are_shown():
    plan = replace(PLAN, condition=flips((0.4,), "outcome-only")[0])
    situation = after([1, 1], plan)
    panel = panel_to_show(plan, situation, "panel")
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
    monkeypatch.setattr("lockprobe.studies.play.resolve_plant", lambda spec: source)


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


def test_a_modality_with_pictures_shows_pictures_whatever_reports_look_like():
    assert [view_of_modality(m, "text") for m in ("symbolic", "rgb", "rgbd?depth=height")] == [
        "text", "pictures", "pictures",
    ]  # fmt: skip
