"""Diaries go from one study to another whole, once, and without what proves who somebody is."""

import shutil

import pytest
from builders import play_study, small_study, write_study
from stored import acts, rewrite_acts
from taking_part import START, take_part

from lockprobe.foundation.errors import BadFile
from lockprobe.people.diary import read_diaries
from lockprobe.people.experiment import kept_experiment
from lockprobe.people.import_diaries import DiaryImport
from lockprobe.studies.records.journal import Journal
from lockprobe.studies.records.read_records import load

STUDY = small_study(["participant"], p=[0.0, 0.4], trials=2)
ANN, BOB = "aaaa01", "bbbb02"


@pytest.fixture
def there(tmp_path):
    take_part(tmp_path / "there", STUDY, BOB, [(0.0, 1, 1)], platform={"PID": "x1"}, joined=START + 60)
    take_part(tmp_path / "there", STUDY, ANN, [(0.4, 1, 1), (0.0, 1, 2)], left_after=1)
    return tmp_path / "there"


def arriving(directory, *sources):
    return DiaryImport(directory, {source: load(source) for source in sources})


def taken(here, *sources):
    with Journal.open(here, STUDY) as journal:
        return arriving(here, *sources).take(journal)


def by_key(directory):
    return {trial.key: trial for trial in load(directory)}


def test_diaries_are_taken_once_and_nobody_can_go_on_with_them(there, tmp_path):
    here = write_study(tmp_path / "here", STUDY, load(there))
    here.chmod(0o755)
    assert taken(here, there) == 2
    assert here.stat().st_mode & 0o777 == 0o700
    assert [kept.lines for kept in read_diaries(here)] == [kept.lines for kept in read_diaries(there)]
    assert {kept.joined.token for kept in read_diaries(here)} == {""}
    assert taken(here, there) == 0


def test_of_two_states_of_one_diary_the_one_that_is_further_on_is_kept(there, tmp_path):
    here = write_study(tmp_path / "here", STUDY, load(there))
    whole = acts(there, ANN)
    rewrite_acts(here, ANN, whole[:3])
    assert taken(here, there) == 2
    assert acts(here, ANN) == whole
    rewrite_acts(there, ANN, whole[:3])
    assert taken(here, there) == 0
    assert acts(here, ANN) == whole


def test_two_people_with_one_id_are_refused_before_anything_is_written(there, tmp_path):
    here = tmp_path / "here"
    take_part(here, STUDY, ANN, [(0.4, 2, 1)])
    before = acts(here, ANN)
    with pytest.raises(BadFile, match=f"its participant {ANN}"):
        arriving(here, there)
    assert acts(here, ANN) == before


def test_whose_trials_were_all_played_by_others_here_stays_away_and_who_only_left_comes(there, tmp_path):
    take_part(tmp_path / "there", STUDY, "cccc03", [(0.0, 2, 2)], left_after=1)
    here = tmp_path / "here"
    take_part(here, STUDY, "dddd04", [(0.0, 1, 1)])
    assert taken(here, there) == 1  # cccc03: ann and bob have trials there, and none here
    assert {kept.joined.identity for kept in read_diaries(here)} == {"cccc03", "dddd04"}


def test_the_settings_come_along_where_there_are_none(there, tmp_path):
    here = write_study(tmp_path / "here", STUDY, load(there))
    (there / "people").mkdir()
    (there / "people" / "experiment.json").write_text('{"feedback": true}')
    taken(here, there)
    assert kept_experiment(here).feedback
    assert kept_experiment(tmp_path) is None


def test_a_study_without_people_has_no_diaries(tmp_path):
    study = small_study(["random"], trials=1)
    here = write_study(tmp_path / "here", study, play_study(study))
    assert read_diaries(here) == []
    with Journal.open(here, study) as journal:
        assert arriving(here, write_study(tmp_path / "other", study)).take(journal) == 0
    assert not (here / "people").exists()


def test_diaries_of_another_study_are_refused(there, tmp_path):
    settings = there / "study.json"
    settings.write_text(settings.read_text().replace('"trials": 2', '"trials": 1'))
    with pytest.raises(BadFile, match="trials of another study"):
        arriving(tmp_path / "here", there)


def state(directory, tmp_path, name, lines):
    """A copy of a study in which ann has come only so far."""
    copy = tmp_path / name
    shutil.copytree(directory, copy)
    rewrite_acts(copy, ANN, acts(copy, ANN)[:lines])
    return copy


def test_somebody_who_is_further_on_elsewhere_stays_here_who_they_are(there, tmp_path):
    here = state(there, tmp_path, "here", 3)
    ann = read_diaries(there)[0]
    assert taken(here, there) == 1
    (again,) = (kept for kept in read_diaries(here) if kept.joined.identity == ANN)
    assert again.joined == ann.joined
    assert again.joined.token
    assert again.lines == ann.lines


def test_of_two_sources_the_further_one_goes_on_from_the_first(there, tmp_path):
    beginning = state(there, tmp_path, "beginning", 3)
    ann = read_diaries(there)[0]
    here = tmp_path / "here"
    assert taken(write_study(here, STUDY, load(there)), beginning, there) == 2
    again = read_diaries(here)[0]
    assert (again.joined, again.lines) == (ann.joined.model_copy(update={"token": ""}), ann.lines)


def test_boxes_of_people_here_that_were_played_by_those_who_came_are_counted(there, tmp_path):
    here = tmp_path / "here"
    take_part(here, STUDY, "dddd04", [(0.4, 1, 1)], left_after=0)  # ann's first
    take_part(here, STUDY, "eeee05", [(0.0, 2, 1), (0.0, 1, 1)], left_after=1)  # bob's
    take_part(here, STUDY, "ffff06", [(0.4, 2, 2)], left_after=1)  # nobody's
    diaries = arriving(here, there)
    assert diaries.lost(by_key(here)) == 0
    now = by_key(here) | by_key(there)
    assert diaries.lost(now) == 2
    rewrite_acts(here, "eeee05", [*acts(here, "eeee05"), {"kind": "released", "at": 1790000900.0}])
    assert arriving(here, there).lost(now) == 1
