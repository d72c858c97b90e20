"""Templates: whatever is put in is text, and a name without a value is an error."""

import base64
from types import SimpleNamespace

import pytest
from jinja2 import UndefinedError

from lockprobe.report.rendering import image, rendered


def test_text_is_escaped_and_a_missing_value_is_an_error():
    study = SimpleNamespace(name="<img src=x>", partial=False)
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
