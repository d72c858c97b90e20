"""``lockprobe rig tags``, as typed."""

from functools import partial

import pytest
from typed import in_process

from lockprobe.foundation.errors import BadValue

ask = partial(in_process, "rig", "tags")


def test_another_form_is_refused():
    with pytest.raises(BadValue, match="a file name that ends in .pdf or .svg"):
        ask("--out", "tags.png")


def test_the_sheet_of_tags_is_a4(tmp_path):
    pytest.importorskip("cv2")
    assert ask("--out", tmp_path / "tags.svg").stdout == f"{tmp_path / 'tags.svg'}\n"
    assert 'width="210mm"' in (tmp_path / "tags.svg").read_text()
    ask("--out", tmp_path / "tags.pdf")
    assert (tmp_path / "tags.pdf").read_bytes().startswith(b"%PDF")
