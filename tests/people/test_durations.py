"""How long a pilot took, and who of it counts."""

import tomllib

from seated import people_study
from taking_part import take_part

from lockprobe.people.diary import read_diaries
from lockprobe.people.durations import Durations, durations_of, has_finished, seconds_of
from lockprobe.people.experiment import Experiment, Minutes, experiment_from

ASKED = {"name": "how", "question": "How?"}


def pilot(directory, *left_after):
    """People of whom each plays one box to the end, or leaves after so many steps."""
    study = people_study()
    for number, left in enumerate(left_after):
        take_part(directory, study, f"aaaaaaa{number}", [(0.0, 1, number + 1)], left_after=left)
    return read_diaries(directory)


def test_only_those_who_finished_are_counted(tmp_path):
    diaries = pilot(tmp_path, None, 1, None)
    assert [has_finished(one, Experiment()) for one in diaries] == [True, False, True]
    assert durations_of(diaries, None).people == 2
    assert durations_of(diaries, Experiment(questions=[ASKED])) is None  # which nobody was asked
    assert durations_of((), None) is None


def test_the_median_and_the_range_are_in_whole_minutes(tmp_path):
    diaries = pilot(tmp_path, None, None, None)
    slower = [
        type(one)(one.joined, tuple(line.model_copy(update={"at": one.joined.at + seconds}) for line in one.lines))
        for one, seconds in zip(diaries, (599.0, 750.0, 1021.0), strict=True)
    ]
    assert [seconds_of(one) for one in slower] == [599.0, 750.0, 1021.0]
    found = durations_of(slower, None)
    assert found == Durations(people=3, median=12, low=9, high=18)


def test_the_line_that_is_printed_can_be_put_into_the_file(tmp_path):
    line = Durations(people=5, median=12, low=9, high=17).setting
    assert experiment_from(tomllib.loads(line), tmp_path).minutes == Minutes(median=12, low=9, high=17)
