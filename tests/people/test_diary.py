"""What participants did is on disk, reads back as it was written, and can be given away without who did it."""

import pytest
from builders import small_study
from stored import acts, rewrite_acts, sql
from taking_part import START, take_part

from lockprobe.foundation.errors import BadFile
from lockprobe.people.diary import (
    Broken,
    Did,
    Joined,
    Released,
    Slot,
    read_diaries,
    without_identity,
    write_diaries,
    write_entry,
)
from lockprobe.people.journey import Journey
from lockprobe.people.responses import Attempt, Next
from lockprobe.studies.records.store import written

JOINED = Joined(
    identity="3f9a01bc",
    token="0" * 64,
    at=10.5,
    platform={"PROLIFIC_PID": "abc"},
    slots=(Slot(condition="flip?p=0.4", repetition=1, trial=3),),
    words="en 0",
)
STEP = Did(at=12.0, turn=3, scene="box", act=Attempt(joint="B", rt=412.5), box=1, step=1, told="B moved. At 1: B.")
STUDY = small_study(["participant"], p=[0.0, 0.4], trials=2)
ANN, BOB = "aaaa01", "bbbb02"
RELEASED = {"kind": "released", "at": 1790000900.0}


@pytest.fixture
def there(tmp_path):
    take_part(tmp_path / "there", STUDY, BOB, [(0.0, 1, 1)], platform={"PID": "x1"}, joined=START + 60)
    take_part(tmp_path / "there", STUDY, ANN, [(0.4, 1, 1), (0.0, 1, 2)], left_after=1)
    return tmp_path / "there"


def test_a_diary_reads_back_as_written_and_ends_when_it_is_deleted(tmp_path):
    lines = [JOINED, Did(at=11.0, turn=2, scene="page", act=Next(), item="1"), STEP]
    lines += [Broken(at=13.0, turn=4, box=2), Released(at=14.0)]
    with written(tmp_path) as store:
        for number, line in enumerate(lines, 1):
            write_entry(store, "3f9a01bc", number, line)
            (read,) = read_diaries(tmp_path)
            assert [read.joined, *read.lines] == lines[:number]
        sql(tmp_path, "delete from act")
        with pytest.raises(BadFile, match="participant 3f9a01bc: the diary was deleted"):
            write_entry(store, "3f9a01bc", len(lines) + 1, STEP)
    assert read_diaries(tmp_path) == []


def test_diaries_that_are_written_elsewhere_are_the_same_in_the_order_in_which_people_joined(there, tmp_path):
    diaries = read_diaries(there)
    assert [diary.identity for diary in diaries] == [ANN, BOB]
    for _ in range(2):  # a second time in place of the first
        with written(tmp_path) as store:
            write_diaries(store, reversed(diaries))
        assert read_diaries(tmp_path) == diaries


@pytest.mark.parametrize("last", [{"kind": "broken", "at": 1790000900.0, "box": 2}, RELEASED])
def test_over_is_every_box_of_which_nothing_comes_any_more(there, last):
    ann, bob = read_diaries(there)
    assert (Journey.of(ann).closed_boxes, Journey.of(bob).closed_boxes) == ({1}, {1})
    turn = {} if last == RELEASED else {"turn": len(ann.lines) + 2}
    rewrite_acts(there, ANN, [*acts(there, ANN), last | turn])
    assert Journey.of(read_diaries(there)[0]).closed_boxes == {1, 2}


def _called(identity):
    return lambda lines: (identity, [lines[0] | {"identity": identity}, *lines[1:]])


@pytest.mark.parametrize(
    ("change", "said"),
    [
        *((_called(name), "participant") for name in ("../evil", "a/b", "ID", "abc", "a" * 33, "x y z")),
        (lambda lines: ("eeee05", lines), "eeee05: the first entry does not say that this participant joined"),
        (lambda lines: (BOB, lines[1:]), "the first entry does not say that this participant joined"),
        (lambda lines: (BOB, [*lines, lines[0]]), "joins twice"),
        (lambda lines: (BOB, [*lines[:1], *lines[2:]]), "an act is missing"),
        (lambda lines: (BOB, [*lines[:3], *lines[4:]]), "an act is missing"),
        (lambda lines: (BOB, [*lines[:4], *lines[3:]]), "missing or duplicated"),
        (lambda lines: (BOB, [*lines, {"kind": "nothing"}]), "bbbb02: entry 16: "),
        (lambda lines: (BOB, [lines[0] | {"at": "late"}, *lines[1:]]), "bbbb02: entry 1: "),
        (lambda lines: (BOB, [lines[0] | {"name": "Bob"}, *lines[1:]]), "bbbb02: entry 1: "),
    ],
)
def test_what_is_no_diary_is_refused_in_one_line_that_names_the_participant(there, change, said):
    identity, lines = change(acts(there, BOB))
    sql(there, "delete from act where participant = ?", BOB)
    rewrite_acts(there, identity, lines)
    with pytest.raises(BadFile, match=said) as refused:
        read_diaries(there)
    assert str(refused.value).startswith(f"{there / 'study.db'}: participant {identity}: ")
    assert "\n" not in str(refused.value)


def test_without_traces_no_token_no_platform_and_no_time_of_day_is_left(there):
    bob = read_diaries(there)[1]
    given = without_identity(bob)
    assert (given.joined.token, given.joined.platform, given.joined.at) == ("", {}, 0.0)
    assert [act.at for act in given.acts] == [1.5 * act.turn for act in given.acts]
    assert [act.act for act in given.acts] == [act.act for act in bob.acts]
    assert without_identity(bob, platform=True).joined.platform == {"PID": "x1"}
    assert without_identity(given) == given


def test_a_place_that_was_given_away_stays_given_away(there):
    rewrite_acts(there, ANN, [*acts(there, ANN), RELEASED])
    given = without_identity(read_diaries(there)[0])
    assert given.lines[-1] == Released(at=900.0 - 0.25)
    assert given.lines[:-1] == given.acts
