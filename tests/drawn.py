"""Agents to draw, and what stands on axes, read back."""

from itertools import combinations

import numpy as np
from matplotlib.collections import PathCollection, PolyCollection

from lockprobe.report.questions import all_sections
from lockprobe.report.rows import Course, Player
from lockprobe.trial.record import STATES


def lines(axes):
    """The data of every line, apart from the axes', entries of the legend and figures of the paper."""
    own = [line for line in axes.lines if line.get_gid() != "paper" and line.get_label() != "_axis"]
    found = [(np.asarray(line.get_xdata()), np.asarray(line.get_ydata())) for line in own]
    return [(x, y) for x, y in found if len(x)]


def published(axes):
    """The places of the paper's figures, and the entries of the legend that they have."""
    found = [line for line in axes.lines if line.get_gid() == "paper"]
    places = [(float(x), float(y)) for line in found for x, y in zip(*line.get_data(), strict=True)]
    return places, [line.get_label() for line in found]


def shades(axes):
    """The corners of every shade."""
    found = [shade for shade in axes.collections if isinstance(shade, PolyCollection)]
    return [{tuple(corner) for corner in shade.get_paths()[0].vertices.tolist()} for shade in found]


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


def beside(axes):
    """The names at the right edge of axes."""
    return {text.get_text() for text in axes.texts if text.get_ha() == "left" and text.get_va() == "center"}


def written(figure):
    """Every text that is to be read, and where it stands in pixels."""
    found = [figure._supxlabel] if figure._supxlabel else []
    found += [text for legend in figure.legends for text in (legend.get_title(), *legend.get_texts())]
    for axes in figure.axes:
        found += [*axes.texts, axes.title, axes._left_title]
    return [(text, text.get_window_extent()) for text in found if text.get_text().strip()]


def touching(figure):
    """The texts of a figure that touch another one, in pairs; the figure has to be laid out."""
    return [
        (one.get_text(), other.get_text())
        for (one, first), (other, second) in combinations(written(figure), 2)
        if min(first.x1, second.x1) - max(first.x0, second.x0) > 1.5
        and min(first.y1, second.y1) - max(first.y0, second.y0) > 1.5
    ]


def course(agent, modality=STATES, *, found=None, cells=(), **player):
    """An agent over flip rates, without numbers unless cells are given."""
    player = Player(agent=agent, modality=modality, **{"subject": True, **player})
    return Course(found=found, own={}, **player.named, axis="flip rate", name="flip rate", cells=tuple(cells))


def pictures(found):
    """Every figure of a report on these results by its name."""
    made = {}
    for one in (figure for section in all_sections() for figure in section.figures if figure.applies(found)):
        if (figure := one.draw(found)) is not None:
            made[one.name] = figure
    return made
