"""The forest of paired differences: one row for each pair, the right way round, filled where they can be told apart."""

import pytest
from builders import SOLUTION, make_trial, small_study, write_study

from lockprobe.analysis import habit_baseline
from lockprobe.figures.differences import SHOWN, side_by_side
from lockprobe.report.opened import open_study
from lockprobe.report.results import results_of
from lockprobe.report.study_numbers import study_numbers


@pytest.fixture
def results(tmp_path, monkeypatch):
    """The results of trials; nobody asks for an exact null of blind agents."""
    monkeypatch.setattr(habit_baseline, "SIMULATED", 200)

    def made(trials):
        agents, rates = (
            list(dict.fromkeys(values)) for values in zip(*((one.agent, one.p) for one in trials), strict=True)
        )
        planned = small_study(agents, sorted(rates), 1, max(one.trial for one in trials))
        return results_of(study_numbers(open_study(write_study(tmp_path / "study", planned, trials))))

    return made


def models(of=20, **solved):
    """Trials of models that solve so many at p = 0 and at 0.4."""
    return [
        make_trial(SOLUTION if i < n else (0,) * 20, agent=f"llm:{name}", p=p, trial=i + 1)
        for name, both in solved.items()
        for p, n in zip((0.0, 0.4), both, strict=True)
        for i in range(of)
    ]


def marks(axes):
    return [line for line in axes.lines if line.get_marker() not in ("None", None, "")]


def filled(mark):
    return mark.get_markerfacecolor() == mark.get_color()


def test_every_pair_has_a_row_with_its_difference(results):
    axes, _ = side_by_side(results(models(a=(18, 20), b=(2, 0), c=(2, 1)))).axes
    assert [mark.get_xdata()[0] for mark in marks(axes)] == pytest.approx([0.9, 0.875, -0.025])
    assert [filled(mark) for mark in marks(axes)] == [True, True, False]
    assert any("llm:a\n\N{MINUS SIGN} llm:b" in text.get_text() for text in axes.texts)


def test_changes_are_those_from_the_lowest_p(results):
    _, axes = side_by_side(results(models(a=(2, 18), b=(10, 10)))).axes
    (mark,) = marks(axes)
    assert mark.get_xdata()[0] == pytest.approx(0.8)


def test_the_change_that_is_drawn_is_the_one_that_the_test_speaks_of(results):
    """At 0.2 nine of forty blocks change, all one way; at 0.4 more do, both ways."""
    apart = [(1, 1, -1)] * 12 + [(-1, -1, 1)] * 7 + [(0, 1, 0)] * 9 + [(0, 0, 0)] * 12
    made = [
        make_trial(SOLUTION if sign * ahead > 0 else (0,) * 20, agent=agent, p=p, trial=i + 1)
        for agent, sign in (("llm:a", 1), ("llm:b", -1))
        for i, signs in enumerate(apart)
        for p, ahead in zip((0.0, 0.2, 0.4), signs, strict=True)
    ]
    _, axes = side_by_side(results(made)).axes
    (mark,) = marks(axes)
    assert mark.get_xdata()[0] == pytest.approx(9 / 40)
    assert filled(mark)
    assert any(text.get_text().startswith("to 0.2: +22 [") for text in axes.texts)


def test_agents_that_the_test_alone_tells_apart_stay_hollow(results):
    """One fails in six blocks at the lowest p of seven: the test is below 0.05, the interval holds 0."""
    made = [
        make_trial(SOLUTION if agent == "llm:a" or p or i < 4 else (0,) * 20, agent=agent, p=p / 10, trial=i + 1)
        for agent in ("llm:a", "llm:b")
        for p in range(7)
        for i in range(10)
    ]
    found = results(made)
    (mark,) = marks(side_by_side(found).axes[0])
    assert found.one("success_difference", axis="flip rate", versus="llm:b").p_value < 0.05
    assert mark.get_markerfacecolor() == "white"


def test_more_pairs_than_there_is_room_for_are_counted(results):
    axes, _ = side_by_side(results(models(of=6, **{f"m{i}": (i, i) for i in range(7)}))).axes
    assert len(marks(axes)) == SHOWN
    assert "6 more in the tables" in axes.get_title(loc="left")


def test_one_agent_alone_has_no_picture(results):
    assert side_by_side(results(models(of=2, a=(1, 1)))) is None
