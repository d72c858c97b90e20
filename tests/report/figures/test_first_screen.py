"""The figure of the first screen: agents named where their lines end, over flip rates or steps."""

from lockprobe.report.figures.first_screen import draw_overview


def names(figure):
    (axes,) = figure.axes
    return [text.get_text() for text in axes.texts]


def stars(figure):
    return [line for line in figure.axes[0].get_lines() if line.get_gid() == "paper"]


def test_success_over_flip_rates_stands_beside_chance_and_the_paper(studies):
    figure = draw_overview(studies["three"])
    assert names(figure).count("random agents, exact") == 1
    assert "llm:local" in names(figure)
    assert len(stars(figure)[0].get_xdata()) == 2
    assert "flip rate" in figure.axes[0].get_xlabel()


def test_no_patch_behind_the_name_of_the_paper_hides_lines(studies):
    named = [text for text in draw_overview(studies["three"]).axes[0].texts if "Zenkri" in text.get_text()]
    assert named
    assert all(text.get_bbox_patch() is None for text in named)


def test_a_single_flip_rate_is_shown_by_step_without_the_paper(studies):
    figure = draw_overview(studies["one p"])
    assert figure.axes[0].get_xlabel() == "number of interactions"
    assert not stars(figure)


def test_a_column_of_print_has_few_ticks(studies):
    screen, column = (draw_overview(studies["thirty p"], size) for size in ("screen", "column"))
    assert screen.get_figwidth() > column.get_figwidth() == 3.5
    assert len(column.axes[0].get_xticks()) <= 3


def test_nothing_is_drawn_before_a_trial_has_ended(studies):
    assert draw_overview(studies["errors"]) is None
