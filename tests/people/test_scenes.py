"""What is read is filled in, and says what the experimenter wants said and no more; an answer is one to its question."""

import pytest
from seated import WORDS, parts, people_study, under

from lockprobe.people.diary import Answers, Attempt, Diary, Did, Joined, Next, Slot
from lockprobe.people.experiment import Experiment, Question
from lockprobe.people.journey import Station, stations
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


def done(scene, act=None, **more):
    return Did(at=12.0, turn=2, scene=scene, act=act or Next(), **more)


def scene(kind, item="", box=0, lines=(), study=None, words=WORDS, **settings):
    """The scene of a station, after these lines."""
    scenes = Scenes(words, study or people_study(), Experiment(**settings))
    return parts(scenes.at(Station(kind, item, box), Diary(JOINED, list(lines))))


def closed(why, study=None, words=WORDS, **settings):
    return parts(Scenes(words, study or people_study(), Experiment(**settings)).closed(why))


def test_everybody_comes_through_all_scenes_in_their_order():
    way = stations(Experiment(**QUESTIONS), WORDS, 2)
    assert [(one.kind, one.item, one.box) for one in way] == [
        ("page", "1", 0), ("page", "2", 0), ("comprehension", "", 0), ("box", "", 0), ("over", "", 0), ("box", "", 1),
        ("over", "", 1), ("box", "", 2), ("over", "", 2), ("check", "1", 0), ("ask", "how", 0), ("debrief", "", 0),
    ]  # fmt: skip


def test_facts_are_filled_in():
    consent, page = parts(Scenes(WORDS, people_study(), Experiment()).consent(6)), scene("page", "2")
    assert (page.number, page.of, page.title) == (2, 2, WORDS.instructions[1].title)
    assert "6" in " ".join(consent.paragraphs)
    assert "12" in " ".join(page.paragraphs)
    assert not [text for one in (consent, page) for text in one.paragraphs if "{" in text]
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
    assert [one.question for one in asked.questions] == [one.question for one in known if one.only != "false_reports"]
    assert set(asked.questions[0]) == {"question", "options"}
    own = {"question": "Blue?", "options": ["blue", "red"], "right": "blue"}
    (mine,) = scene("comprehension", comprehension={"questions": [own]}).questions
    check, ask = scene("check", "1", **QUESTIONS), scene("ask", "how", **QUESTIONS)
    assert mine == {"question": "Blue?", "options": ("blue", "red")}
    assert check == {"kind": "check", **mine}
    assert (ask.name, ask.question, ask.required, ask.options) == ("how", "<b>How?</b>", True, ())


@pytest.mark.parametrize(("ask", "begins"), [(True, [False, False]), (False, [False, True])])
def test_a_page_says_whether_a_box_comes_next(ask, begins):
    assert [scene("page", number, comprehension={"ask": ask}).begins for number in "12"] == begins


@pytest.mark.parametrize("say", [False, True])
def test_what_only_some_studies_say_is_said_there_and_no_where_else(say):
    page, asked = (
        scene("page", "2", say_false=say, study=people_study(assessment=say)),
        scene("comprehension", say_false=say),
    )
    assert (WORDS.instructions[1].if_false[0] in page.paragraphs) is say
    assert (WORDS.instructions[1].if_asked[0] in page.paragraphs) is say
    assert (WORDS.comprehension.questions[-1].question in [one.question for one in asked.questions]) is say


def test_who_answered_wrong_reads_which_question_it_was():
    first, second, third, _ = WORDS.comprehension.questions
    act = Answers(answers=(first.right, second.options[0], third.options[1]), rt=1.0)
    wrong = done("comprehension", act, item="1", right=False)
    back = scene("page", "1", lines=[wrong])
    assert second.question in back.notice[0]
    assert first.question not in back.notice[0]
    alone = scene("comprehension", lines=[wrong], words=WORDS.model_copy(update={"instructions": ()}))
    assert alone.notice == back.notice  # where there is nothing to go back to


def test_every_way_of_being_closed_has_its_text_and_way_back():
    ends = {"left_url": "https://example.org/no", "left_code": "LEFT", "completion_code": "C1"}
    codes = {"declined": "LEFT", "full": "LEFT", "late": "LEFT", "screened": "LEFT", "withdrawn": "LEFT", "taken": "", "finished": "C1"}  # fmt: skip
    assert {why: closed(why, **ends).completion_code for why in codes} == codes
    assert len({closed(why).title for why in codes}) == len(codes)
    end = scene("debrief", **QUESTIONS)
    assert (end.completion_url, end.completion_code) == ("https://example.org/x", "C1")


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
        (words.debrief.false_reports[0], scene("debrief", study=study, words=words)),
        *((words.closed.false_reports[0], closed(why, study, words)) for why in ("late", "withdrawn")),
    ]:
        assert (text.replace("{changes}", changes) in end.paragraphs) is bool(kinds)
        said = " ".join(end.paragraphs)
        assert {kind for kind, sentence in words.changes.items() if sentence in said} == set(kinds)
    assert len(closed("full", study, words).paragraphs) == len(words.closed.full.paragraphs)
    first, true = (
        [Scenes(words, one, Experiment()).consent(2), *(scene("page", n, study=one, words=words) for n in "12")]
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
