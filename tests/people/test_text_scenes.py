"""What is read is filled in, and says what the experimenter wants said and no more."""

import asyncio
from dataclasses import replace

import pytest
from seated import WORDS, people_study, under

from lockprobe.boxes.families import box
from lockprobe.people.diary import Diary, Did, Joined, Slot
from lockprobe.people.experiment import Experiment
from lockprobe.people.journey import Journey, stations
from lockprobe.people.practice import examples_of
from lockprobe.people.responses import Answers, Attempt, Next
from lockprobe.people.text_scenes import TextScenes
from lockprobe.people.texts import read_words
from lockprobe.trial.record import STATES

SLOTS = tuple(Slot(condition="truth", repetition=1, trial=n) for n in (1, 2))
JOINED = Joined(identity="3f9a01bc", token="0" * 64, at=10.0, platform={}, slots=SLOTS, words="en 0")
QUESTIONS = {
    "checks": [{"after": 2, "question": "Blue?", "options": ["blue", "red"], "right": "blue"}],
    "questions": [{"name": "how", "question": "<b>How?</b>", "required": True}],
    "completion_url": "https://example.org/x",
    "completion_code": "C1",
}


def journey(joined, lines, experiment, words):
    """How far somebody has come by these lines."""
    return Journey.of(Diary(joined, tuple(lines)), stations(experiment, words, len(joined.slots)))


def at(ended, box, *more, **settings):
    """The scene after a box that ended so."""
    experiment = Experiment(**{"practice": "chain-3", **settings})
    step = Did(at=11.0, turn=2, scene="box", act=Attempt(joint="A", rt=1.0), box=box, step=1, told="", ended=ended)
    return TextScenes(WORDS, people_study(), experiment).at(journey(JOINED, [step, *more], experiment, WORDS))


def done(scene, number, **more):
    return Did(at=12.0, turn=number, scene=scene, act=Next(), **more)


def test_facts_are_filled_in():
    texts = TextScenes(WORDS, people_study(), Experiment())
    consent = texts.consent(6)
    assert "6" in " ".join(consent.paragraphs)
    page = texts.at(journey(JOINED, [done("page", 2, item="1")], Experiment(), WORDS))
    assert (page.number, page.of, page.title) == (2, 2, WORDS.instructions[1].title)
    assert "12" in " ".join(page.paragraphs)
    assert not [text for scene in (consent, page) for text in scene.paragraphs if "{" in text]
    words = WORDS.model_copy(update={"debrief": WORDS.debrief.model_copy(update={"title": "{boxes} {joints} {other}"})})
    way = [done("over", 3 + box, box=box) for box in (0, 1, 2)]
    end = TextScenes(words, people_study(), Experiment()).at(journey(JOINED, [*way], Experiment(), words))
    assert end.title == "2 4 {other}"


@pytest.mark.parametrize(("ended", "solved"), [("solved", True), ("budget", False), ("error", None)])
def test_whether_a_box_was_opened_is_said_where_the_experimenter_says_so(ended, solved):
    silent, said = at(ended, 1), at(ended, 1, feedback=True)
    assert (silent.solved, silent.number, silent.of, silent.practice) == (None, 1, 2, False)
    assert silent == at("budget", 1)
    assert said.solved is solved
    assert len(said.paragraphs) == len(silent.paragraphs) + (solved is not None)


def asked(**settings):
    """The scene of questions on the instructions."""
    experiment = Experiment(**settings)
    pages = [done("page", 1 + n, item=str(n)) for n in (1, 2)]
    return TextScenes(WORDS, people_study(), experiment).at(journey(JOINED, pages, experiment, WORDS))


def test_the_questions_on_the_instructions_do_not_say_what_is_right():
    scene, known = asked(), WORDS.comprehension.questions
    assert scene.kind == "comprehension"
    assert [one.question for one in scene.questions] == [one.question for one in known if one.only != "false_reports"]
    assert set(scene.questions[0].model_dump()) == {"question", "options"}
    own = {"question": "Blue?", "options": ["blue", "red"], "right": "blue"}
    assert [one.question for one in asked(comprehension={"questions": [own]}).questions] == ["Blue?"]


@pytest.mark.parametrize(("ask", "begins"), [(True, [False, False]), (False, [False, True])])
def test_a_page_says_whether_a_box_comes_next(ask, begins):
    experiment = Experiment(comprehension={"ask": ask})
    texts, pages = TextScenes(WORDS, people_study(), experiment), [done("page", 2, item="1")]
    seen = [texts.at(journey(JOINED, pages[:number], experiment, WORDS)).begins for number in (0, 1)]
    assert seen == begins


def test_that_reports_can_be_wrong_is_said_and_asked_only_where_the_study_says_so():
    said = asked(say_false=True)
    assert [one.question for one in said.questions][-1] == WORDS.comprehension.questions[-1].question
    for say_false in (False, True):
        experiment = Experiment(say_false=say_false)
        texts = TextScenes(WORDS, people_study(), experiment)
        page = texts.at(journey(JOINED, [done("page", 2, item="1")], experiment, WORDS))
        assert (WORDS.instructions[1].if_false[0] in page.paragraphs) is say_false


def test_who_answered_wrong_reads_which_question_it_was():
    experiment, texts = Experiment(), TextScenes(WORDS, people_study(), Experiment())
    one, two, three = (question.options[0] for question in WORDS.comprehension.questions[:3])
    line = done("comprehension", 4, item="1").model_copy(
        update={"act": Answers(answers=(WORDS.comprehension.questions[0].right, two, three), rt=1.0), "right": False}
    )
    pages = [done("page", 1 + n, item=str(n)) for n in (1, 2)]
    back = texts.at(journey(JOINED, [*pages, line], experiment, WORDS))
    assert (back.kind, back.number) == ("page", 1)
    assert WORDS.comprehension.questions[1].question in back.notice[0]
    assert WORDS.comprehension.questions[0].question not in back.notice[0]
    assert one != WORDS.comprehension.questions[0].right
    alone = WORDS.model_copy(update={"instructions": ()})  # there is nothing to go back to
    scene = TextScenes(alone, people_study(), experiment).at(journey(JOINED, [line], experiment, alone))
    assert (scene.kind, scene.notice) == ("comprehension", back.notice)


@pytest.mark.parametrize("feedback", [True, False])
@pytest.mark.parametrize("ended", ["solved", "budget", "error"])
def test_practice_says_how_it_ended_and_a_box_where_the_study_does(ended, feedback):
    practice, real = (at(ended, number, feedback=feedback) for number in (0, 1))
    assert (practice.practice, practice.number, practice.title) == (True, 0, WORDS.practice_over.title)
    assert practice.solved == {"solved": True, "budget": False, "error": None}[ended]
    assert real.solved == (practice.solved if feedback else None)
    said = {None: None, True: "You opened it.", False: "You did not open it in 12 steps."}
    for scene in (practice, real):
        assert {text for text in said.values() if text in scene.paragraphs} == {said[scene.solved]} - {None}


def test_a_check_does_not_say_what_is_right_and_a_question_is_as_it_stands():
    over = done("over", 3, box=2)
    check = at("solved", 2, over, **QUESTIONS)
    assert check.model_dump() == {"kind": "check", "question": "Blue?", "options": ("blue", "red")}
    answered = Did(at=13.0, turn=4, scene="check", act=Next(), item="1", right=True)
    ask = at("solved", 2, over, answered, **QUESTIONS)
    assert (ask.name, ask.question, ask.required, ask.options) == ("how", "<b>How?</b>", True, ())
    asked = Did(at=14.0, turn=5, scene="ask", act=Next(), item="how")
    end = at("solved", 2, over, answered, asked, **QUESTIONS)
    assert (end.kind, end.completion_url, end.completion_code) == ("debrief", "https://example.org/x", "C1")


def test_who_declines_withdraws_or_has_no_place_any_more_has_a_way_back():
    ends = {"left_url": "https://example.org/no", "left_code": "LEFT", "completion_code": "C1"}
    texts = TextScenes(WORDS, people_study(), Experiment(**ends))
    for why in ("declined", "full", "late", "screened", "withdrawn"):
        closed = texts.closed(why)
        assert (closed.completion_url, closed.completion_code) == ("https://example.org/no", "LEFT")
    assert texts.closed("taken").completion_code == ""


@pytest.mark.parametrize("asks", [True, False])
def test_the_instructions_show_the_box_and_a_step_and_announce_the_question_where_it_is_asked(asks):
    study = people_study(assessment=asks, modalities=("symbolic",))
    examples = asyncio.run(examples_of(study, WORDS.page))
    first, second = (texts_page(number, study, examples) for number in (1, 2))
    assert (WORDS.instructions[1].if_asked[0] in second.paragraphs) is asks
    assert [(one.panel.last, one.ask) for one in first.examples] == [(None, False)]
    assert [(one.panel.outcome, one.ask) for one in second.examples] == [("moved", asks)]
    assert texts_page(1, study, {}).examples == ()


@pytest.mark.parametrize(
    ("settings", "pictures", "said"),
    [
        ({}, (), "if_at_zero"),
        ({"modalities": ("symbolic?tell=outcome",)}, (), None),
        ({"modalities": ("symbolic?tell=outcome",)}, ("data:x",), "if_start_seen"),
        ({"box": replace(box("chain-4"), initial=(True, False, False, False))}, (), "if_start_seen"),
    ],
)
@pytest.mark.parametrize("language", ["en", "de"])
def test_the_instructions_say_where_joints_are_at_the_start_where_reports_or_pictures_do(
    settings, pictures, said, language
):
    words, study = read_words(language), people_study(**settings)
    ((modality, shown),) = asyncio.run(examples_of(study, WORDS.page)).items()
    shown = shown._replace(before=shown.before.model_copy(update={"pictures": pictures}))
    page = texts_page(1, study, {modality: shown}, words)
    known = {name: getattr(words.instructions[0], name)[0] for name in ("if_at_zero", "if_start_seen")}
    assert [name for name, sentence in known.items() if sentence in page.paragraphs] == ([said] if said else [])


def texts_page(number, study, examples, words=WORDS):
    slots = tuple(Slot(condition=one.label, repetition=1, trial=1) for one in study.conditions)
    joined = JOINED.model_copy(update={"slots": slots})
    way = [done("page", 1 + page, item=str(page)) for page in range(1, number)]
    return TextScenes(words, study, Experiment(), examples).at(journey(joined, [*way], Experiment(), words))


def test_examples_are_shown_of_what_the_participant_will_see_where_the_texts_say():
    study = people_study()
    (shown,) = asyncio.run(examples_of(study, WORDS.page)).values()
    examples = {STATES: shown, "rgb": shown}
    pictures = people_study(modalities=(STATES, "rgb"), plant="fast-twin")
    assert len(texts_page(1, study, examples).examples) == 1
    assert len(texts_page(1, pictures, examples).examples) == 2
    pages = [
        page.model_copy(update={"example": what})
        for page, what in zip(WORDS.instructions, ("none", "box"), strict=True)
    ]
    words = WORDS.model_copy(update={"instructions": tuple(pages)})
    assert texts_page(1, study, examples, words).examples == ()
    assert [one.panel.last for one in texts_page(2, study, examples, words).examples] == [None]


def test_every_way_of_being_closed_has_its_text():
    texts = TextScenes(WORDS, people_study(), Experiment())
    whys = ("declined", "withdrawn", "full", "taken", "late", "screened")
    assert len({(texts.closed(why).why, texts.closed(why).title) for why in whys}) == len(whys)


@pytest.mark.parametrize("p", [(0.0,), (0.0, 0.4)])
def test_who_leaves_or_ends_is_told_that_reports_were_false_where_they_were(p):
    texts = TextScenes(WORDS, people_study(p=p), Experiment())
    way = [done("over", 3 + box, box=box) for box in (0, 1, 2)]
    end = texts.at(journey(JOINED, [*way], Experiment(), WORDS))
    false = any(p)
    assert (admitted(WORDS.debrief.false_reports[0], "false") in end.paragraphs) is false
    for why in ("late", "withdrawn"):
        assert (admitted(WORDS.closed.false_reports[0], "false") in texts.closed(why).paragraphs) is false
    assert len(texts.closed("full").paragraphs) == len(WORDS.closed.full.paragraphs)


def admitted(text, *kinds, words=WORDS):
    """A text with what was changed on purpose."""
    return text.replace("{changes}", " ".join(getattr(words.changes, kind) for kind in kinds))


@pytest.mark.parametrize("language", ["en", "de"])
@pytest.mark.parametrize(
    ("spec", "kinds"),
    [
        ("tremble?p=0.1", ["another"]), ("warn", ["warned"]), ("nudge + drop?p=0.5", []), ("delay", ["late"]),
        ("flip?p=0.4 + tremble?p=0.1", ["false", "another"]),
    ],
)  # fmt: skip
def test_the_end_names_what_the_conditions_did_and_nothing_else(spec, kinds, language):
    words = read_words(language)
    texts = TextScenes(words, under("truth", spec), Experiment())
    way = [done("over", 3 + box, box=box) for box in (0, 1, 2)]
    end = texts.at(journey(JOINED, [*way], Experiment(), words))
    for text, scene in [
        (words.debrief.false_reports[0], end),
        *((words.closed.false_reports[0], texts.closed(why)) for why in ("late", "withdrawn")),
    ]:
        assert (admitted(text, *kinds, words=words) in scene.paragraphs) is bool(kinds)
        said = " ".join(scene.paragraphs)
        assert {kind for kind, sentence in words.changes.model_dump().items() if sentence in said} == set(kinds)


@pytest.mark.parametrize("spec", ["nudge", "warn?rate=0.4", "flip?p=0.4", "tremble?p=1", "drop?p=0.5"])
def test_before_the_end_texts_say_nothing_of_conditions(spec):
    study, true = under("truth", spec), under("truth")
    found = [
        [TextScenes(WORDS, one, Experiment()).consent(2), *(paragraphs_of(number, one) for number in (1, 2))]
        for one in (study, true)
    ]
    assert found[0] == found[1]


def paragraphs_of(number, study):
    return texts_page(number, study, {}).paragraphs


def test_a_degraded_modality_has_the_example_of_the_undegraded_one():
    study = under("rgb", "rgb?blur=8", plant="fast-twin")
    (drawn,) = asyncio.run(examples_of(people_study(), WORDS.page)).values()
    assert len(texts_page(1, study, {"rgb": drawn}).examples) == 1
