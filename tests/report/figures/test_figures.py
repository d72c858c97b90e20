"""Figures of any study: legible, deterministic, with the numbers of the results, and an agent looks the same in all."""

import json
import os
import re
import subprocess
import sys
from collections import Counter
from dataclasses import replace
from functools import cache
from itertools import combinations
from pathlib import Path
from tempfile import TemporaryDirectory
from urllib.parse import unquote
from xml.etree.ElementTree import fromstring

import numpy as np
import pytest
from boxes.conftest import any_box
from builders import SOLUTION, make_trial, play_study, played_by_people, small_study
from hypothesis import given, settings
from matplotlib.collections import PathCollection, PolyCollection
from matplotlib.colors import to_rgb
from report.test_every_look import KINDS, trials_of
from reported import found_in

from lockprobe.boxes.box import Joint, Lockbox
from lockprobe.boxes.families import box
from lockprobe.report.figures.boxes import box_figure
from lockprobe.report.figures.drawing import COLOURS, agent_label, render, settable, sheet, style_of
from lockprobe.report.page import image
from lockprobe.report.questions import all_sections, loops, success
from lockprobe.report.questions.speed import draw as fig3
from lockprobe.report.rows import Player
from lockprobe.trial.record import STATES

P7 = (0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6)
REFERENCES = ("random", "round-robin", "human-inspired")


@cache
def references():
    """The baselines over all p, in a study of the paper's size."""
    return play_study(small_study(REFERENCES, P7, 3, 10))


@cache
def one_model():
    """What looks like a model: a strategy that loops, under the name of one."""
    played = play_study(small_study(("cognitive:perseverant",), P7, 3, 10))
    return [under(trial, "llm:openai/gpt-4o-2024-08-06") for trial in played]


def rivals():
    """A strategy under the name of a model and a baseline, for people to be compared with."""
    played = play_study(small_study(("ideal-observer", "random"), PEOPLE.p, 2, 5))
    return [under(trial, f"llm:{trial.agent}") if trial.agent != "random" else trial for trial in played]


def under(trial, agent):
    """The trial under the name of another agent."""
    return replace(trial, agent=agent, key=str(replace(trial.name, agent=agent)))


PEOPLE = small_study(("participant",), (0.0, 0.2, 0.4, 0.6), 2, 5)
HOSTILE = ("llm:$\\frac{", "python:" + "mx" * 96, "_hidden<script>", "llm:\u4e2d\u0e01")
LONG = tuple(f"cognitive:softmax-memory?failure={pull}&decay=0.5&recent=1" for pull in (1, 2))
STUDIES = {
    "typical": lambda: one_model() + references(),
    "thirty p": lambda: play_study(small_study(("human-inspired", "random"), [i / 29 for i in range(30)], 1, 2)),
    "one p": lambda: [trial for trial in one_model() + references() if trial.p == 0.0],
    "hostile names": lambda: [
        make_trial([0] * (p > 0) + [3, 2, 1, 0], agent=name, p=p) for name in (*HOSTILE, *LONG) for p in (0.0, 0.5)
    ],
    "people": lambda: played_by_people(PEOPLE) + rivals(),
}
"""Trials by what is special about them."""


@cache
def case(name):
    """Results by what is special about them, of a study with these trials and no others."""
    trials = STUDIES[name]()
    agents, rates = dict.fromkeys(one.group for one in trials), sorted({one.p for one in trials})
    planned = small_study(agents, rates, max(one.repetition for one in trials), max(one.trial for one in trials))
    with TemporaryDirectory() as directory:
        return found_in(Path(directory), planned, trials)


@pytest.fixture(scope="module")
def typical():
    """One model beside references."""
    return case("typical")


@pytest.fixture(scope="module")
def model(typical):
    """The model of it, over the flip rates."""
    return typical.courses()[0]


# What stands on axes, read back.


def lines(axes):
    """The data of every line, apart from figures of the paper."""
    own = [line for line in axes.lines if line.get_gid() != "paper"]
    found = [(np.asarray(line.get_xdata()), np.asarray(line.get_ydata())) for line in own]
    return [(x, y) for x, y in found if len(x)]


def published(axes):
    """The places of the paper's figures, and the entries of the legend that they have."""
    found = [line for line in axes.lines if line.get_gid() == "paper"]
    places = [(float(x), float(y)) for line in found for x, y in zip(*line.get_data(), strict=True)]
    return places, [line.get_label() for line in found]


def dots(axes):
    """Places of scattered dots, and how many points each stands for."""
    (scattered,) = [found for found in axes.collections if isinstance(found, PathCollection)]
    sizes = scattered.get_sizes()
    places = [tuple(map(float, place)) for place in scattered.get_offsets()]
    return dict(zip(places, (sizes / sizes.min()).tolist(), strict=True))


def bars(axes, *, across=False):
    """Every marker with a bar: place, value, and the ends of the bar; those of a forest lie across."""
    found = []
    for container in axes.containers:
        marks, _, (ends,) = container.lines
        x, y = marks.get_data()
        along = 0 if across else 1
        for place, value, segment in zip(*((y, x) if across else (x, y)), ends.get_segments(), strict=True):
            found.append((float(place), float(value), *(map(float, segment[:, along]) if len(segment) else ())))
    return found


def written(figure):
    """Every text that is to be read, and where it stands in pixels."""
    found = [figure._supxlabel] if figure._supxlabel else []
    found += [text for legend in figure.legends for text in (legend.get_title(), *legend.get_texts())]
    for axes in figure.axes:
        found += [*axes.texts, axes.title, axes._left_title]
        found += [text for own in (axes.xaxis, axes.yaxis) * axes.axison for text in (own.label, *own.get_ticklabels())]
    return [(text, text.get_window_extent()) for text in found if text.get_text().strip()]


def pictures(found):
    """Every figure of a report on these results by its name."""
    made = {}
    for one in (figure for section in all_sections() for figure in section.figures if figure.applies(found)):
        if (figure := one.draw(found)) is not None:
            made[one.name] = figure
    return made


UNSOLVED = (0,) * 20


def legible(name, figure):
    figure.draw_without_rendering()
    found = written(figure)
    assert found
    for text, place in found:
        assert text.get_fontsize() >= 9, (name, text)
        assert not re.search(r"\b[pP]\b", re.sub("[?&]p=", "", text.get_text())), (name, text)
        beyond = [-place.x0, -place.y0, place.x1 - figure.bbox.x1, place.y1 - figure.bbox.y1]
        assert max(beyond) <= 1, (name, text)
    for (one, first), (other, second) in combinations(found, 2):
        across, down = (min(first.x1, second.x1) - max(first.x0, second.x0),
                        min(first.y1, second.y1) - max(first.y0, second.y0))  # fmt: skip
        assert min(across, down) <= 1.5, (name, one, other)


@pytest.mark.parametrize(
    "name", [*(pytest.param(one, marks=pytest.mark.slow) for one in ("thirty p", "one p", "hostile names")), "people"]
)
def test_every_text_is_large_enough_inside_and_touches_no_other(name):
    for figure, drawn in pictures(case(name)).items():
        legible(figure, drawn)


def test_so_is_every_text_of_the_figure_that_few_studies_have(tmp_path):
    planned, blocks = KINDS["until"]
    found = found_in(tmp_path, planned, trials_of(blocks))
    drawn = pictures(found)["stopping"]
    legible("stopping", drawn)
    for block in found.where("decided_at_block"):
        assert f"an effect, block {block.value:g}" in drawn.axes[0].get_title()


def test_equal_figures_are_equal_bytes_and_a_page_embeds_them_with_text_that_is_text(typical):
    first, second = (render(fig3(typical), "svg") for _ in range(2))
    assert first == second
    shown = fromstring(unquote(re.search(r'src="data:image/svg\+xml,([^"]*)"', image(first))[1]))
    said = {"".join(one.itertext()).strip() for one in shown.iter("{http://www.w3.org/2000/svg}text")}
    assert {"solved by this step", "number of interactions", "100 %"} <= said


@pytest.mark.parametrize(
    ("name", "label"),
    [
        ("llm:$\\frac{", "llm:\\$\\frac{"),
        ("_hidden\n<script>", " _hidden?<script>"),
        ("llm:\u4e2d", "llm:?"),
        ("python:" + "x" * 200, "python:" + "x" * 22 + "…"),
        ("llm:openai/gpt-4o-2024-08-06", "llm:openai/gpt-4o-2024-08-06"),
        ("llm:together/meta-llama/Llama-3.3-70B-Instruct", "…Llama-3.3-70B-Instruct"),
        ("cognitive:softmax-memory?failure=1&recent=2", "…softmax-memory?failure=1&rec…"),
    ],
)
def test_names_are_safe_to_set(name, label):
    assert agent_label(Player(agent=name, modality=STATES)) == label
    assert b"<script>" not in render(sheet([label], lambda axes, shown: axes.set_title(shown)), "svg")


# The numbers are those of the results.


def test_the_papers_own_figures_are_hollow_stars_with_one_name(typical):
    (axes,) = success.draw(typical).axes
    assert published(axes) == ([(0.0, 7 / 30), (0.4, 20 / 30)], ["the paper"])
    (stars,) = [line for line in axes.lines if line.get_gid() == "paper"]
    assert (stars.get_marker(), stars.get_markerfacecolor(), stars.get_linestyle()) == ("*", "none", "None")
    assert published(*fig3(typical).axes) == ([(9.0, 0.8), (11.0, 0.8), (15.0, 0.8)], ["the paper"])
    assert published(*loops.draw(typical, loops.by_dose).axes) == ([(0.0, 0.8), (0.4, 16 / 30)], ["the paper"])


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
    (axes,) = loops.draw(typical, loops.by_dose).axes
    rates, fit = [(cell.p, cell.get("loop_rate")) for cell in model.cells], model.curve("loop_fit")
    assert np.allclose(bars(axes), [(p, row.value, row.low, row.high) for p, row in rates])
    assert fit.value in [tuple(y) for _, y in lines(axes)]
    (shade,) = [one for one in axes.collections if isinstance(one, PolyCollection)]
    assert {*map(tuple, shade.get_paths()[0].vertices.tolist())} >= {
        (cell.p, cell.value("loop_rate", of)) for cell in model.cells for of in ("uniform", "no-repeat")
    }


def test_dots_line_and_r_of_figure_5a(typical, model):
    (axes,) = loops.draw(typical, loops.against_success).axes
    shares = [(rate.value, success.value) for cell in model.cells for success, rate in cell.points]
    assert set(dots(axes)) == {*shares}
    (x, y), r = lines(axes)[0], model.value("loop_success", "correlation")
    assert np.allclose((y[1] - y[0]) / (x[1] - x[0]), np.polyfit(*zip(*shares, strict=True), 1)[0])
    assert f"r = {r:.2f}".replace("-", "\N{MINUS SIGN}") in axes.get_title()


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
    assert [text.get_text() for text in axes.texts[:2]] == ["told the truth", "flip rate 0.4"]
    assert axes.get_legend_handles_labels()[1] == ["people", "llm:a"]
    clustered = found.one("success", agent="participant", condition="truth", of="")
    assert min(drawn)[2:] == pytest.approx((clustered.low, clustered.high))


# An agent has one colour and one mark in all figures of a study.


def test_agents_of_a_study_differ_in_colour_or_mark_and_those_that_it_is_about_lead(typical):
    looks = {one.agent: style_of(one) for one in typical.courses()}
    assert len({(one.colour, one.marker) for one in looks.values()}) == len(looks) == 4
    assert {agent for agent, one in looks.items() if one.lead} == set(typical.subjects)


@pytest.mark.parametrize("colour", COLOURS)
def test_text_in_a_colour_is_dark_enough_on_white(colour):
    parts = [part / 12.92 if part <= 0.04 else ((part + 0.055) / 1.055) ** 2.4 for part in to_rgb(colour)]
    assert 1.05 / (0.05 + np.dot([0.2126, 0.7152, 0.0722], parts)) >= 4.5


# Boxes.


@pytest.mark.parametrize("name", ["bichain-4", "gray-code", "common-cause-4", "random-8-3"])
def test_every_text_of_a_named_box_is_large_enough_and_touches_no_other(name):
    legible(name, box_figure(box(name)))


@settings(max_examples=5)
@given(any_box())
def test_the_table_of_needs_says_what_the_interlock_says(drawn):
    """A row for each alternative, a column for each joint that is needed; filled for open, hollow for closed."""
    *_, axes = box_figure(drawn).axes
    heads = {round(text.get_position()[0], 2): text.get_text() for text in axes.texts if text.get_ha() == "center"}
    rows = {}
    for circle in axes.patches:
        x, y = circle.center
        rows.setdefault(round(y, 3), {})[heads[round(x, 2)]] = circle.get_facecolor()[:3] != (1, 1, 1)
    short = {text.get_text().replace("\n", ""): text.get_text() for text in axes.texts}  # a long one is in two lines
    shown = Counter(frozenset(one.items()) for one in rows.values())
    asked = [clause for name in drawn.names for clause in drawn.alternatives(name)]
    assert shown == Counter(frozenset((short[name], at) for name, at in one.items()) for one in asked)


def test_odd_names_are_set():
    names = ("a-very-long-name-of-a-joint-that-is-here", "$x^2$-\\frac{", "\u65e5\u672c", "_b")
    joints = tuple(Joint(name=name, kind="prismatic") for name in names)
    odd = Lockbox(
        name="$_{3}$<\u00e9", joints=joints, interlock={"_b": ({names[1]: True},)}, initial=(False,) * 4, target="_b"
    )
    legible("odd", box_figure(odd))
    assert settable("$\u65e5\n") == "\\$??"


DRAW = """
import json, os, sys
from lockprobe.report.figures.drawing import render
from lockprobe.report.figures.boxes import box_figure
from lockprobe.boxes.families import box
drawn = render(box_figure(box("chain-4")), "svg").decode()
print(json.dumps([drawn, os.environ.get("MATPLOTLIBRC"), os.environ["MPLBACKEND"]]))
"""


def test_no_settings_of_a_user_change_or_prevent_a_figure(tmp_path):
    """A text of another coding in the folder, and by name a pipe that a reader waits for."""
    (tmp_path / "matplotlibrc").write_text("font.size: 23\ntext.usetex: True\n", "utf-16")
    os.mkfifo(tmp_path / "pipe")
    users = {"MPLBACKEND": "module://no.such", "MATPLOTLIBRC": str(tmp_path / "pipe")}
    done = subprocess.run(
        [sys.executable, "-c", DRAW], cwd=tmp_path, env=os.environ | users, capture_output=True, text=True, timeout=600
    )
    assert (done.returncode, done.stderr) == (0, "")
    drawn = render(box_figure(box("chain-4")), "svg").decode()
    assert json.loads(done.stdout) == [drawn, users["MATPLOTLIBRC"], users["MPLBACKEND"]]
