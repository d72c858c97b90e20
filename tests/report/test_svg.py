"""Figures in pages: nothing is lost or cut where a figure is taken apart, and every colour is seen on a dark page."""

import colorsys
import json
import re
from collections import Counter
from itertools import pairwise, zip_longest
from urllib.parse import unquote
from xml.etree import ElementTree as ET

import pytest
from builders import small_study, write_study
from drawn import pictures, texts

from lockprobe.boxes.families import box
from lockprobe.report.figures import palette, sheet
from lockprobe.report.figures.boxes import box_figure
from lockprobe.report.figures.compose import render
from lockprobe.report.figures.settings import FAINT, INK
from lockprobe.report.opened import open_study
from lockprobe.report.results import results_of
from lockprobe.report.study_numbers import study_numbers
from lockprobe.report.svg import compact_svg, dark, image, with_dark_colours

AGENTS = ("cognitive:perseverant", "human-inspired", "random")
PAGE = "#17181b"
"""The ground of a dark page."""

SVG = "{http://www.w3.org/2000/svg}"
PALETTE = sorted({*palette.SUBJECTS, *palette._COLOURS, *(colour for colour, _, _ in palette._SHIPPED.values())})


@pytest.fixture(scope="module")
def drawings(tmp_path_factory):
    """Every figure of a report by name, with its SVG."""
    path = write_study(tmp_path_factory.mktemp("svg") / "study", small_study(AGENTS, (0.0, 0.2, 0.4), 2, 6))
    made = pictures(results_of(study_numbers(open_study(path))))
    return {name: (figure, render(figure, "svg")) for name, figure in made.items()}


def opened(piece):
    """The SVG of a piece, in its colours on a light page."""
    kind, _, text = piece.source.partition(",")
    assert kind == "data:image/svg+xml"
    text = unquote(text)
    light = dict(re.findall(r"--(\w+):(#\w+);", text.partition("}")[0]))
    return ET.fromstring(re.sub(r"var\(--(\w+)\)", lambda found: light[found[1]], text))


def definitions(root):
    """What a picture defines, by name."""
    return {one.get("id"): one for one in root.iter() if one.get("id")}


def used(element):
    """The names of the definitions that an element uses."""
    return re.findall(r"(?:url\()?#([\w-]+)\)?", " ".join(_references(element)))


def _references(element):
    for one in element.iter():
        yield from (value for name, value in one.attrib.items() if name.endswith("href") or "url(#" in value)


def whole(element, known):
    """All that an element draws, with what it uses in the place of names."""
    own = {}
    for name, value in element.attrib.items():
        refers = re.search(r"#([\w-]+)\)?$", value) if name.endswith("href") or value.startswith("url(#") else None
        own[name] = whole(known[refers[1]], known) if refers else value
    own.pop("id", None)
    inside = [whole(one, known) for one in element if one.tag != f"{SVG}defs"]
    return repr((element.tag, sorted(own.items()), (element.text or "").strip(), inside))


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


def test_pieces_hold_every_group_of_a_figure_once(drawings):
    taken_apart = 0
    for name, (_, svg) in drawings.items():
        found = image(svg)
        pieces = [opened(one) for one in (*found.panels, *found.below)]
        taken_apart += len(pieces) > 1
        figure = ET.fromstring(compact_svg(svg))
        known = definitions(figure)
        (inside,) = [one for one in figure if one.tag == f"{SVG}g"]
        ground, *groups = list(inside)
        parts = [one for root in pieces for one in _groups(root, whole_figure=len(pieces) == 1)]
        shown = Counter(whole(part, known_here) for part, known_here in parts)
        assert shown == Counter(whole(one, known) for one in groups), name
        assert ground.find(f"{SVG}path") is not None
    assert taken_apart > 3


def _groups(root, *, whole_figure):
    """The groups of a piece, with the definitions that they use."""
    groups = [one for one in root if one.tag == f"{SVG}g"]
    if whole_figure:
        (outer,) = groups
        groups = [one for one in outer if one.tag == f"{SVG}g"]
    return [(one, definitions(root)) for one in groups]


def test_pieces_define_all_that_they_use_and_nothing_else(drawings):
    for name, (_, svg) in drawings.items():
        found = image(svg)
        if len(found.panels) == 1:
            continue
        for piece in (*found.panels, *found.below):
            root = opened(piece)
            names = [one.get("id") for one in root.iter() if one.get("id")]
            assert len(names) == len({*names}), name
            assert {*names} == {*used(root)}, name


def test_a_panel_for_each_agent_in_one_size(drawings):
    figure, svg = drawings["courses"]
    found = image(svg)
    assert len(found.panels) == len(AGENTS) == sum(axes.get_visible() for axes in figure.axes)
    assert len({one.width for one in found.panels}) == 1
    assert len(found.below) == len(figure.legends) == 1


def test_no_text_of_a_panel_is_cut(drawings):
    for name, (figure, svg) in drawings.items():
        description = re.search(rb"<dc:description>(.*?)</dc:description>", svg, re.DOTALL)
        places = json.loads(description[1].replace(b"&quot;", b'"')) if description else {}
        figure.draw_without_rendering()
        points, height = 72 / figure.dpi, figure.bbox.height
        for axes in figure.axes:
            if not axes.get_visible() or not axes.get_gid():
                continue
            left, top, wide, high = places[axes.get_gid().partition(".")[0]]
            for text in [one for one in texts(axes) if one.get_text().strip()]:
                box = text.get_window_extent()
                assert points * box.x0 >= left - 1, (name, text)
                assert points * box.x1 <= left + wide + 1, (name, text)
                assert points * (height - box.y1) >= top - 1, (name, text)
                assert points * (height - box.y0) <= top + high + 1, (name, text)


def test_a_figure_with_one_panel_is_one_picture():
    one = image(render(sheet(["a"], lambda axes, shown: axes.plot([0, 1], label=shown)), "svg"))
    two = image(render(sheet(["a", "b"], lambda axes, shown: axes.plot([0, 1], label=shown), note="Note."), "svg"))
    assert (len(one.panels), len(one.below)) == (1, 0)
    assert (len(two.panels), len(two.below)) == (2, 1)  # the legend below its note


def test_a_picture_is_as_wide_in_pixels_as_in_points():
    widths = [image(f'<svg width="{points}pt">'.encode()).panels[0].width for points in (252, 504)]
    assert widths == [336, 672]


def test_addresses_are_safe_in_pages_and_hold_well_formed_pictures(drawings):
    """Whatever agents are called: names with marks that end addresses, attributes or comments."""
    names = ["a\"b'c<d>&e%23#f", "-->%s]]>\\n$x$"]
    hostile = sheet(names, lambda axes, shown: axes.set_title(shown.replace("$", r"\$")))
    for svg in (render(hostile, "svg"), *(one for _, one in drawings.values())):
        found = image(svg)
        for piece in (*found.panels, *found.below):
            assert not re.search(r"[\"<>#\n]|%(?![0-9A-F]{2})", piece.source)
            assert opened(piece).tag == f"{SVG}svg"


def contrast(one, other):
    """Of two colours, as WCAG defines it."""
    low, high = sorted(map(_luminance, (one, other)))
    return (high + 0.05) / (low + 0.05)


def _luminance(colour):
    parts = [int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)]
    linear = [part / 12.92 if part <= 0.03928 else ((part + 0.055) / 1.055) ** 2.4 for part in parts]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


@pytest.mark.parametrize("colour", PALETTE)
def test_colours_of_agents_are_seen_on_a_dark_page_and_their_shades_as_on_a_light_one(colour):
    assert contrast(dark(colour.lower()), PAGE) >= 3
    for white in (0.4, *palette._SHADES.values()):
        shade = palette._mixed(colour, white) if white else colour.lower()
        assert contrast(dark(shade), PAGE) >= min(3, contrast(shade, "#ffffff")), shade


@pytest.mark.parametrize("colour", PALETTE)
def test_a_colour_keeps_its_hue_on_a_dark_page(colour):
    hue, light, full = _hls(colour)
    if full >= 0.12:
        assert _hls(dark(colour.lower()))[0] == pytest.approx(hue, abs=0.02)
    assert _hls(dark(colour.lower()))[1] >= min(light, 0.6)


def _hls(colour):
    hue, light, full = colorsys.rgb_to_hls(*(int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)))
    return hue, light, full


def test_greys_are_turned_round_on_a_dark_page():
    greys = [f"#{level:02x}{level:02x}{level:02x}" for level in range(0, 256, 5)]
    lights = [_luminance(dark(grey)) for grey in greys]
    assert all(one > other for one, other in pairwise(lights))
    assert dark("#ffffff") == PAGE
    assert _hls(dark("#f4f4f2"))[2] == 0  # a grey in all but name, which would be olive
    for text in (INK, FAINT):
        assert contrast(dark(text), PAGE) >= 4.5


def test_pale_grounds_stay_grounds_on_a_dark_page():
    assert contrast(dark("#e8f0fa"), PAGE) < 1.6


def test_each_colour_is_a_variable_with_a_value_for_each_kind_of_page():
    svg = with_dark_colours(
        b'<svg width="1pt"><path style="fill: #ffffff; stroke: #0072b2"/><path style="fill: none"/></svg>'
    )
    assert b"fill: var(--0); stroke: var(--1)" in svg
    assert b":root{--0:#ffffff;--1:#0072b2;}" in svg
    night = f"@media (prefers-color-scheme:dark){{:root{{--0:{dark('#ffffff')};--1:{dark('#0072b2')};}}}}"
    assert night.encode() in svg
    assert with_dark_colours(b"<svg/>") == b"<svg/>"


@pytest.mark.parametrize("panels", [1, 2])
def test_a_figure_with_text_on_coloured_cells_keeps_its_colours_on_white(panels):
    def cell(axes, share):
        axes.imshow([[share]], cmap="Blues", vmin=0, vmax=1)
        axes.text(0, 0, f"{share}", color=INK)

    kept, turned = (image(render(sheet([0.2, 0.5][:panels], cell, cells=cells), "svg")) for cells in (True, False))
    assert all(one.white and "var(--" not in unquote(one.source) for one in kept.panels)
    assert not any(one.white for one in turned.panels)
    assert all("var(--" in unquote(one.source) for one in turned.panels)
