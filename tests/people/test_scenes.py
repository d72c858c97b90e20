"""What is read is filled in and says what the experimenter wants said and no more; a box is shown as it was told."""

import asyncio
from dataclasses import dataclass, replace

import pytest
from seated import GO_ON, WORDS, parts, people_study, percept_of, under
from seen import PhotographedPlant

from lockprobe.interventions.asked_and_done import ASIDES
from lockprobe.interventions.conditions import flips, read_condition, shipped
from lockprobe.people.diary import Answers, Attempt, Diary, Did, Joined, Slot
from lockprobe.people.experiment import Experiment, read_words
from lockprobe.people.scenes import _KINDS, Scenes, deceptions
from lockprobe.plants import catalogue
from lockprobe.studies.running.paused_trial import PausedTrial
from lockprobe.trial.condition import Condition, place_of

SLOTS = tuple(Slot(condition="truth", repetition=1, trial=n) for n in (1, 2))
JOINED = Joined(identity="3f9a01bc", token="0" * 64, at=10.0, platform={}, slots=SLOTS, words="en 0")
QUESTIONS = {
    "checks": [{"after": 2, "question": "Blue?", "options": ["blue", "red"], "right": "blue"}],
    "questions": [{"name": "how", "question": "<b>How?</b>", "required": True}],
    "completion_url": "https://example.org/x",
    "completion_code": "C1",
}


def scenes_of(study=None, words=WORDS, **settings):
    return Scenes(words, study or people_study(), Experiment(**settings))


def done(scene, act=None, **more):
    return Did(at=12.0, turn=2, scene=scene, act=act or GO_ON, **more)


def scene(kind, item="", box=0, lines=(), **given):
    """The scene of a station, after these lines."""
    scenes = scenes_of(**given)
    station = next(one for one in scenes.way(2) if (one.kind, one.item, one.box) == (kind, item, box))
    return parts(scenes.at(station, Diary(JOINED, list(lines))))


def closed(why, **given):
    return parts(scenes_of(**given).closed(why))


def test_everybody_comes_through_all_scenes_in_their_order():
    assert [(one.kind, one.item, one.box) for one in scenes_of(**QUESTIONS).way(2)] == [
        ("page", "1", 0), ("page", "2", 0), ("comprehension", "", 0), ("box", "", 0), ("over", "", 0), ("box", "", 1),
        ("over", "", 1), ("box", "", 2), ("over", "", 2), ("check", "1", 0), ("ask", "how", 0), ("debrief", "", 0),
    ]  # fmt: skip


def test_facts_are_filled_in_and_a_page_says_whether_a_box_comes_next():
    consent, page = parts(scenes_of().consent(6)), scene("page", "2")
    assert (page.number, page.of, page.title, page.begins) == (2, 2, WORDS.instructions[1].title, False)
    assert "6" in " ".join(consent.paragraphs)
    assert "12" in " ".join(page.paragraphs)
    assert not [text for one in (consent, page) for text in one.paragraphs if "{" in text]
    assert [scene("page", number, comprehension=False).begins for number in "12"] == [False, True]
    words = WORDS.model_copy(update={"debrief": WORDS.debrief.model_copy(update={"title": "{boxes} {joints} {other}"})})
    assert scene("debrief", words=words).title == "2 4 {other}"


@pytest.mark.parametrize("feedback", [True, False])
@pytest.mark.parametrize(("how", "opened"), [("solved", True), ("budget", False), ("error", None)])
def test_practice_says_how_it_ended_and_a_box_where_the_study_does(how, opened, feedback):
    act = Attempt(joint="A", rt=1.0)
    practice, real = (
        scene("over", box=box, lines=[done("box", act, box=box, step=1, ended=how)], feedback=feedback)
        for box in (0, 1)
    )
    assert (practice.practice, practice.number, practice.of, practice.title) == (True, 0, 2, WORDS.practice_over.title)
    assert (practice.solved, real.solved) == (opened, opened if feedback else None)
    assert (real.practice, real.number) == (False, 1)
    said = {None: None, True: "You opened it.", False: "You did not open it in 12 steps."}
    for one in (practice, real):
        assert {text for text in said.values() if text in one.paragraphs} == {said[one.solved]} - {None}


def test_no_scene_says_what_is_right_and_a_question_is_as_it_stands():
    asked, known = scene("comprehension"), WORDS.comprehension.questions
    assert [one.question for one in asked.questions] == [one.question for one in known]
    (check,), (ask,) = (scene(*of, **QUESTIONS).questions for of in (("check", "1"), ("ask", "how")))
    assert {*asked.questions[0]} == {*check} == {*ask} == {"question", "options", "required"}
    assert (check.question, check.options, check.required) == ("Blue?", ("blue", "red"), True)
    assert (ask.question, ask.options, ask.required) == ("<b>How?</b>", (), True)


@pytest.mark.parametrize("asked", [False, True])
def test_that_one_is_asked_is_said_where_one_is(asked):
    page = scene("page", "2", study=people_study(assessment=asked))
    assert (WORDS.instructions[1].if_asked[0] in page.paragraphs) is asked


def test_who_answered_wrong_reads_which_question_it_was():
    first, second, third = WORDS.comprehension.questions
    act = Answers(answers=(first.right, second.options[0], third.right), rt=1.0)
    wrong = done("comprehension", act, item="1", right=False)
    back = scene("page", "1", lines=[wrong])
    assert second.question in back.notice[0]
    assert first.question not in back.notice[0]
    alone = scene("comprehension", lines=[wrong], words=WORDS.model_copy(update={"instructions": ()}))
    assert alone.notice == back.notice  # where there is nothing to go back to


def test_every_way_of_being_closed_has_its_text_and_way_back():
    ends = {"left_url": "https://example.org/no", "left_code": "LEFT", "completion_code": "C1"}
    codes = {**dict.fromkeys(("declined", "full", "late", "withdrawn"), "LEFT"), "taken": "", "finished": "C1"}
    assert {why: closed(why, **ends).code for why in WORDS.closed} == codes
    assert len({closed(why).title for why in codes}) == len(codes)
    end = scene("debrief", **QUESTIONS)
    assert (end.url, end.code) == ("https://example.org/x", "C1")


@pytest.mark.parametrize("language", ["en", "de"])
@pytest.mark.parametrize(
    ("specs", "kinds"),
    [
        (["flip?p=0.4"], ["false"]), (["flip?p=0.4&only=moved + nudge"], ["false"]), (["phantom?p=0.4"], ["false"]),
        (["correction?p=0.4"], ["false"]), (["correction?p=0.4&first=truth&last=lie"], ["false"]),
        (["delay?lag=2"], ["late"]), (["tremble?p=0.1"], ["another"]), (["warn"], ["warned"]),
        (["warn?rate=0.4 + flip?p=0.4"], ["false"]), (["warn + tremble?p=0.1"], ["another", "warned"]),
        (["tremble?p=0.1", "flip?p=0.4 + warn", "delay"], ["false", "late", "another"]),
        *(([spec], []) for spec in (
            "flip?p=0", "delay?lag=0", "drop?p=0.3", "nudge", "correction?p=1&first=truth&last=truth", "remark",
            "distract?p=0.3", "nudge + tremble?p=0", "nudge + drop?p=0.5", "symbolic",
        )),
    ],
)  # fmt: skip
def test_the_end_names_what_the_conditions_did_and_nothing_else_and_nothing_is_said_before(specs, kinds, language):
    given = {"words": (words := read_words(language)), "study": under("truth", *specs)}
    changes = " ".join(words.changes[kind] for kind in kinds)
    for text, end in [
        (words.debrief, scene("debrief", **given)),
        *((words.closed[why], closed(why, **given)) for why in ("late", "withdrawn")),
    ]:
        assert (text.if_false[0].replace("{changes}", changes) in end.paragraphs) is bool(kinds)
        said = " ".join(end.paragraphs)
        assert {kind for kind, sentence in words.changes.items() if sentence in said} == set(kinds)
    assert len(closed("full", **given).paragraphs) == len(words.closed["full"].paragraphs)
    first, true = (
        [scenes_of(**one).consent(2), *(scene("page", n, **one) for n in "12")]
        for one in (given, given | {"study": under("truth")})
    )
    assert first == true


STUDY = people_study(layout="shuffled", flip="integrated", modalities=("symbolic",))
PLAN = STUDY.plan("participant", STUDY.labelled("flip?p=0.4&others=kept + symbolic"), 1, 3)


def after(joints, plan=PLAN):
    """The situation after these attempts, joints by their place in the listing."""

    async def played():
        held = await PausedTrial(plan).begin()
        for joint in joints:
            await held.attempt(held.situation.task.joints[joint], "moved")
        situation = held.situation
        await held.close()
        return situation

    return asyncio.run(played())


def shown(situation, plan=PLAN, number=2, **given):
    return parts(scenes_of(**given).box(plan, situation, number, 5))


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
    by_label = {label: PLAN.box.joints[i] for i, label in enumerate(PLAN.names.labels)}
    for joint in drawn.panel.joints:
        assert (joint.kind, joint.place) == (by_label[joint.label].kind, by_label[joint.label].place)
        assert joint.target == (joint.label == situation.task.target)
    assert (drawn.practice, drawn.number, drawn.of, drawn.step, drawn.budget, drawn.ask) == (False, 2, 5, 4, 12, True)
    assert (len(drawn.history), shown(situation, history=False).history) == (3, ())
    assert shown(situation, number=0).practice
    german = shown(situation, words=read_words("de"))
    moved = "hat sich nicht bewegt." if "did not" in drawn.panel.report[0] else "hat sich bewegt."
    assert german.panel.report[0] == f"{situation.percept.joint} {moved}"
    assert german.history[-1].startswith(german.panel.report[0])
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
    "nudge + distract?p=1": "You attempted {b}. {b} is now at {at}. At 1: {ones}.",
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


def test_remarks_stay_in_view_warnings_stand_above_every_step_and_the_report_is_of_the_joint_attempted():
    seen, _ = under_one("distract?p=1", [0, 1])
    assert seen.history[-1].endswith(seen.remark)
    assert all(line.endswith(ASIDES) for line in seen.history)
    nudged, _ = under_one("nudge", [1, 2, 0, 1, 2, 0])
    assert [nudged.remark in line for line in nudged.history] == [False] * 5 + [True]
    for joints in ([], [0, 1]):
        warned, _ = under_one("warn?rate=0.4", joints)
        assert warned.warning == "What you are told of your last action is with probability 0.4 false."
        assert (warned.warning in warned.spoken) == (not joints)
    forced, situation = under_one("tremble?p=1&at=1 + symbolic", [0])
    assert forced.panel.last == situation.percept.joint != situation.task.joints[0]
    assert forced.history[0].startswith(forced.panel.last)


@pytest.mark.parametrize(("modality", "pictures"), [("rgb", 1), ("rgbd", 2)])
def test_pictures_are_shown_as_they_are_and_say_themselves_what_happened(monkeypatch, modality, pictures):
    source = catalogue.PlantSource(spec="symbolic", make=lambda box, labels, rng: PhotographedPlant(box))
    monkeypatch.setattr("lockprobe.plants.catalogue.resolve_plant", lambda spec: source)
    plan = replace(PLAN, condition=flips((0.0,), modalities=(modality,))[0])
    situation = after([1, 1], plan)
    scene = shown(situation, plan)
    label = situation.task.joints[1]
    assert (scene.panel.view, scene.panel.outcome, len(scene.panel.pictures)) == ("pictures", None, pictures)
    assert {scene.panel.report, *((line,) for line in scene.history)} == {(f"You attempted {label}.",)}
    seen = percept_of(scene.panel)
    assert [picture.png for picture in seen.pictures] == [p.png for p in situation.percept.pictures if p.shown]
    assert {(joint.position, joint.kind, joint.place) for joint in scene.panel.joints} == {(None, None, None)}
    dropped, _ = under_one(f"drop?p=1 + {modality}", [0, 1], plant="fast-twin")
    assert dropped.panel.pictures == ()
    assert dropped.panel.report == (f"You attempted {label}.", "Nothing was reported.")


def test_of_every_shipped_intervention_that_people_can_play_it_is_known_what_it_does():
    named = {name for name, kind in shipped().items() if "?" not in name and place_of(kind) != "remembered"}
    assert set(_KINDS) == named - {"prompt", "hypothesis"}


@dataclass(frozen=True, kw_only=True)
class Hush:
    """Somebody's own intervention."""

    def perceive(self, percept, past, task, rng):
        return percept


def test_of_what_another_package_does_nothing_is_known():
    assert deceptions([Condition(interventions=(Hush(),))]) == ("changed",)
    assert deceptions(map(read_condition, ("rgb?blur=8", "flip?p=0.4 + rgb"))) == ("false",)
