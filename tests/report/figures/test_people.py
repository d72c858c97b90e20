"""People, models and strategies in one figure: the marks lie where the numbers are."""

from dataclasses import replace

import pytest
from builders import SOLUTION, make_trial, small_study, write_study

from lockprobe.interventions.conditions import read_condition
from lockprobe.report.figures.people import people
from lockprobe.report.opened import open_study
from lockprobe.report.results import results_of
from lockprobe.report.study_numbers import study_numbers

P = (0.0, 0.4)
NAMES = {"people": "participant", "random": "random"}


@pytest.fixture
def study(tmp_path):
    """``study(people=…, a=…)``: ten boxes at each p, solved after so many blocked steps; None for never."""

    def make(**waits):
        trials = []
        for name, both in waits.items():
            for p, wait in zip(P, both, strict=True):
                for i in range(10):
                    joints = (0,) * 20 if wait is None else (*(0,) * wait, *SOLUTION)
                    agent = f"participant:{i:04d}" if name == "people" else NAMES.get(name, f"llm:{name}")
                    trials.append(make_trial(joints, agent=agent, p=p, trial=i + 1))
        planned = small_study([NAMES.get(name, f"llm:{name}") for name in waits], P, 1, 10)
        return results_of(study_numbers(open_study(write_study(tmp_path / "study", planned, trials))))

    return make


def texts(axes):
    return " ".join([axes.get_title(loc="left"), *(text.get_text() for text in axes.texts)])


def joined(axes):
    """The shares of every agent, as their line goes through them."""
    return [list(line.get_ydata()) for line in axes.lines if len({*line.get_xdata()}) == 2]


def test_shares_of_people_and_agents_stand_at_their_p(study):
    (axes,) = people(study(people=(0, None), a=(0, 0))).axes
    assert joined(axes) == [[1.0, 0.0], [1.0, 1.0]]
    assert axes.get_legend_handles_labels()[1] == ["people", "llm:a"]
    assert "10 people with 2 boxes each" in texts(axes)


@pytest.fixture
def beside_flips(tmp_path):
    """Ten boxes of people and of two agents under the truth, a nudged flip rate and other words."""
    waits = {"participant": (4, 4, None), "llm:a": (12, 0, 4), "random": (None, 4, 4)}
    planned = replace(small_study(list(waits), P, 1, 10), conditions=tuple(map(read_condition, CONDITIONS)))
    trials = []
    for agent, own in waits.items():
        for condition, wait in zip(planned.conditions, own, strict=True):
            for i in range(10):
                who = f"participant:{i:04d}" if agent == "participant" else agent
                made = make_trial((0,) * 20 if wait is None else (*(0,) * wait, *SOLUTION), agent=who, trial=i + 1)
                of = {"condition": condition.label, "specs": condition.specs, "doses": dict(condition.doses)}
                trials.append(replace(made, key=made.key.replace("truth", condition.label), **of))
    return results_of(study_numbers(open_study(write_study(tmp_path / "study", planned, trials))))


CONDITIONS = ("truth", "flip?p=0.4 + nudge", "drop?p=1")


def test_beside_flips_agents_stand_below_people_in_the_group_of_their_condition(beside_flips):
    (success,) = people(beside_flips).axes
    names = [(text.get_position()[1], text.get_text()) for text in success.texts if text.get_text()]
    assert [name for _, name in sorted(names)] == list(CONDITIONS)
    assert success.get_legend_handles_labels()[1] == ["people", "llm:a", "random"]
    tops = [height for height, _ in sorted(names)]
    assert rows(success, tops) == [[1.0, 1.0, 0.0], [1.0, 1.0, 1.0], [0.0, 1.0, 1.0]]
    assert success.yaxis_inverted()


def rows(axes, tops):
    """The values of the marks in each group, from the top."""
    marks = [(line.get_ydata()[0], line.get_xdata()[0]) for line in axes.lines if len(line.get_xdata()) == 1]
    ends = [*tops[1:], axes.get_ylim()[0]]
    return [[value for y, value in sorted(marks) if top < y < end] for top, end in zip(tops, ends, strict=True)]


def test_people_alone_are_compared_with_nobody(study):
    (axes,) = people(study(people=(4, 4))).axes
    assert axes.get_legend_handles_labels()[1] == ["people"]


def test_without_people_there_is_nothing_to_draw(study):
    assert people(study(a=(4, 4))) is None
