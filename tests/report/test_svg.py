"""Figures in pages: in few bytes nothing is lost, and every colour is seen on a dark page."""

import re
from itertools import zip_longest
from urllib.parse import unquote
from xml.etree import ElementTree as ET

import numpy as np
import pytest
from builders import small_study, write_study
from drawn import pictures
from matplotlib.colors import to_rgb

from lockprobe.boxes.families import box
from lockprobe.report.figures import palette, sheet
from lockprobe.report.figures.boxes import box_figure
from lockprobe.report.figures.compose import render
from lockprobe.report.figures.settings import INK
from lockprobe.report.results import results
from lockprobe.report.svg import compact_svg, dark, image

AGENTS = ("cognitive:perseverant", "human-inspired", "random")
PAGE = "#17181b"
"""The ground of a dark page."""

SVG = "{http://www.w3.org/2000/svg}"
PALETTE = sorted({*palette.SUBJECTS, *palette._COLOURS, *(colour for colour, _, _ in palette._SHIPPED.values())})


@pytest.fixture(scope="module")
def drawings(tmp_path_factory):
    """Every figure of a report by name, with its SVG."""
    path = write_study(tmp_path_factory.mktemp("svg") / "study", small_study(AGENTS, (0.0, 0.2, 0.4), 2, 6))
    made = pictures(results(path))
    return {name: (figure, render(figure, "svg")) for name, figure in made.items()}


def opened(found):
    """The SVG of a figure, in its colours on a light page."""
    kind, _, text = found.source.partition(",")
    assert kind == "data:image/svg+xml"
    text = unquote(text)
    light = dict(re.findall(r"--(\w+):(#\w+);", text.partition("}")[0]))
    return ET.fromstring(re.sub(r"var\(--(\w+)\)", lambda found: light[found[1]], text))


def drawn(svg):
    """What a picture of matplotlib draws, in order: each element with its numbers, and what it refers to drawn in."""
    text = re.sub(r"<metadata>.*?</metadata>|<!--.*?-->", "", svg.decode(), flags=re.DOTALL)
    parts = dict(re.findall(r'<(?:path|clipPath) id="([^"]*)"([^>]*)', text))
    for name, attributes in re.findall(r"<(path|use|g|rect|image)\b([^>]*)", text):
        own = re.sub(r'( id="[^"]*"|clip-path="[^"]*")', "", attributes)
        full = re.sub(r'(?:xlink:)?href="#([^"]*)"', lambda found: parts[found[1]], own)
        yield name, [float(number) for number in re.findall(r"(?<![#\w])-?\d+\.?\d*", full)]


def test_a_compact_figure_draws_the_same_in_fewer_bytes():
    svg = render(box_figure(box("chain-4")), "svg")
    small = compact_svg(svg)
    assert len(small) < 0.7 * len(svg)
    for (name, numbers), (other, others) in zip_longest(drawn(svg), drawn(small)):
        assert name == other
        sideways = len(numbers) == len(others) + 1  # a glyph that moves by nothing up or down
        assert others == pytest.approx(numbers[:-1] if sideways else numbers, abs=0.011)


def test_addresses_are_safe_in_pages_and_hold_well_formed_pictures(drawings):
    """Whatever agents are called: names with marks that end addresses, attributes or comments."""
    names = ["a\"b'c<d>&e%23#f", "-->%s]]>\\n$x$"]
    hostile = sheet(names, lambda axes, shown: axes.set_title(shown.replace("$", r"\$")))
    for svg in (render(hostile, "svg"), *(one for _, one in drawings.values())):
        found = image(svg)
        assert not re.search(r"[\"<>#\n]|%(?![0-9A-F]{2})", found.source)
        assert opened(found).tag == f"{SVG}svg"


def contrast(one, other):
    """Of two colours, as WCAG defines it."""
    parts = np.array([to_rgb(one), to_rgb(other)])
    linear = np.where(parts <= 0.03928, parts / 12.92, ((parts + 0.055) / 1.055) ** 2.4)
    low, high = sorted(linear @ [0.2126, 0.7152, 0.0722])
    return (high + 0.05) / (low + 0.05)


@pytest.mark.parametrize("colour", PALETTE)
def test_colours_of_agents_are_seen_on_a_dark_page_and_their_shades_as_on_a_light_one(colour):
    assert contrast(dark(colour.lower()), PAGE) >= 3
    for white in (0.4, *palette._SHADES.values()):
        shade = palette._mixed(colour, white) if white else colour.lower()
        assert contrast(dark(shade), PAGE) >= min(3, contrast(shade, "#ffffff")), shade


@pytest.mark.parametrize("panels", [1, 2])
def test_a_figure_with_text_on_coloured_cells_keeps_its_colours_on_white(panels):
    def cell(axes, share):
        axes.imshow([[share]], cmap="Blues", vmin=0, vmax=1)
        axes.text(0, 0, f"{share}", color=INK)

    kept, turned = (image(render(sheet([0.2, 0.5][:panels], cell, cells=cells), "svg")) for cells in (True, False))
    assert kept.white
    assert not turned.white
    assert ["var(--" in unquote(one.source) for one in (kept, turned)] == [False, True]
