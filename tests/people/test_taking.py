"""Diaries go from one study to another whole, once, and without what proves who somebody is."""

import pytest
from builders import play_study, small_study, write_study
from taking_part import START, take_part

from lockprobe.errors import BadFile
from lockprobe.people.diary import Released
from lockprobe.people.taking import Arriving, kept_diaries, kept_experiment, without_traces, write_diaries
from lockprobe.studies.journal import load

STUDY = small_study(["participant"], p=[0.0, 0.4], trials=2)
ANN, BOB = "aaaa01", "bbbb02"


@pytest.fixture
def there(tmp_path):
    take_part(tmp_path / "there", STUDY, BOB, [(0.0, 1, 1)], platform={"PID": "x1"}, joined=START + 60)
    take_part(tmp_path / "there", STUDY, ANN, [(0.4, 1, 1), (0.0, 1, 2)], left_after=1)
    return tmp_path / "there"


def arriving(directory, *sources):
    return Arriving(directory, {source: load(source) for source in sources})


def by_key(directory):
    return {trial.key: trial for trial in load(directory)}


def test_diaries_are_read_in_the_order_in_which_people_joined(there):
    assert [kept.joined.identity for kept in kept_diaries(there)] == [ANN, BOB]


def test_without_traces_no_token_no_platform_and_no_time_of_day_is_left(there):
    bob = kept_diaries(there)[1]
    given = without_traces(bob)
    assert (given.joined.token, given.joined.platform, given.joined.at) == ("", {}, 0.0)
    assert [act.at for act in given.acts] == [1.5 * act.turn for act in given.acts]
    assert [act.act for act in given.acts] == [act.act for act in bob.acts]
    assert without_traces(bob, platform=True).joined.platform == {"PID": "x1"}
    assert without_traces(given) == given


def test_what_is_written_reads_back(there, tmp_path):
    diaries = kept_diaries(there)
    write_diaries(tmp_path / "new", diaries)
    assert kept_diaries(tmp_path / "new") == diaries


def test_a_place_that_was_given_away_stays_given_away(there, tmp_path):
    path = there / "people" / f"{ANN}.jsonl"
    with path.open("ab") as file:
        file.write(b'{"kind":"released","at":1790000900.0}\n')
    ann = kept_diaries(there)[0]
    write_diaries(tmp_path / "new", [without_traces(ann)])
    (again,) = kept_diaries(tmp_path / "new")
    assert again.lines[-1] == Released(at=900.0 - 0.25)
    assert again.lines[:-1] == again.acts


def test_diaries_are_taken_once_and_nobody_can_go_on_with_them(there, tmp_path):
    here = write_study(tmp_path / "here", STUDY, load(there))
    assert arriving(here, there).take(by_key(here)) == 2
    assert [kept.lines for kept in kept_diaries(here)] == [kept.lines for kept in kept_diaries(there)]
    assert {kept.joined.token for kept in kept_diaries(here)} == {""}
    assert arriving(here, there).take(by_key(here)) == 0


def test_of_two_states_of_one_diary_the_one_that_is_further_on_is_kept(there, tmp_path):
    here = write_study(tmp_path / "here", STUDY, load(there))
    whole = (there / "people" / f"{ANN}.jsonl").read_bytes()
    beginning = b"".join(whole.splitlines(keepends=True)[:3])
    (here / "people").mkdir()
    (here / "people" / f"{ANN}.jsonl").write_bytes(beginning)
    assert arriving(here, there).take(by_key(here)) == 2
    assert len(kept_diaries(here)[0].acts) == whole.count(b"\n") - 1
    (there / "people" / f"{ANN}.jsonl").write_bytes(beginning)
    assert arriving(here, there).take(by_key(here)) == 0
    assert len(kept_diaries(here)[0].acts) == whole.count(b"\n") - 1


def test_two_people_with_one_id_are_refused_before_anything_is_written(there, tmp_path):
    here = tmp_path / "here"
    take_part(here, STUDY, ANN, [(0.4, 2, 1)])
    before = (here / "people" / f"{ANN}.jsonl").read_bytes()
    with pytest.raises(BadFile, match=f"another participant than the {ANN}"):
        arriving(here, there)
    assert (here / "people" / f"{ANN}.jsonl").read_bytes() == before


def test_whose_trials_were_all_played_by_others_here_stays_away_and_who_only_left_comes(there, tmp_path):
    take_part(tmp_path / "there", STUDY, "cccc03", [(0.0, 2, 2)], left_after=1)
    here = tmp_path / "here"
    take_part(here, STUDY, "dddd04", [(0.0, 1, 1)])
    assert arriving(here, there).take(by_key(here)) == 1  # cccc03: ann and bob have trials there, and none here
    assert {kept.joined.identity for kept in kept_diaries(here)} == {"cccc03", "dddd04"}


def test_the_settings_come_along_where_there_are_none(there, tmp_path):
    here = write_study(tmp_path / "here", STUDY, load(there))
    (there / "people" / "experiment.json").write_text('{"view": "text"}')
    arriving(here, there).take(by_key(here))
    assert kept_experiment(here).view == "text"
    assert kept_experiment(tmp_path) is None


@pytest.mark.parametrize("text", ["{", "[]", '{"view": "film"}', "[" * 100_000])
def test_settings_that_are_none_are_refused(there, text):
    (there / "people" / "experiment.json").write_text(text)
    with pytest.raises(BadFile):
        kept_experiment(there)


@pytest.mark.parametrize("identity", ["../evil", "a/b", "ID", "abc", "a" * 33, "x y z"])
def test_no_name_of_a_file_is_taken_from_a_diary(there, identity):
    path = there / "people" / f"{BOB}.jsonl"
    path.write_bytes(path.read_bytes().replace(BOB.encode(), identity.encode()))
    with pytest.raises(BadFile, match="participant"):
        kept_diaries(there)


def test_a_diary_under_another_name_or_with_two_people_is_refused(there):
    path = there / "people" / f"{BOB}.jsonl"
    moved = path.rename(path.with_name("eeee05.jsonl"))
    with pytest.raises(BadFile, match="another participant"):
        kept_diaries(there)
    moved.rename(path)
    path.write_bytes(path.read_bytes() + path.read_bytes().splitlines(keepends=True)[0])
    with pytest.raises(BadFile, match="joins twice"):
        kept_diaries(there)


def test_a_study_without_people_has_no_diaries(tmp_path):
    study = small_study(["random"], trials=1)
    here = write_study(tmp_path / "here", study, play_study(study))
    assert kept_diaries(here) == []
    assert arriving(here, write_study(tmp_path / "other", study)).take(by_key(here)) == 0
    assert not (here / "people").exists()


def test_diaries_of_another_study_are_refused(there, tmp_path):
    settings = there / "study.json"
    settings.write_text(settings.read_text().replace('"trials": 2', '"trials": 1'))
    with pytest.raises(BadFile, match="trials of another study"):
        arriving(tmp_path / "here", there)
