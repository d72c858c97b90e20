"""Forests of differences: a row for each, the right way round, filled where it was detected; what is left out is said."""

import pytest
from builders import SOLUTION, make_trial, small_study, write_study

from lockprobe.report.figures.differences import SHOWN, comparison_drawing, effects, pair_rows, side_by_side
from lockprobe.report.opened import open_study
from lockprobe.report.results import results_of
from lockprobe.report.rows import Condition, Design, Estimate, Player, Results
from lockprobe.report.study_numbers import study_numbers
from lockprobe.statistics.agent_comparison.across_studies import Sample, Side, study_differences


@pytest.fixture
def results(tmp_path):
    """The results of trials."""

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
    assert [text.get_text() for text in axes.texts[:2]] == ["llm:a", "\N{MINUS SIGN} llm:b"]


def test_panels_have_one_axis(results):
    first, second = side_by_side(results(models(a=(2, 18), b=(10, 10)))).axes
    assert first.get_xlim() == second.get_xlim()


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


def difference(condition, value, agent="random", p_value=0.5, **more):
    ends = {"value": value, "low": value - 0.1, "high": value + 0.1, "n": 20}
    of = {"quantity": "success_difference", "agent": agent, "condition": condition, "control": "truth"}
    return Estimate(**of | ends | more, modality="symbolic?tell=state", p_value=p_value)


def found_of(rows):
    shown = {"modality": "symbolic?tell=state"}
    names = ("nudge", "drop?p=1", "nudge + drop?p=1", "lie")
    return Results.model_construct(
        rows=rows,
        design=Design(
            conditions=[
                Condition(name="truth", **shown),
                *(Condition(name=n, control="truth", **shown) for n in names),
            ],
            players=[Player(agent=agent, **shown) for agent in ("random", "round-robin", "participant")],
        ),
    )


def test_marks_are_differences_and_interactions_of_one_agent_and_filled_if_detected():
    crossed = {"quantity": "success_interaction", "of": "nudge \N{MULTIPLICATION SIGN} drop?p=1"}
    found = [
        difference("nudge", 0.2, p_value=0.01),
        difference("drop?p=1", 0.05, p_value=0.01, n=12),  # its interval holds 0
        difference("nudge + drop?p=1", -0.3, p_value=0.02, **crossed),
        difference("nudge", 0.4, agent="round-robin"),
        difference("nudge", 0.7, control="", versus="round-robin"),
        difference("lie", 0.7, of="lie"),
    ]
    axes, other = effects(found_of(found)).axes
    marks = [line for line in axes.lines if line.get_linestyle() == "None"]
    assert [(mark.get_marker(), mark.get_xdata()[0]) for mark in marks] == [("o", 0.2), ("o", 0.05), ("s", -0.3)]
    assert [mark.get_markerfacecolor() == mark.get_color() for mark in marks] == [True, False, True]
    assert "n = 12 to 20 pairs of trials" in axes.get_title(loc="left").replace("\n", " ")
    assert len([line for line in other.lines if line.get_linestyle() == "None"]) == 1


def test_agents_share_one_axis_and_people_are_called_people():
    found = [difference("nudge", 0.1), difference("nudge", 0.6, agent="participant")]
    first, second = effects(found_of(found)).axes
    assert first.get_xlim() == second.get_xlim()
    assert second.get_xlim()[1] > 0.7
    assert second.get_title(loc="left").startswith("people\n")


def test_the_panel_of_an_agent_with_fewer_conditions_comes_last():
    found = [difference("nudge", 0.1), *(difference(name, 0.6, agent="participant") for name in ("nudge", "lie"))]
    figure = effects(found_of(found))
    _, axes = figure.axes
    assert axes.get_title(loc="left").startswith("random\n")  # the agent with most conditions comes first


def test_without_a_comparison_there_is_nothing_to_draw():
    assert effects(found_of([])) is None


def sample(study, solved, condition="truth", luck=1):
    trials = [make_trial(SOLUTION if i < solved else (0,) * 20, trial=i + 1) for i in range(20)]
    return Sample(side=Side(study, "llm:a"), condition=condition, luck=luck, baseline=False, trials=trials)


def drawn(samples):
    found = study_differences(samples)
    return found, comparison_drawing(found, {one.side: f"llm:a in {one.side.study}" for one in samples})


def test_every_pair_has_a_panel_and_every_condition_a_row():
    samples = [sample(i, n, c, luck) for c in ("truth", "nudge") for i, n, luck in ((0, 2, 1), (1, 18, 1), (2, 3, 2))]
    _, figure = drawn(samples)
    assert [axes.get_title(loc="left") for axes in figure.axes] == [
        "llm:a in 1\n\N{MINUS SIGN} llm:a in 0",
        "llm:a in 2\n\N{MINUS SIGN} llm:a in 0",
        "llm:a in 2\n\N{MINUS SIGN} llm:a in 1",
    ]
    values = [[mark.get_xdata()[0] for mark in marks(axes)] for axes in figure.axes]
    assert values == [pytest.approx(pair) for pair in ([0.8, 0.8], [0.05, 0.05], [-0.75, -0.75])]
    filled = [marks(axes)[0].get_markerfacecolor() == marks(axes)[0].get_color() for axes in figure.axes]
    assert filled == [True, False, True]
    assert [marks(axes)[0].get_marker() for axes in figure.axes] == ["o", "s", "s"]  # pairs, independent samples
    assert len({axes.get_xlim() for axes in figure.axes}) == 1


def test_what_there_is_no_room_for_is_said_and_no_pair_is_cut():
    found, figure = drawn([sample(i, 10, f"nudge?after={c}", i) for c in range(1, 5) for i in range(4)])
    rows = pair_rows(found)
    assert [len(pair) for pair in rows.values()] == [4, 4, 4]
    assert sum(map(len, rows.values())) <= SHOWN
    assert figure._supxlabel.get_text() == "12 more differences are in the tables"
    wide, _ = drawn([sample(i, 10, f"nudge?after={c}", i) for c in range(1, 19) for i in range(2)])
    assert [len(pair) for pair in pair_rows(wide).values()] == [18]
