"""Lines of JSON are lines for every reader."""

import json

import pytest

from lockprobe.foundation.storage.jsonl import one_line


@pytest.mark.parametrize("end", ["\u2028", "\u2029", "\x85", "\x0b", "\x1c"])
def test_a_text_with_other_ends_of_lines_is_one_line_for_every_reader_and_comes_back(end):
    text = rf"one{end}\{end}\u2028 two"
    line = one_line(json.dumps({"a": text}, ensure_ascii=False).encode())
    assert len(line.decode().splitlines()) == 1
    assert json.loads(line) == {"a": text}
