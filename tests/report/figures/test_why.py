"""A cell for every arm, and a mark for every difference."""

import pytest

from lockprobe.report.figures.why import why
from lockprobe.report.rows import Estimate, Results
from lockprobe.statistics.proportions import proportion
from lockprobe.statistics.why.mechanism import CONTRASTS

AGENT = {"agent": "cognitive:insistent", "modality": "symbolic?tell=state"}
COUNTS = {"truth": 30, "lie": 90, "truth-truth": 30, "lie-truth": 45, "truth-lie": 60, "lie-lie": 75, "remark": 15}


def effect(quantity, of, value, half=0.05):
    mean = {"value": value, "low": value - half, "high": value + half, "n": 150, "clusters": 150, "p_value": 0.001}
    return Estimate(quantity=quantity, of=of, **AGENT, **mean, doses={"flip.p": 0.4})


def success(arm, count):
    share = proportion(count, 150)
    numbers = {"value": share.value, "low": share.low, "high": share.high, "count": count, "n": 150}
    return Estimate(quantity="success_in_arm", of=arm, condition=arm, **AGENT, **numbers)


def drawn(total, contrasts=(), counts=COUNTS):
    """The cells and the differences of an agent."""
    rows = [effect("false_report_effect", "total", total)]
    rows += [effect("arm_contrast", of, total / 2) for of in contrasts]
    rows += [success(arm, count) for arm, count in counts.items()]
    figure = why(Results.model_construct(rows=rows))
    figure.draw_without_rendering()
    return figure.axes


def test_every_arm_has_a_cell_with_its_share_and_the_crossing_is_two_by_two():
    axes, _ = drawn(0.4)
    texts = {text.get_text().split(" [")[0].split("\n[")[0]: text.get_position() for text in axes.texts}
    plain = {"true reports\n20 %", "false reports\n60 %", "true, and a remark\n10 %"}
    assert plain <= texts.keys()
    (tt, tl, lt, ll) = (texts[share] for share in ("20 %", "40 %", "30 %", "50 %"))
    assert (tt[0], tt[1]) == (lt[0], tl[1])  # the last is true on the left, the first is true on top
    assert (ll[0], ll[1]) == (tl[0], lt[1])
    assert tl[0] > tt[0]
    assert lt[1] > tt[1]
    assert axes.get_ylim()[0] > axes.get_ylim()[1]
    assert len(axes.patches) == 7


def test_the_number_of_trials_is_a_range_where_some_arms_lack_some():
    axes, _ = drawn(0.4)
    assert axes.get_title(loc="left").endswith("n = 150 per arm")
    rows = [effect("false_report_effect", "total", 0.4), success("truth", 30)]
    rows += [success("lie", 90).model_copy(update={"n": 144})]
    axes, _ = why(Results.model_construct(rows=rows)).axes
    assert axes.get_title(loc="left").endswith("n = 144\N{EN DASH}150 per arm")


def test_an_arm_that_was_not_played_has_no_cell():
    axes, _ = drawn(0.4, counts={arm: n for arm, n in COUNTS.items() if arm != "remark"})
    assert len(axes.patches) == 6


@pytest.mark.parametrize("contrasts", [(), tuple(CONTRASTS)])
def test_every_difference_has_a_mark_with_its_name_and_zero_in_the_middle_of_the_ticks(contrasts):
    _, axes = drawn(0.4, contrasts)
    names = [text.get_text() for text in axes.texts]
    assert names == ["false reports", *contrasts]
    marks = [line for line in axes.lines if line.get_marker() not in ("None", "", None)]
    assert [mark.get_xdata()[0] for mark in marks] == [0.4, *[0.2] * len(contrasts)]
    ticks = axes.get_xticks()
    assert ticks[0] == pytest.approx(-ticks[-1])
    assert axes.get_xlim()[1] > 0.45


def test_a_study_of_other_conditions_has_no_such_figure():
    assert why(Results.model_construct(rows=[])) is None


def test_agents_have_one_axis_and_one_without_contrasts_has_it_right_below_its_only_row():
    rows = [effect("false_report_effect", "total", 0.4), *(effect("arm_contrast", of, 0.2) for of in CONTRASTS)]
    rows += [effect("false_report_effect", "total", 0.1).model_copy(update={"agent": "human-inspired"})]
    rows += [success(arm, 30) for arm in COUNTS]
    rows += [success(arm, 30).model_copy(update={"agent": "human-inspired"}) for arm in COUNTS]
    long, short = (axes for axes in why(Results.model_construct(rows=rows)).axes if axes.get_xlabel())
    assert long.get_xlim() == short.get_xlim()
    assert long.get_ylim() == short.get_ylim()
    assert short.spines["bottom"].get_position() == ("data", 0.6)
