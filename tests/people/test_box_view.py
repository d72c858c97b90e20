"""What is shown of a box is what was told of it, in the language of the page; practice and example report truly."""

import asyncio
from dataclasses import replace

import pytest
from seated import parts, people_study, percept_of, under
from seen import PhotographedPlant

from lockprobe.interventions.conditions import flips
from lockprobe.people.box_view import box_to_show
from lockprobe.people.experiment import Experiment
from lockprobe.people.practice import practice_plan
from lockprobe.people.texts import read_words
from lockprobe.plants import catalogue
from lockprobe.studies.running.paused_trial import PausedTrial
from lockprobe.trial.plan import Names

STUDY = people_study(layout="shuffled", flip="integrated", modalities=("symbolic",))
PLAN = STUDY.plan("participant", STUDY.labelled("flip?p=0.4&others=kept + symbolic"), 1, 3)
ENGLISH, GERMAN = (read_words(language).page for language in ("en", "de"))


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


def shown(situation, plan=PLAN, number=2, words=ENGLISH, **settings):
    return parts(box_to_show(plan, situation, words, experiment=Experiment(**settings), number=number, of=5))


def under_one(spec, joints, **settings):
    """The scene, and its situation, after these attempts under a condition."""
    study = under(spec, **settings)
    plan = study.plan("participant", study.conditions[0], 1, 3)
    situation = after(joints, plan)
    return shown(situation, plan), situation


def test_a_panel_is_drawn_from_what_was_told_and_says_where_one_is():
    situation = after([2, 1, 2])
    drawn = shown(situation)
    assert replace(percept_of(drawn.panel), text="") == replace(situation.percept, text="")
    by_label = {label: PLAN.box.joints[i] for i, label in enumerate(Names(PLAN).labels)}
    for joint in drawn.panel.joints:
        assert (joint.kind, joint.place) == (by_label[joint.label].kind, by_label[joint.label].place)
        assert joint.target == (joint.label == situation.task.target)
    assert (drawn.practice, drawn.number, drawn.of, drawn.step, drawn.budget, drawn.ask) == (False, 2, 5, 4, 12, True)
    assert (len(drawn.history), shown(situation, history=False).history) == (3, ())
    assert shown(situation, number=0).practice
    first = shown(after([]))
    assert (first.panel.last, first.panel.outcome, first.step, first.ask, first.history) == (None, None, 1, False, ())
    plan = replace(PLAN, assessment=False)
    assert not shown(after([1, 1], plan), plan).ask


REPORTS = {
    "truth": "You attempted {b}. {b} is now at {at}. At 1: {ones}.",
    "symbolic": "{b} {did} {b} is now at {at}. At 1: {ones}.",
    "symbolic?tell=outcome": "{b} {did}",
    "truth + symbolic?form=json": "{b} {did} {b} is now at {at}. At 1: {ones}.",
    "drop?p=1": "You attempted {b}. Nothing was reported.",
    "correction?p=1": "{told}",
    "correction?p=1 + symbolic": "{told}",
    "delay?lag=1 + symbolic": "{a} {did} {a} is now at {at}. At 1: {ones}.",
    "nudge + remark?after=0": "You attempted {b}. {b} is now at {at}. At 1: {ones}.",
}
"""Condition -> what is read after a step."""


@pytest.mark.parametrize("spec", REPORTS)
def test_a_report_is_said_in_the_sentences_of_the_page_or_as_it_is_where_its_words_are_the_condition(spec):
    seen, situation = under_one(spec, [0, 1])
    percept, (first, second) = situation.percept, situation.task.joints[:2]
    about = percept.joint
    ones = [one for one, at in zip(situation.task.joints, percept.positions or (), strict=False) if at]
    facts = {
        "a": first, "b": second, "at": int(about in ones), "ones": ", ".join(ones) or "none", "told": percept.text,
        "did": "moved." if percept.outcome == "moved" else "did not move.", "remark": seen.remark,
    }  # fmt: skip
    report = REPORTS[spec].format(**facts)
    line = " ".join(filter(None, (report, seen.remark)))
    assert (" ".join(seen.panel.report), seen.history[-1]) == (report, line)
    assert seen.spoken == f"{line} Step 3 of 12."


def test_reports_are_in_the_language_of_the_page():
    situation = after([1, 1])
    english, german = shown(situation), shown(situation, words=GERMAN)
    moved = {True: "hat sich bewegt.", False: "hat sich nicht bewegt."}["did not" not in english.panel.report[0]]
    assert german.panel.report[0] == f"{situation.percept.joint} {moved}"
    assert german.history[-1].startswith(german.panel.report[0])
    assert "is now at" not in german.spoken


def test_remarks_stay_in_view_warnings_stand_above_every_step_and_the_report_is_of_the_joint_attempted():
    seen, _ = under_one("remark?after=0", [0, 1])
    assert seen.remark.startswith("Note: this panel is made of wood")
    assert all(line.endswith(seen.remark) for line in seen.history)
    nudged, _ = under_one("nudge", [1, 2, 0, 1, 2, 0])
    assert [nudged.remark in line for line in nudged.history] == [False] * 5 + [True]
    for joints in ([], [0, 1]):
        warned, _ = under_one("warn?rate=0.4", joints)
        assert warned.warning == "What you are told of your last action is with probability 0.4 false."
        assert (warned.warning in warned.spoken) == (not joints)
    forced, situation = under_one("force?at=1 + symbolic", [0])
    assert forced.panel.last == situation.percept.joint != situation.task.joints[0]
    assert forced.history[0].startswith(forced.panel.last)


@pytest.fixture
def camera(monkeypatch):
    def takes(plant):
        source = catalogue.PlantSource(spec="symbolic", make=lambda box, labels, rng: plant(box))
        monkeypatch.setattr("lockprobe.plants.catalogue.resolve_plant", lambda spec: source)

    takes(PhotographedPlant)
    return takes


@pytest.mark.parametrize(("modality", "pictures"), [("rgb", 1), ("rgbd", 2)])
def test_pictures_are_shown_as_they_are_and_say_themselves_what_happened(camera, modality, pictures):
    plan = replace(PLAN, condition=flips((0.0,), modalities=(modality,))[0])
    situation = after([1, 1], plan)
    scene = shown(situation, plan)
    label = situation.task.joints[1]
    assert (scene.panel.view, scene.panel.outcome, len(scene.panel.pictures)) == ("pictures", None, pictures)
    assert scene.panel.report == (f"You attempted {label}.",)
    assert set(scene.history) == {f"You attempted {label}."}
    seen = percept_of(scene.panel)
    assert [picture.png for picture in seen.pictures] == [p.png for p in situation.percept.pictures if p.shown]
    assert {(joint.position, joint.kind, joint.place) for joint in scene.panel.joints} == {(None, None, None)}
    left_out, _ = under_one(f"drop?p=1 + {modality}", [0, 1], plant="fast-twin")
    assert (left_out.panel.pictures, left_out.panel.report) == (
        (),
        (f"You attempted {label}.", "Nothing was reported."),
    )


def test_the_practice_is_another_box_with_true_reports_and_the_settings_of_the_study():
    study = people_study(p=(0.4,), max_steps=9)
    plan = practice_plan(study, Experiment(practice="chain-2"))
    assert (plan.p, plan.box.name, plan.budget, plan.modality) == (0.0, "chain-2", 9, study.modalities[0])
    assert plan.seed != study.seed
    assert practice_plan(under("rgb?p=1", plant="fast-twin"), Experiment()).modality == "rgb"


def test_no_condition_acts_in_practice_and_no_picture_there_is_false_or_degraded():
    acting = under("flip?p=1", "nudge + tremble?p=1", "warn", "delay?lag=2", "drop?p=1")
    assert practice_plan(acting, Experiment()).condition.specs == ()
    pictured = under("rgb?p=1&blur=8", "nudge + rgb?blur=4&occlude=0.3", plant="fast-twin")
    assert practice_plan(pictured, Experiment()).condition.modality == "rgb"
