"""What participants did is on disk, reads back as it was written, stands behind each step of the record, and goes from
one study to another whole, once, and without what proves who somebody is."""

import shutil

import pytest
from builders import small_study, write_study
from stored import acts, rewrite_acts, sql, written
from taking_part import READ, START, take_part

from lockprobe.foundation.errors import BadFile
from lockprobe.people.diary import Attempt, Did, Joined, Slot, acts_of_steps, read_diaries, take_diaries, write_entry
from lockprobe.studies.records.read_records import load

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
LATE = {"at": 1790000900.0, "scene": "late", "act": None}
BROKEN = {"at": 1790000900.0, "scene": "box", "act": None, "box": 2, "ended": "error"}


@pytest.fixture
def there(tmp_path):
    take_part(tmp_path / "there", STUDY, BOB, [(0.0, 1, 1)], platform={"PID": "x1"}, joined=START + 60)
    take_part(tmp_path / "there", STUDY, ANN, [(0.4, 1, 1), (0.0, 1, 2)], left_after=1)
    return tmp_path / "there"


def test_a_diary_reads_back_as_written_and_ends_when_it_is_deleted(tmp_path):
    lines = [JOINED, Did(at=11.0, turn=2, scene="page", act=READ, item="1"), STEP]
    lines += [Did(turn=turn, **line) for turn, line in ((4, BROKEN), (5, LATE))]
    with written(tmp_path) as store:
        for number, line in enumerate(lines, 1):
            write_entry(store, "3f9a01bc", number, line)
            (read,) = read_diaries(tmp_path)
            assert [read.joined, *read.lines] == lines[:number]
        sql(tmp_path, "delete from act")
        with pytest.raises(BadFile, match="participant 3f9a01bc: the diary was deleted"):
            write_entry(store, "3f9a01bc", len(lines) + 1, STEP)
    assert read_diaries(tmp_path) == []


@pytest.mark.parametrize(("last", "done", "kept"), [(BROKEN, True, 1), (LATE, False, 1), (None, False, 2)])
def test_others_can_play_what_broke_or_was_given_away(there, last, done, kept):
    before = acts(there, ANN)
    rewrite_acts(there, ANN, before if last is None else [*before, last | {"turn": len(before) + 1}])
    ann, bob = read_diaries(there)
    assert (ann.boxes_done, len(ann.slots_kept), ann.late) == (done, kept, last == LATE)
    assert (bob.boxes_done, bob.slots_kept) == (True, [*bob.joined.slots])


def _called(identity):
    return lambda lines: (identity, [lines[0] | {"identity": identity}, *lines[1:]])


@pytest.mark.parametrize(
    ("change", "said"),
    [
        *((_called(name), "participant") for name in ("../evil", "a/b", "ID", "abc", "a" * 33, "x y z")),
        (lambda lines: ("eeee05", lines), "eeee05: an entry is missing, doubled or somebody else's"),
        (lambda lines: (BOB, [*lines[:1], *lines[2:]]), "an entry is missing"),
        (lambda lines: (BOB, [*lines[:4], *lines[3:]]), "missing, doubled"),
        *(
            (lambda lines, change=change: (BOB, change(lines)), "bbbb02: an entry is none: ")
            for change in (
                lambda lines: lines[1:],
                lambda lines: [*lines, lines[0]],
                lambda lines: [*lines, {"kind": "nothing"}],
                lambda lines: [lines[0] | {"at": "late"}, *lines[1:]],
                lambda lines: [lines[0] | {"name": "Bob"}, *lines[1:]],
            )
        ),
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
    given = bob.without_identity()
    assert (given.joined.token, given.joined.platform, given.joined.at) == ("", {}, 0.0)
    assert [did.at for did in given.lines] == [1.5 * did.turn for did in given.lines]
    assert [did.act for did in given.lines] == [did.act for did in bob.lines]
    assert bob.without_identity(platform=True).joined.platform == {"PID": "x1"}
    assert given.without_identity() == given


def behind(directory):
    trials = {trial.key: trial for trial in load(directory)}
    return acts_of_steps(STUDY, trials, read_diaries(directory), directory)


def test_every_step_of_the_record_has_its_act_and_no_other_has(there):
    found = behind(there)
    assert set(found) == {(trial.key, step.step) for trial in load(there) for step in trial.steps}
    for trial in load(there):
        for step in trial.steps:
            act = found[trial.key, step.step]
            assert (act.act.joint, act.act.claimed, act.told) == (step.decision.joint, step.decision.claimed, step.told)
    ann = read_diaries(there)[0]
    assert ann.plan(STUDY, 1).key == "flips/participant/flip?p=0.4/rep=1/trial=1"
    rewrite_acts(there, "cccc03", [acts(there, BOB)[0] | {"identity": "cccc03"}])  # whose box bob played
    assert behind(there) == found


def _act(**change):
    return lambda line: {**line, "act": {**line["act"], **change}}


@pytest.mark.parametrize("change", [_act(joint="D"), _act(claimed="moved")])
def test_a_diary_that_says_something_else_than_the_record_is_refused(there, change):
    lines = acts(there, ANN)
    first = next(i for i, line in enumerate(lines) if line.get("box") == 1 and line["act"].get("joint") != "D")
    lines[first] = change(lines[first])
    rewrite_acts(there, ANN, lines)
    with pytest.raises(BadFile, match=f"study.db: participant {ANN}: the steps of .* are not those on record"):
        behind(there)


@pytest.mark.parametrize("slot", [{"repetition": -1}, {"trial": 3}, {"condition": "flip?p=0.5"}])
def test_a_diary_of_another_study_is_refused(there, slot):
    lines = acts(there, ANN)
    lines[0]["slots"][1] |= slot
    rewrite_acts(there, ANN, lines)
    with pytest.raises(BadFile, match="trials of another study"):
        behind(there)


def taken(here, *sources):
    with written(here) as store:
        return take_diaries(store, sources)


def test_diaries_are_taken_once_of_two_states_the_one_that_is_further_on_and_nobody_elses(there, tmp_path):
    here = write_study(tmp_path / "here", STUDY, load(there))
    less = tmp_path / "less"
    shutil.copytree(there, less)
    rewrite_acts(less, ANN, acts(less, ANN)[:3])
    assert [taken(here, source) for source in (less, there, less, there)] == [[ANN, BOB], [ANN], [], []]
    assert read_diaries(here) == read_diaries(there)
    take_part(tmp_path / "other", STUDY, ANN, [(0.4, 1, 2)])
    with pytest.raises(BadFile, match=f"participant {ANN}: somebody else has this ID"):
        taken(here, tmp_path / "other")
    assert read_diaries(here) == read_diaries(there)
