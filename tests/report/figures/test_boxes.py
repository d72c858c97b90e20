"""Pictures of boxes: legible, complete, the same every time, and clear without colour."""

import itertools
import sys
from dataclasses import replace
from functools import cache

import matplotlib as mpl
import pytest
from matplotlib.patches import Circle, FancyArrowPatch, FancyBboxPatch

from lockprobe.boxes.box import Joint, Lockbox
from lockprobe.boxes.families import box
from lockprobe.boxes.generate import Recipe, generate
from lockprobe.report.figures import render
from lockprobe.report.figures.boxes import box_figure, box_of_study
from lockprobe.report.figures.frame import settable
from lockprobe.report.figures.interlock import short_name

SHOWN = ("chain-4", "bichain-4", "fork", "converge", "reset", "gray-code", "common-cause-4", "branched", "random-8-3")
LAYOUTS = ("serial", "zigzag", "ngram", "grid", "scattered", "misleading")


@cache
def picture(name):
    return box_figure(box(name))


def texts(figure):
    figure.draw_without_rendering()
    found = [text for axes in figure.axes for text in (*axes.texts, axes._left_title)]
    found += [text for legend in figure.legends for text in legend.get_texts()]
    return [(text, text.get_window_extent()) for text in found if text.get_text()]


def legible(figure):
    read = texts(figure)
    for text, place in read:
        assert text.get_fontsize() >= 9
        beyond = [-place.x0, -place.y0, place.x1 - figure.bbox.x1, place.y1 - figure.bbox.y1]
        assert max(beyond) <= 1, text
    for (one, first), (other, second) in itertools.combinations(read, 2):
        wide = min(first.x1, second.x1) - max(first.x0, second.x0)
        high = min(first.y1, second.y1) - max(first.y0, second.y0)
        assert min(wide, high) <= 1, (one, other)


@pytest.mark.parametrize("name", SHOWN)
def test_every_text_of_a_named_box_is_large_enough_and_touches_no_other(name):
    legible(picture(name))


@pytest.mark.parametrize("name", SHOWN)
def test_a_picture_is_printed_at_its_size(name):
    """No wider than the text of a page, so that no letter is set smaller than it is drawn."""
    assert picture(name).get_size_inches()[0] <= 7.01


@pytest.mark.parametrize("layout", LAYOUTS)
@pytest.mark.parametrize("family", ["chain-8", "random-7"])
def test_every_layout_is_legible(layout, family):
    made = [generate(Recipe(family=family, layout=layout, dealt=family != "chain-8", seed=seed)) for seed in range(5)]
    legible(box_figure(next(found for found in made if isinstance(found, Lockbox))))


@pytest.mark.parametrize("name", SHOWN)
def test_each_joint_stands_on_the_panel_and_in_the_interlock(name):
    drawn = box(name)
    panel, interlock = picture(name).axes
    wanted = sorted(short_name(joint) for joint in drawn.names)
    assert sorted(text.get_text() for text in panel.texts) == wanted
    assert sorted(text.get_text() for text in interlock.texts) == wanted
    left = {text.get_text(): text.get_position()[0] for text in panel.texts}
    assert sorted(drawn.names, key=lambda joint: left[short_name(joint)]) == list(drawn.names)


@pytest.mark.parametrize("name", [*SHOWN, "random-6-1"])
def test_the_marks_are_those_of_the_interlock(name):
    """An arrow for every alternative, a filled mark for each position that has to be open, a ring for each closed."""
    drawn = box(name)
    _, axes = picture(name).axes
    clauses = [clause for joint in drawn.names for clause in drawn.alternatives(joint)]
    positions = [position for clause in clauses for position in clause.values()]
    rings = [patch for patch in axes.patches if isinstance(patch, Circle) and patch.get_facecolor()[:3] == (1, 1, 1)]
    dots = [patch for patch in axes.patches if isinstance(patch, Circle) and patch not in rings]
    arrows = [patch for patch in axes.patches if isinstance(patch, FancyArrowPatch)]
    assert (len(rings), len(dots)) == (positions.count(False), positions.count(True))
    assert len(arrows) == len(clauses)


def test_the_target_differs_in_more_than_colour():
    panel, interlock = picture("chain-4").axes
    for axes in (panel, interlock):
        bold = [text.get_text() for text in axes.texts if text.get_fontweight() == "bold"]
        assert bold == [short_name("revolute-left")]
    widths = sorted(patch.get_linewidth() for patch in interlock.patches if isinstance(patch, FancyBboxPatch))
    assert widths[-1] > 2 * widths[-2]


def test_the_legend_names_what_there_is_and_nothing_else():
    def legend(figure):
        return [text.get_text() for found in figure.legends for text in found.get_texts()]

    assert legend(picture("chain-4")) == ["target", "the joint before it must be open"]
    assert legend(picture("fork")) == ["target", "the joint before it must be open", "on one line: all are required"]
    assert "the joint before it must be closed" in legend(picture("reset"))
    assert legend(picture("common-cause-3")) == [
        "target",
        "the joint before it must be open",
        "several arrows: any one suffices",
    ]
    opened = replace(box("chain-3"), initial=(False, True, False))
    assert legend(box_figure(opened))[-1] == "open at the start"


def test_joints_without_places_are_put_in_a_row():
    joints = tuple(Joint(name=name, kind="prismatic") for name in "abc")
    figure = box_figure(Lockbox(name="x", joints=joints, interlock={}, initial=(False,) * 3, target="a"))
    places = [text.get_position() for text in figure.axes[0].texts]
    assert len({y for _, y in places}) == 1
    assert [x for x, _ in places] == sorted(x for x, _ in places)
    legible(figure)


def test_odd_names_are_set():
    names = ("a-very-long-name-of-a-joint-that-is-here", "$x^2$-\\frac{", "\u65e5\u672c", "_b")
    joints = tuple(Joint(name=name, kind="prismatic") for name in names)
    odd = Lockbox(
        name="$_{3}$<\u00e9", joints=joints, interlock={"_b": ({names[1]: True},)}, initial=(False,) * 4, target="_b"
    )
    figure = box_figure(odd)
    legible(figure)
    assert render(figure, "png").startswith(b"\x89PNG")
    assert settable("$\u65e5\n") == "\\$??"


def test_equal_boxes_give_equal_bytes():
    assert render(box_figure(box("reset")), "svg") == render(box_figure(box("reset")), "svg")


def test_nothing_global_is_touched():
    settings = [name for name in mpl.rcParams if name != "backend"]  # asking for that one imports pyplot
    before = {name: mpl.rcParams[name] for name in settings}
    box_figure(box("bichain-4"))
    assert {name: mpl.rcParams[name] for name in settings} == before
    assert "matplotlib.pyplot" not in sys.modules


def test_the_box_of_a_study_is_drawn_from_its_results(typical):
    assert render(box_of_study(typical), "svg") == render(box_figure(box("chain-4")), "svg")
