"""Templates: whatever is put in is text, and a name without a value is an error."""

import base64
import re
from itertools import zip_longest
from types import SimpleNamespace

import pytest
from jinja2 import UndefinedError

from lockprobe.boxes.families import box
from lockprobe.report.figures.boxes import box_figure
from lockprobe.report.figures.compose import render
from lockprobe.report.rendering import _breakable, compact_svg, image, rendered


def test_text_is_escaped_and_a_missing_value_is_an_error():
    study = SimpleNamespace(name="<img src=x>", partial=False, looked_at=False)
    content = SimpleNamespace(studies=[study], box="<b>", said="A & B\u202e", unlike=["<i>"], differences=())
    values = {"lockprobe": "1", "images": {}, "caption": (), "tables": {}}
    with pytest.raises(UndefinedError):
        rendered("compare", content=content, **values)
    rows = [["study"], ["<script>"]]
    values["tables"] = dict.fromkeys(("studies", "success", "differences", "rest"), rows)
    page = rendered("compare", content=content, **values)
    assert not any(attack in page for attack in ("<img src=x", "<b>", "<script>", "\u202e"))
    assert "&lt;img src=x&gt;" in page


def test_a_figure_is_part_of_the_page():
    narrow, wide = (image(f'<svg width="{points}pt">'.encode()) for points in (252, 504))
    assert (narrow["broad"], wide["broad"]) == (False, True)
    kind, _, content = narrow["source"].partition(",")
    assert (kind, base64.b64decode(content)) == ("data:image/svg+xml;base64", b'<svg width="252pt">')


def drawn(svg):
    """What a picture of matplotlib draws, in order: each element with its numbers, and what it refers to drawn in."""
    text = re.sub(r"<metadata>.*?</metadata>|<!--.*?-->", "", svg.decode(), flags=re.DOTALL)
    parts = dict(re.findall(r'<(?:path|clipPath) id="([^"]*)"([^>]*)', text))
    for name, attributes in re.findall(r"<(path|use|g|rect|image)\b([^>]*)", text):
        own = re.sub(r'( id="[^"]*"|clip-path="[^"]*")', "", attributes)
        whole = re.sub(r'(?:xlink:)?href="#([^"]*)"', lambda found: parts[found[1]], own)
        yield name, [float(number) for number in re.findall(r"(?<![#\w])-?\d+\.?\d*", whole)]


def test_a_compact_figure_draws_the_same_in_fewer_bytes():
    svg = render(box_figure(box("chain-4")), "svg")
    small = compact_svg(svg)
    assert len(small) < 0.7 * len(svg)
    for (name, numbers), (other, others) in zip_longest(drawn(svg), drawn(small)):
        assert name == other
        sideways = len(numbers) == len(others) + 1  # a glyph that moves by nothing up or down
        assert others == pytest.approx(numbers[:-1] if sideways else numbers, abs=0.011)


def test_a_spec_breaks_after_its_marks_and_never_within_a_tag():
    assert _breakable("llm:a/b") == "llm:<wbr>a/<wbr>b"
    assert _breakable("learner:P < 1/x") == "learner:<i>P</i> &lt; 1/<wbr>x"
