"""Where somebody stands follows from the diary."""

from lockprobe.people.diary import Broken, Diary, Did, Joined, Released, Slot
from lockprobe.people.experiment import Experiment
from lockprobe.people.journey import Journey, Station, fingerprint, stations
from lockprobe.people.responses import Agree, Answer, Answers, Attempt, Next
from lockprobe.people.texts import read_words

WORDS = read_words("en")
CHECK = {"question": "Blue?", "options": ["blue", "red"], "right": "blue"}
EXPERIMENT = Experiment(
    checks=[CHECK | {"after": 1}, CHECK | {"after": 0}, CHECK | {"after": 1}],
    questions=[{"name": "how", "question": "How?"}],
)
SLOTS = tuple(Slot(condition=label, repetition=1, trial=n) for n, label in enumerate(("truth", "flip?p=0.4"), 1))
JOINED = Joined(identity="3f9a01bc", token="0" * 64, at=10.0, platform={}, slots=SLOTS, words="en 0")


def diary(*acts):
    """A diary of acts, each a scene, an act and what else is known of it."""
    lines = [
        Did(at=10.0 + turn, turn=turn, scene=scene, act=act, **more) for turn, (scene, act, more) in enumerate(acts, 2)
    ]
    return Diary(JOINED, tuple(lines))


def step(box, number, ended=None, joint="A"):
    act = Attempt(joint=joint, claimed="moved" if number > 1 else None, rt=1.0)
    return "box", act, {"box": box, "step": number, "told": f"{joint} moved.", "ended": ended}


PAGES = [("page", Next(), {"item": str(number)}) for number in (1, 2)]
UNDERSTOOD = ("comprehension", Answers(answers=("a",), rt=1.0), {"item": "1", "right": True})
PRACTICE = [step(0, 1), step(0, 2, "solved"), ("over", Next(), {"box": 0})]
ANSWER = Answer(answer="blue", rt=1.0)


def journey(*acts, words=WORDS, experiment=EXPERIMENT):
    return Journey.of(diary(*acts), stations(experiment, words, len(SLOTS)))


def test_the_way_is_walked_from_one_end_to_the_other():
    way = stations(EXPERIMENT, WORDS, 2)
    assert [(one.kind, one.item, one.box) for one in way] == [
        ("page", "1", 0), ("page", "2", 0), ("comprehension", "", 0), ("box", "", 0), ("over", "", 0), ("check", "2", 0), ("box", "", 1),
        ("over", "", 1), ("check", "1", 0), ("check", "3", 0), ("box", "", 2), ("over", "", 2), ("ask", "how", 0),
        ("debrief", "", 0),
    ]  # fmt: skip
    assert [one.kind for one in stations(Experiment(practice="", comprehension={"ask": False}), WORDS, 1)] == [
        "page",
        "page",
        "box",
        "over",
        "debrief",
    ]


def test_it_stands_after_what_was_done_last():
    acts = [
        *PAGES, UNDERSTOOD, *PRACTICE, ("check", ANSWER, {"item": "2", "right": True}), step(1, 1), step(1, 2, "budget"),
        ("over", Next(), {"box": 1}), ("check", ANSWER, {"item": "1", "right": True}),
        ("check", ANSWER, {"item": "3", "right": False}), step(2, 1, "solved"), ("over", Next(), {"box": 2}),
        ("ask", ANSWER, {"item": "how"}),
    ]  # fmt: skip
    way = iter(stations(EXPERIMENT, WORDS, 2))
    expected = next(way)
    for number in range(len(acts) + 1):
        stands = journey(*acts[:number])
        assert stands.station == expected
        assert stands.turn == number + 2
        assert stands.last == (acts[number - 1][1] if number else Agree(agreed=True))
        if number < len(acts) and (acts[number][0] != "box" or acts[number][2]["ended"]):
            expected = next(way)
    assert stands.finished
    assert stands.boxes_done
    assert (stands.endings, stands.practised, stands.checks) == (
        {1: "budget", 2: "solved"},
        "solved",
        [True, True, False],
    )


def test_the_steps_of_the_box_that_is_under_way_are_known_and_when_it_began():
    stands = journey(*PAGES, step(0, 1, joint="B"))
    assert [(did.act.joint, did.told) for did in stands.played] == [("B", "B moved.")]
    assert stands.box_began == 13.0
    assert journey(*PAGES, *PRACTICE).played == ()


def test_what_broke_is_over_and_is_owed_again():
    stands = journey(*PAGES, *PRACTICE, ("check", ANSWER, {"item": "2", "right": True}))
    stands.follow(Broken(at=20.0, turn=8, box=1))
    assert stands.station == Station("over", box=1)
    assert (stands.turn, stands.last, stands.endings) == (9, None, {1: "error"})
    assert stands.slots_kept == SLOTS[1:]
    again = journey(*PAGES, *PRACTICE, ("check", ANSWER, {"item": "2", "right": True}), step(1, 1, "error"))
    assert (again.station, again.slots_kept) == (Station("over", box=1), SLOTS[1:])


def test_whose_place_was_given_away_keeps_what_is_finished():
    played = [*PAGES, *PRACTICE, ("check", ANSWER, {"item": "2", "right": True}), step(1, 1, "solved")]
    stands = journey(*played)
    stands.follow(Released(at=99.0))
    assert (stands.released, stands.slots_kept) == (True, SLOTS[:1])
    assert journey(*played).slots_kept == SLOTS


def test_without_the_way_all_but_the_station_is_known():
    played = [*PAGES, *PRACTICE, ("check", ANSWER, {"item": "2", "right": True}), step(1, 1, "solved"), step(2, 1)]
    whole, alone = journey(*played), Journey.of(diary(*played))
    for fact in ("turn", "last", "at", "endings", "practised", "checks", "released", "slots_kept", "boxes_done"):
        assert getattr(alone, fact) == getattr(whole, fact)


def test_texts_that_were_edited_in_between_move_nobody():
    shorter = WORDS.model_copy(update={"instructions": WORDS.instructions[:1]})
    longer = WORDS.model_copy(update={"instructions": (*WORDS.instructions, *WORDS.instructions)})
    for words in (shorter, longer):
        assert journey(*PAGES, step(0, 1), words=words).station == Station("box")
        assert journey(*PAGES, *PRACTICE, words=words).station == Station("check", "2")
    assert journey(*PAGES, words=shorter).station == Station("comprehension")


def test_wrong_answers_lead_back_to_the_first_page_and_every_round_is_counted():
    wrong = [("comprehension", Answers(answers=("b",), rt=1.0), {"item": str(n), "right": False}) for n in (1, 2)]
    back = journey(*PAGES, wrong[0])
    assert (back.station, back.rounds, back.misread.answers) == (Station("page", "1"), 1, ("b",))
    again = journey(*PAGES, wrong[0], *PAGES, wrong[1], *PAGES)
    assert (again.station, again.rounds) == (Station("comprehension"), 2)
    through = journey(*PAGES, wrong[0], *PAGES, UNDERSTOOD)
    assert (through.station, through.rounds, through.misread, through.checks) == (Station("box"), 2, None, [])


def test_the_share_of_the_way_grows_from_none_to_all_of_it():
    acts = [*PAGES, UNDERSTOOD, *PRACTICE, ("check", ANSWER, {"item": "2", "right": True}), step(1, 1, "budget")]
    acts += [("over", Next(), {"box": 1}), *(("check", ANSWER, {"item": n, "right": True}) for n in "13")]
    acts += [step(2, 1, "solved"), ("over", Next(), {"box": 2}), ("ask", ANSWER, {"item": "how"})]
    shares = [journey(*acts[:number]).share for number in range(len(acts) + 1)]
    assert (shares[0], shares[-1], shares) == (0.0, 1.0, sorted(shares))
    assert len(set(shares)) == len(acts)  # a step within the practice moves nobody


def test_a_fingerprint_changes_with_any_text():
    assert fingerprint(WORDS).startswith("en ")
    assert fingerprint(WORDS) == fingerprint(read_words("en"))
    assert fingerprint(WORDS) != fingerprint(WORDS.model_copy(update={"title": "Another"}))
