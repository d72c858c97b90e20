"""What is read is filled in, and says what the experimenter wants said and no more; an answer is one to its question."""

import asyncio
from dataclasses import replace

import pytest
from seated import WORDS, parts, people_study, under

from lockprobe.boxes.families import box
from lockprobe.people.diary import Answers, Attempt, Diary, Did, Joined, Next, Slot
from lockprobe.people.experiment import Experiment, Question
from lockprobe.people.journey import Journey, stations
from lockprobe.people.practice import examples_of
from lockprobe.people.scenes import Scenes, fits
from lockprobe.people.texts import read_words

SLOTS = tuple(Slot(condition="truth", repetition=1, trial=n) for n in (1, 2))
JOINED = Joined(identity="3f9a01bc", token="0" * 64, at=10.0, platform={}, slots=SLOTS, words="en 0")
QUESTIONS = {
    "checks": [{"after": 2, "question": "Blue?", "options": ["blue", "red"], "right": "blue"}],
    "questions": [{"name": "how", "question": "<b>How?</b>", "required": True}],
    "completion_url": "https://example.org/x",
    "completion_code": "C1",
}


def done(scene, number, act=None, **more):
    return Did(at=12.0, turn=number, scene=scene, act=act or Next(), **more)


def ended(how, box):
    return done("box", 2, Attempt(joint="A", rt=1.0), box=box, step=1, ended=how)


READ = [done("page", 1 + n, item=str(n)) for n in (1, 2)]
OVER = [done("over", 3 + box, box=box) for box in (0, 1, 2)]


def scene(*lines, study=None, words=WORDS, examples=None, joined=JOINED, **settings):
    """The scene after these lines."""
    study, experiment = study or people_study(), Experiment(**settings)
    journey = Journey.of(Diary(joined, lines), stations(experiment, words, len(joined.slots)))
    return parts(Scenes(words, study, experiment, examples).at(journey))


def closed(why, study=None, words=WORDS, **settings):
    return parts(Scenes(words, study or people_study(), Experiment(**settings)).closed(why))


def test_facts_are_filled_in():
    consent = parts(Scenes(WORDS, people_study(), Experiment()).consent(6))
    page = scene(READ[0])
    assert (page.number, page.of, page.title) == (2, 2, WORDS.instructions[1].title)
    assert "6" in " ".join(consent.paragraphs)
    assert "12" in " ".join(page.paragraphs)
    assert not [text for one in (consent, page) for text in one.paragraphs if "{" in text]
    words = WORDS.model_copy(update={"debrief": WORDS.debrief.model_copy(update={"title": "{boxes} {joints} {other}"})})
    assert scene(*OVER, words=words).title == "2 4 {other}"


@pytest.mark.parametrize("feedback", [True, False])
@pytest.mark.parametrize(("how", "opened"), [("solved", True), ("budget", False), ("error", None)])
def test_practice_says_how_it_ended_and_a_box_where_the_study_does(how, opened, feedback):
    practice, real = (scene(ended(how, number), feedback=feedback) for number in (0, 1))
    assert (practice.practice, practice.number, practice.of, practice.title) == (True, 0, 2, WORDS.practice_over.title)
    assert (practice.solved, real.solved) == (opened, opened if feedback else None)
    assert (real.practice, real.number) == (False, 1)
    said = {None: None, True: "You opened it.", False: "You did not open it in 12 steps."}
    for one in (practice, real):
        assert {text for text in said.values() if text in one.paragraphs} == {said[one.solved]} - {None}


def test_the_questions_on_the_instructions_do_not_say_what_is_right():
    asked, known = scene(*READ), WORDS.comprehension.questions
    assert asked.kind == "comprehension"
    assert [one.question for one in asked.questions] == [one.question for one in known if one.only != "false_reports"]
    assert set(asked.questions[0]) == {"question", "options"}
    own = {"question": "Blue?", "options": ["blue", "red"], "right": "blue"}
    assert [one.question for one in scene(*READ, comprehension={"questions": [own]}).questions] == ["Blue?"]


@pytest.mark.parametrize(("ask", "begins"), [(True, [False, False]), (False, [False, True])])
def test_a_page_says_whether_a_box_comes_next(ask, begins):
    assert [scene(*READ[:number], comprehension={"ask": ask}).begins for number in (0, 1)] == begins


@pytest.mark.parametrize("say_false", [False, True])
def test_that_reports_can_be_wrong_is_said_and_asked_only_where_the_study_says_so(say_false):
    page, asked = scene(READ[0], say_false=say_false), scene(*READ, say_false=say_false)
    assert (WORDS.instructions[1].if_false[0] in page.paragraphs) is say_false
    assert (WORDS.comprehension.questions[-1].question in [one.question for one in asked.questions]) is say_false


def test_who_answered_wrong_reads_which_question_it_was():
    first, second, third, _ = WORDS.comprehension.questions
    act = Answers(answers=(first.right, second.options[0], third.options[1]), rt=1.0)
    back = scene(*READ, wrong := done("comprehension", 4, act, item="1", right=False))
    assert (back.kind, back.number) == ("page", 1)
    assert second.question in back.notice[0]
    assert first.question not in back.notice[0]
    alone = scene(wrong, words=WORDS.model_copy(update={"instructions": ()}))  # there is nothing to go back to
    assert (alone.kind, alone.notice) == ("comprehension", back.notice)


def test_a_check_does_not_say_what_is_right_and_a_question_is_as_it_stands():
    check = scene(*OVER, **QUESTIONS)
    assert check == {"kind": "check", "question": "Blue?", "options": ("blue", "red")}
    ask = scene(*OVER, answered := done("check", 6, item="1", right=True), **QUESTIONS)
    assert (ask.name, ask.question, ask.required, ask.options) == ("how", "<b>How?</b>", True, ())
    end = scene(*OVER, answered, done("ask", 7, item="how"), **QUESTIONS)
    assert (end.kind, end.completion_url, end.completion_code) == ("debrief", "https://example.org/x", "C1")


def test_every_way_of_being_closed_has_its_text_and_way_back():
    ends = {"left_url": "https://example.org/no", "left_code": "LEFT", "completion_code": "C1"}
    codes = {"declined": "LEFT", "full": "LEFT", "late": "LEFT", "screened": "LEFT", "withdrawn": "LEFT", "taken": "", "finished": "C1"}  # fmt: skip
    assert {why: closed(why, **ends).completion_code for why in codes} == codes
    assert len({closed(why).title for why in codes}) == len(codes)


def of_page(number, study, examples, words=WORDS):
    slots = tuple(Slot(condition=one.label, repetition=1, trial=1) for one in study.conditions)
    joined = JOINED.model_copy(update={"slots": slots})
    return scene(*READ[: number - 1], study=study, words=words, examples=examples, joined=joined)


@pytest.mark.parametrize("asks", [True, False])
def test_the_instructions_show_the_box_and_a_step_where_the_texts_say_and_announce_the_question(asks):
    study = people_study(assessment=asks, modalities=("symbolic",))
    examples = asyncio.run(examples_of(study, WORDS.page))
    first, second = (of_page(number, study, examples) for number in (1, 2))
    assert (WORDS.instructions[1].if_asked[0] in second.paragraphs) is asks
    assert [(one.panel.last, one.ask) for one in first.examples] == [(None, False)]
    assert [(one.panel.outcome, one.ask) for one in second.examples] == [("moved", asks)]
    assert of_page(1, study, {}).examples == ()
    one, two = WORDS.instructions

    def shown(*pages):
        words = WORDS.model_copy(update={"instructions": pages})
        return [
            [example.panel.last for example in of_page(n, study, examples, words).examples]
            for n in (1, 2)[: len(pages)]
        ]

    other = [one.model_copy(update={"example": "none"}), two.model_copy(update={"example": "box"})]
    assert shown(*other) == [[], [None]]
    assert shown(one) == [[second.examples[0].panel.last]]


def test_examples_are_in_each_modality_that_the_participant_will_see_undegraded():
    drawn = asyncio.run(examples_of(people_study(), WORDS.page))
    (state, shown), *_ = drawn.items()
    examples = {state: shown, "rgb": shown}
    assert len(of_page(1, people_study(), examples).examples) == 1
    assert len(of_page(1, people_study(modalities=(state, "rgb"), plant="fast-twin"), examples).examples) == 2
    assert len(of_page(1, under("rgb", "rgb?blur=8", plant="fast-twin"), examples).examples) == 1


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
    ((modality, (before, after)),) = asyncio.run(examples_of(study, WORDS.page)).items()
    page = of_page(1, study, {modality: (before | {"pictures": pictures}, after)}, words)
    known = {name: getattr(words.instructions[0], name)[0] for name in ("if_at_zero", "if_start_seen")}
    assert [name for name, sentence in known.items() if sentence in page.paragraphs] == ([said] if said else [])


@pytest.mark.parametrize("language", ["en", "de"])
@pytest.mark.parametrize(
    ("spec", "kinds"),
    [
        ("flip?p=0", []), ("nudge + drop?p=0.5", []), ("tremble?p=0.1", ["another"]), ("warn", ["warned"]),
        ("delay", ["late"]), ("flip?p=0.4 + tremble?p=0.1", ["false", "another"]),
    ],
)  # fmt: skip
def test_the_end_names_what_the_conditions_did_and_nothing_else_and_nothing_is_said_before(spec, kinds, language):
    words, study = read_words(language), under("truth", spec)
    changes = " ".join(words.changes[kind] for kind in kinds)
    for text, end in [
        (words.debrief.false_reports[0], scene(*OVER, study=study, words=words)),
        *((words.closed.false_reports[0], closed(why, study, words)) for why in ("late", "withdrawn")),
    ]:
        assert (text.replace("{changes}", changes) in end.paragraphs) is bool(kinds)
        said = " ".join(end.paragraphs)
        assert {kind for kind, sentence in words.changes.items() if sentence in said} == set(kinds)
    assert len(closed("full", study, words).paragraphs) == len(words.closed.full.paragraphs)
    first, true = (
        [Scenes(words, one, Experiment()).consent(2), *(of_page(number, one, {}, words) for number in (1, 2))]
        for one in (study, under("truth"))
    )
    assert first == true


AGE, NUMBER = {"type": "integer", "low": 18, "high": 120}, {"type": "number"}


@pytest.mark.parametrize(
    ("question", "taken", "refused"),
    [
        (AGE, ["18", " 34 ", "120", "+40", ""], ["banana", "1e9", "nan", "inf", "17", "121", "18.5", "-20", "0x20", "१८", "1_8", "9" * 40]),
        (NUMBER, ["1.5", "1,5", "-3"], ["1.5.2", "one"]),
        ({"required": True}, ["banana"], ["", " "]),
        ({"options": ("a", "b")}, ["a", ""], ["c", " a"]),
    ],
)  # fmt: skip
def test_an_answer_is_one_to_its_question(question, taken, refused):
    asked = Question(name="age", question="?", **question)
    assert [answer for answer in (*taken, *refused) if fits(asked, answer)] == taken
