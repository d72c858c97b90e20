"""Figures of any study: legible, deterministic, with the numbers of the results, and an agent looks the same in all."""

import re
from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest
from builders import SOLUTION, make_trial, small_study
from drawn import bars, course, dots, lines, pictures, published, shades, touching, written
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.patches import FancyBboxPatch
from net import unpacked
from reported import found_in

from lockprobe.boxes.box import Joint, Lockbox
from lockprobe.boxes.families import box
from lockprobe.report.figures import render, sheet
from lockprobe.report.figures.boxes import box_figure
from lockprobe.report.figures.frame import agent_label, settable, whole_axis
from lockprobe.report.figures.interlock import short_name
from lockprobe.report.figures.palette import SUBJECTS, of_text, styles
from lockprobe.report.questions import crossings, loops, success
from lockprobe.report.questions.speed import draw as fig3
from lockprobe.report.results import results
from lockprobe.report.rows import Estimate, Fact, Results
from lockprobe.statistics.proportions import proportion
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.until import Until

CASES = ("strategies", "thirty p", "one p", "one trial", "hostile names", "people", "few people")
"""What is special about other studies changes no text."""

UNSOLVED = (0,) * 20


def legible(name, figure):
    figure.draw_without_rendering()
    found = written(figure)
    assert found
    for text, place in found:
        assert text.get_fontsize() >= 9, (name, text)
        prose = re.sub(r"\$p\$|[?&]p=", "", text.get_text())
        assert not re.search(r"\bp\b|(?<!\$)\bP\b", prose), (name, text)
        beyond = [-place.x0, -place.y0, place.x1 - figure.bbox.x1, place.y1 - figure.bbox.y1]
        assert max(beyond) <= 1, (name, text)
    assert touching(figure) == [], name


@pytest.mark.parametrize(
    "case",
    [
        pytest.param(case, marks=pytest.mark.slow if case in ("strategies", "thirty p", "hostile names") else ())
        for case in CASES
    ],
)
def test_every_text_is_large_enough_inside_and_touches_no_other(studies, case):
    for name, figure in pictures(studies[case]).items():
        if name != "box":  # which is the same in all of them, and drawn by hand
            legible(name, figure)


def forks(directory):
    return results(unpacked("forks", directory))


def misreading(directory):
    return results(unpacked("sticky", directory))


def stopping(directory):
    """A study that stopped: all truths are solved, and every fourth trial told lies."""
    planned = replace(small_study(["human-inspired"], (0.0, 0.4), 1, 40), until=Until(rule="decided"))
    return found_in(
        directory,
        planned,
        [
            make_trial(SOLUTION if not p or n % 4 == 0 else (0, 1) * 10, p=p, trial=n, agent="human-inspired")
            for n in range(1, 21)
            for p in (0.0, 0.4)
        ],
    )


def readings(directory):
    asked = {"agent": ["cognitive:perseverant", "random"], "p": [0, 0.4, 0.6], "readings": "fresh,kept"}
    return found_in(directory, study("flips", **asked, condition="nothing=drop?p=1", trials=6, repetitions=1, seed=3))


@pytest.mark.parametrize("made", [forks, misreading, stopping, readings])
def test_so_is_every_text_of_the_figures_that_few_studies_have(tmp_path, made):
    found = made(tmp_path)
    drawn = pictures(found)[made.__name__]
    legible(made.__name__, drawn)
    for block in found.where("decided_at_block"):
        assert f"an effect,\nblock {block.value:g}" in [text.get_text() for text in drawn.axes[0].texts]


def test_a_single_flip_rate_is_no_axis_and_where_every_trial_broke_there_is_the_box_alone(studies):
    """Nothing is drawn over one flip rate, and no axis has the single tick 0."""
    assert not {"fig4", "fig5a", "fig5b"} & pictures(studies["one p"]).keys()
    assert set(pictures(studies["errors"])) == {"box"}


def test_equal_figures_are_equal_bytes(typical):
    for form, begins in (("svg", b"<?xm"), ("png", b"\x89PNG")):
        first, second = (render(fig3(typical), form) for _ in range(2))
        assert first == second
        assert first.startswith(begins)


@pytest.mark.parametrize(
    ("name", "label"),
    [
        ("llm:$\\frac{", "llm:\\$\\frac{"),
        ("_hidden\n<script>", " _hidden?<script>"),
        ("llm:\u4e2d", "llm:?"),
        ("python:" + "x" * 200, "python:" + "x" * 22 + "…"),
        ("llm:openai/gpt-4o-2024-08-06", "llm:openai/gpt-4o-2024-08-06"),
        ("llm:together/meta-llama/Llama-3.3-70B-Instruct", "…Llama-3.3-70B-Instruct"),
        ("cognitive:random-map?window=1&avoid=last&x=2", "…random-map?window=1…"),
    ],
)
def test_names_are_safe_to_set(name, label):
    assert agent_label(course(name)) == label
    assert b"<script>" not in render(sheet([label], lambda axes, shown: axes.set_title(shown)), "svg")


def test_numbers_of_steps_are_apart_whatever_the_budget():
    """On the narrowest axes that a figure has: two panels in a row, with names at the right edge."""
    for budget in (1, 2, 5, 9, 10, 13, 20, 30, 60, 100):
        figure = Figure(figsize=(2.4, 2.0))
        axes = figure.add_axes((0.3, 0.2, 0.65, 0.7))
        axes.set_axis_off()
        axes.set_xlim(0, budget + 0.5)
        whole_axis(axes, budget, "")
        figure.draw_without_rendering()
        assert len(axes.texts) > 1
        assert touching(figure) == [], budget


# The numbers are those of the results.


def test_the_papers_own_figures_are_hollow_stars_with_one_name(typical):
    (axes,) = success.draw(typical).axes
    assert published(axes) == ([(0.0, 7 / 30), (0.4, 20 / 30)], ["the paper"])
    (stars,) = [line for line in axes.lines if line.get_gid() == "paper"]
    assert (stars.get_marker(), stars.get_markerfacecolor(), stars.get_linestyle()) == ("*", "none", "None")
    assert published(*fig3(typical).axes) == ([(9.0, 0.8), (11.0, 0.8), (15.0, 0.8)], ["the paper"])
    assert published(*loops.draw(typical, "fig5b").axes) == ([(0.0, 0.8), (0.4, 16 / 30)], ["the paper"])


def test_figure_4_has_the_repetitions_the_shares_with_intervals_and_the_fit(typical, model):
    (axes,) = success.draw(typical).axes
    shares = [(cell.p, cell.get("success")) for cell in model.cells]
    assert np.allclose(bars(axes), [(p, one.value, one.low, one.high) for p, one in shares])
    fit = model.curve("success_fit")
    assert any(np.array_equal(x, fit.x) and np.array_equal(y, fit.value) for x, y in lines(axes))
    points = [(cell.p, one.value) for cell in model.cells for one, _ in cell.points]
    assert sum(dots(axes).values()) == len(points) == 21
    assert set(dots(axes)) == set(points)


def test_loop_rates_of_figure_5b_stand_between_two_levels_of_chance(typical, model):
    (axes,) = loops.draw(typical, "fig5b").axes
    rates, fit = [(cell.p, cell.get("loop_rate")) for cell in model.cells], model.curve("loop_fit")
    assert np.allclose(bars(axes), [(p, row.value, row.low, row.high) for p, row in rates])
    assert fit.value in [tuple(y) for _, y in lines(axes)]
    (band,) = shades(axes)
    assert band >= {(cell.p, cell.value("loop_rate", of)) for cell in model.cells for of in ("uniform", "no-repeat")}


def test_dots_line_and_r_of_figure_5a(typical, model):
    (axes,) = loops.draw(typical, "fig5a").axes
    assert set(dots(axes)) == {(rate.value, success.value) for cell in model.cells for success, rate in cell.points}
    (x, y), r = lines(axes)[0], model.value("loop_success", "correlation")
    slope = model.value("loop_success", "slope")
    assert np.allclose((y[1] - y[0]) / (x[1] - x[0]), slope)
    assert f"r = {r:.2f}".replace("-", "\N{MINUS SIGN}") in "".join(text.get_text() for text in axes.texts)


def test_people_stand_above_agents_under_each_condition(tmp_path):
    solved = {("participant", 0.0): 1, ("participant", 0.4): 0, ("llm:a", 0.0): 1, ("llm:a", 0.4): 1}
    trials = [
        make_trial(SOLUTION if done else UNSOLVED, agent=f"{agent}:{i:04d}" if "part" in agent else agent, p=p, trial=i)
        for (agent, p), done in solved.items()
        for i in range(1, 11)
    ]
    found = found_in(tmp_path, small_study(("participant", "llm:a"), (0.0, 0.4), 1, 10), trials)
    (axes,) = pictures(found)["people"].axes
    drawn = bars(axes, across=True)
    assert [share for _, share, *_ in sorted(drawn)] == [1.0, 1.0, 0.0, 1.0]
    assert [text.get_text() for text in axes.texts[:2]] == ["flip rate 0", "flip rate 0.4"]
    assert axes.get_legend_handles_labels()[1] == ["people", "llm:a"]
    clustered = found.one("success", agent="participant", condition="truth", of="by person")
    assert min(drawn)[2:] == pytest.approx((clustered.low, clustered.high))


AXIS = "flip rate \N{MULTIPLICATION SIGN} tremble p"


def grid(rows, columns):
    """The texts of a grid in whose cells none, one, two, … of 20 trials were solved, and its cells."""
    facts, made = {"first dose": "flip rate", "second dose": "tremble p"}, []
    for i, (row, column) in enumerate((row, column) for row in rows for column in columns):
        share = proportion(min(i, 20), 20)
        numbers = {name: getattr(share, name) for name in ("value", "low", "high", "count", "n")}
        facts[f"{row:g}, {column:g}"] = f"c{i}"
        made.append(Estimate(quantity="success", agent="llm:$\\frac{" + "x" * 80, condition=f"c{i}", **numbers))
    known = [Fact(about=AXIS, name=name, text=text) for name, text in facts.items()]
    figure = crossings.draw(Results.model_construct(rows=made, facts=known), AXIS)
    figure.draw_without_rendering()
    (axes,) = figure.axes
    return axes.texts[: len(axes.patches)], axes.patches


@pytest.mark.parametrize("columns", [2, 3, 4, 5, 6, 8])
def test_what_stands_in_a_cell_of_a_grid_fits_into_it(columns):
    texts, cells = grid((0, 0.2, 0.4), [round(0.05 * i, 2) for i in range(columns)])
    assert columns > 4 or texts[1].get_text() == "5 %\n1/20\n[1, 24]"
    for text, cell in zip(texts, cells, strict=True):
        room, taken = cell.get_window_extent(), text.get_window_extent()
        assert taken.width <= room.width
        assert taken.height <= room.height


# An agent has one colour and one mark in every report.


def looks(names, **more):
    """How agents look beside each other."""
    return [style for _, style in styles([course(name, **more) for name in names])]


def test_an_agent_looks_the_same_whoever_is_beside_it():
    """In another place, among others, and whether the study is about it or not."""
    names = ["llm:a/x", "llm:local", "human-inspired", "random", "round-robin"]
    first = {name: (style.colour, style.marker) for name, style in zip(names, looks(names), strict=True)}
    for some in (names[:1], names[::-2]):
        assert [(one.colour, one.marker) for one in looks(some, subject=some == names[:1])] == [*map(first.get, some)]


def test_agents_of_one_colour_share_neither_marker_nor_dash():
    """Of so many specs more than one has to get a colour again; marks and dashes differ in grey as well."""
    for i in range(40):
        names = [f"llm:a/{i}", f"llm:b/{i}", f"cognitive:random-map?window={i}"]
        for one, other in combinations(looks(names), 2):
            assert (one.marker, one.dash) != (other.marker, other.dash), names
            assert one.colour != other.colour or (one.marker != other.marker and one.dash != other.dash), names


def test_only_agents_that_a_study_is_about_are_drawn_as_such(studies):
    found = studies["people"]
    assert {one.agent for one, style in styles(found.courses()) if style.lead} == set(found.subjects)


@pytest.mark.parametrize("colour", [*SUBJECTS, "#ffffff", "#95d840", "#e69f57", "#000000"])
def test_text_in_a_colour_is_dark_enough_on_white_and_not_darker_than_it_has_to_be(colour):
    def contrast(of):
        parts = [part / 12.92 if part <= 0.04 else ((part + 0.055) / 1.055) ** 2.4 for part in to_rgb(of)]
        return 1.05 / (0.05 + np.dot([0.2126, 0.7152, 0.0722], parts))

    found = of_text(colour)
    assert contrast(found) >= 4.5
    assert found == colour or contrast(found) < 5.2


# Boxes.

SHOWN = ("chain-4", "bichain-4", "fork", "converge", "reset", "gray-code", "common-cause-4", "branched", "random-8-3")


@pytest.mark.parametrize("name", SHOWN)
def test_every_text_of_a_named_box_is_large_enough_and_touches_no_other(name):
    legible(name, box_figure(box(name)))


def test_the_target_differs_in_more_than_colour():
    panel, interlock = box_figure(box("chain-4")).axes
    for axes in (panel, interlock):
        bold = [text.get_text() for text in axes.texts if text.get_fontweight() == "bold"]
        assert bold == [short_name("revolute-left")]
    widths = sorted(patch.get_linewidth() for patch in interlock.patches if isinstance(patch, FancyBboxPatch))
    assert widths[-1] > 2 * widths[-2]


LEGENDS = [
    (box("chain-4"), []),
    (box("reset"), ["the joint before it must be closed", "on one line: all are required"]),
    (box("fork"), ["on one line: all are required"]),
    (box("common-cause-3"), ["several arrows: any one suffices"]),
    (replace(box("chain-3"), initial=(False, True, False)), ["open at the start"]),
]


@pytest.mark.parametrize(("drawn", "more"), LEGENDS)
def test_the_legend_names_what_there_is_and_nothing_else(drawn, more):
    said = [text.get_text() for found in box_figure(drawn).legends for text in found.get_texts()]
    assert said == ["target", "the joint before it must be open", *more]


def test_odd_names_are_set():
    names = ("a-very-long-name-of-a-joint-that-is-here", "$x^2$-\\frac{", "\u65e5\u672c", "_b")
    joints = tuple(Joint(name=name, kind="prismatic") for name in names)
    odd = Lockbox(
        name="$_{3}$<\u00e9", joints=joints, interlock={"_b": ({names[1]: True},)}, initial=(False,) * 4, target="_b"
    )
    figure = box_figure(odd)
    legible("odd", figure)
    assert render(figure, "png").startswith(b"\x89PNG")
    assert settable("$\u65e5\n") == "\\$??"
