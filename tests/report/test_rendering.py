"""Templates: whatever is put in is text, and a name without a value is an error."""

from types import SimpleNamespace

import pytest
from jinja2 import UndefinedError

from lockprobe.report.rendering import _breakable, rendered


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


def test_a_spec_breaks_after_its_marks_and_never_within_a_tag():
    assert _breakable("llm:a/b") == "llm:<wbr>a/<wbr>b"
    assert _breakable("learner:P < 1/x") == "learner:<i>P</i> &lt; 1/<wbr>x"
