"""Figures as pages embed them: in few bytes, and in the colours of a dark page too."""

from __future__ import annotations

import colorsys
import re
from dataclasses import dataclass
from functools import cache
from urllib.parse import quote

_GREY = 0.05
"""How far apart the parts of a grey are, at most."""

_GROUND_OF_PAGE = "#17181b"
"""What white is on a dark page: its ground."""

_PAPER, _INK = 0.10, 0.93
"""Lightness of what is nearly white, and of what is black, on a dark page."""

_PALE, _LEAST = 0.85, 0.62
"""Lightness from which a colour is a pale ground, and the least lightness of a line on a dark page."""

_PIXELS = 96 / 72
"""Pixels per point."""


@dataclass(frozen=True, slots=True)
class Image:
    """A figure as a page embeds it: a data URI, its width in pixels, and whether it stays on white."""

    source: str
    width: int
    white: bool = False


def image(svg: bytes) -> Image:
    """A figure of Matplotlib for a page."""
    white, small = _KEPT in svg, compact_svg(re.sub(_GROUND, b"", svg))
    wide = re.search(rb'width="([\d.]+)pt"', svg)
    text = (small if white else with_dark_colours(small)).decode()
    source = "data:image/svg+xml," + _UNSAFE.sub(lambda found: _quoted(found[0]), text.replace('"', "'"))
    return Image(source, round(float(wide[1]) * _PIXELS) if wide else 0, white)


_UNSAFE = re.compile(r"[^\w !$&'()*+,./:;=?@~|{}\[\]^`\\-]+", re.ASCII)
"""What a data URI cannot hold as it is."""

_quoted = cache(quote)

_KEPT = b"<rdf:li>cells</rdf:li>"
"""What the SVG of a figure says whose colours stay as they are."""

_GROUND = re.compile(rb'^  <g id="patch_1">.*?^  </g>\n', re.DOTALL | re.MULTILINE)
"""The white behind a figure."""


def compact_svg(svg: bytes) -> bytes:
    """A figure of matplotlib in about half as many bytes: coordinates to a hundredth of a point."""
    svg = re.sub(rb"<metadata>.*?</metadata>|<!--.*?-->|<\?xml.*?\?>|<!DOCTYPE.*?>", b"", svg, flags=re.DOTALL)
    svg = re.sub(rb"> <", b"><", re.sub(rb"\s+", b" ", re.sub(rb'<g id="[^"]*"', b"<g", svg)))
    svg = re.sub(rb"(?<!scale\()(\b\d+\.\d\d)\d+", rb"\1", svg)
    svg = re.sub(
        rb'(<use [^>]*?)transform="translate\(([\d.]+) 0\)"', rb'\1x="\2"', svg.replace(b"xlink:href", b"href")
    )
    names = {name: b"%x" % i for i, name in enumerate(dict.fromkeys(re.findall(rb' id="([^"]*)"', svg)))}
    return re.sub(rb'(?<= id=")[^"]*|(?<=#)[A-Za-z][\w-]*(?=[")])', lambda name: names.get(name[0], name[0]), svg)


_COLOUR = re.compile(rb"(?<=: )#[0-9a-f]{6}\b")
"""A colour in a style."""


def with_dark_colours(svg: bytes) -> bytes:
    """The figure with each colour as a variable, which has another value where a dark page is read."""
    colours = list(dict.fromkeys(_COLOUR.findall(svg)))
    if not colours:
        return svg
    light = "".join(f"--{i:x}:{colour.decode()};" for i, colour in enumerate(colours))
    night = "".join(f"--{i:x}:{dark(colour.decode())};" for i, colour in enumerate(colours))
    style = f"<style>:root{{{light}}}@media (prefers-color-scheme:dark){{:root{{{night}}}}}</style>"
    names = {colour: b"var(--%x)" % i for i, colour in enumerate(colours)}
    svg = _COLOUR.sub(lambda found: names[found[0]], svg)
    end = svg.index(b">", svg.index(b"<svg ")) + 1
    return svg[:end] + style.encode() + svg[end:]


@cache
def dark(colour: str) -> str:
    """A colour on a dark page: greys are turned round, pale grounds become dark, and lines light enough to be seen.

    >>> dark("#ffffff"), dark("#000000"), dark("#0072b2")
    ('#17181b', '#ededed', '#3db9ff')
    """
    if colour == "#ffffff":
        return _GROUND_OF_PAGE
    parts = [int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)]
    hue, light, full = colorsys.rgb_to_hls(*parts)
    if max(parts) - min(parts) < _GREY:
        full = 0.0
        light = _INK + light * (_PAPER - _INK)
    elif light >= _PALE:
        light = _PAPER + (1 - light)
    else:
        light = max(light, _LEAST)
    return "#" + "".join(f"{round(255 * part):02x}" for part in colorsys.hls_to_rgb(hue, light, full))
