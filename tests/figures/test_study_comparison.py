"""The figure of studies side by side: a panel for each pair, a row for each condition, one axis for all."""

import pytest
from builders import SOLUTION, make_trial

from lockprobe.analysis.agent_comparison.across_studies import Sample, Side, study_differences
from lockprobe.figures.study_comparison import SHOWN, comparison_drawing, pair_rows


def sample(study, solved, condition="truth", luck=1):
    trials = [make_trial(SOLUTION if i < solved else (0,) * 20, trial=i + 1) for i in range(20)]
    return Sample(side=Side(study, "llm:a"), condition=condition, luck=luck, baseline=False, trials=trials)


def drawn(samples):
    found = study_differences(samples)
    return found, comparison_drawing(found, {one.side: f"llm:a in {one.side.study}" for one in samples})


def marks(axes):
    return [line for line in axes.lines if line.get_marker() not in ("None", None, "")]


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
