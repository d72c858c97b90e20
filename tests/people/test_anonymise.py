"""A diary that is given away says what was done and how fast, and not who did it when."""

import pytest
from builders import small_study
from taking_part import START, take_part

from lockprobe.people.anonymise import without_traces
from lockprobe.people.diary import Released
from lockprobe.people.diary_archive import kept_diaries, write_diaries

STUDY = small_study(["participant"], p=[0.0, 0.4], trials=2)
ANN, BOB = "aaaa01", "bbbb02"


@pytest.fixture
def there(tmp_path):
    take_part(tmp_path / "there", STUDY, BOB, [(0.0, 1, 1)], platform={"PID": "x1"}, joined=START + 60)
    take_part(tmp_path / "there", STUDY, ANN, [(0.4, 1, 1), (0.0, 1, 2)], left_after=1)
    return tmp_path / "there"


def test_without_traces_no_token_no_platform_and_no_time_of_day_is_left(there):
    bob = kept_diaries(there)[1]
    given = without_traces(bob)
    assert (given.joined.token, given.joined.platform, given.joined.at) == ("", {}, 0.0)
    assert [act.at for act in given.acts] == [1.5 * act.turn for act in given.acts]
    assert [act.act for act in given.acts] == [act.act for act in bob.acts]
    assert without_traces(bob, platform=True).joined.platform == {"PID": "x1"}
    assert without_traces(given) == given


def test_a_place_that_was_given_away_stays_given_away(there, tmp_path):
    path = there / "people" / f"{ANN}.jsonl"
    with path.open("ab") as file:
        file.write(b'{"kind":"released","at":1790000900.0}\n')
    ann = kept_diaries(there)[0]
    write_diaries(tmp_path / "new", [without_traces(ann)])
    (again,) = kept_diaries(tmp_path / "new")
    assert again.lines[-1] == Released(at=900.0 - 0.25)
    assert again.lines[:-1] == again.acts
