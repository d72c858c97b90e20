"""Files of lines: what a crash tore is cut off, and nothing else."""

import json
import zlib
from contextlib import closing

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import TypeAdapter

from lockprobe.foundation.errors import BadFile, BadValue
from lockprobe.foundation.storage.jsonl import LineFile, read_values, whole_lines, with_checksum, without_checksum

LONG = b"x" * 200_000


@pytest.mark.parametrize(
    ("content", "kept"),
    [
        (b"", b""),
        (b"torn", b""),
        (b"\n", b"\n"),
        (b"a\nb\n", b"a\nb\n"),
        (b"a\nb\ntorn", b"a\nb\n"),
        (b"a\n" + LONG, b"a\n"),
        (LONG, b""),
        (LONG + b"\n" + LONG, LONG + b"\n"),
        (b"a\n\0\0\0", b"a\n"),
        *((b"a\n" + b"x" * size, b"a\n") for size in (65_535, 65_536, 65_537, 131_072)),
    ],
    ids=lambda content: f"{content[:9]!r} of {len(content)}",
)
def test_an_unfinished_last_line_is_cut_off(tmp_path, content, kept):
    path = tmp_path / "lines"
    path.write_bytes(content)
    with closing(LineFile(path)) as file:
        file.cut_torn_tail()
        file.append(b"next")
    assert path.read_bytes() == kept + b"next\n"


def test_lines_are_numbered_as_in_the_file_and_torn_ones_are_none(tmp_path):
    path = tmp_path / "lines"
    path.write_bytes(b"a\n\n  \nb\r\ntorn")
    assert list(whole_lines(path)) == [(1, b"a\n"), (4, b"b\r\n")]


OBJECTS = st.dictionaries(st.text(max_size=5), st.one_of(st.integers(), st.text(max_size=9)), min_size=1, max_size=4)


@pytest.mark.parametrize("end", ["\u2028", "\u2029", "\x85", "\x0b", "\x1c"])
def test_a_text_with_other_ends_of_lines_is_one_line_for_every_reader_and_comes_back(tmp_path, end):
    text, adapter = rf"one{end}\{end}\u2028 two", TypeAdapter(dict[str, str])
    line = with_checksum(adapter.dump_json({"a": text}))
    assert len(line.decode().splitlines()) == 1
    raw = adapter.dump_json({"a": text})[:-1]
    older = raw + b',"crc":"%08x"}' % zlib.crc32(raw)
    (tmp_path / "log").write_bytes(line + b"\n" + older + b"\n")
    assert [found["a"] for found in read_values(tmp_path / "log", adapter)] == [text, text]


@given(OBJECTS)
def test_a_line_comes_back_without_its_checksum(content):
    line = json.dumps(content).encode()
    marked = with_checksum(line)
    assert json.loads(marked) == {**content, "crc": json.loads(marked)["crc"]}
    assert without_checksum(marked + b"\n") == line


@pytest.mark.parametrize("line", [b"{}", b'{"a":1}', b'{"crc":"12345678","a":1}', b"", b'{"a":"x,crc"}'])
def test_a_line_without_a_checksum_is_refused(line):
    with pytest.raises(BadValue, match="checksum: got 'none', expected one at the end of the line"):
        without_checksum(line)


@pytest.mark.parametrize(
    ("line", "why"),
    [(with_checksum(b"no json}"), "Invalid JSON"), (with_checksum(b'{"a":"x"}'), "valid integer"),
     (b'{"a":1}', "checksum: got 'none'"), (with_checksum(b'{"a":1}').replace(b"1", b"2", 1), "the line was changed")],
)  # fmt: skip
def test_a_line_that_is_damaged_or_holds_another_value_is_named(tmp_path, line, why):
    (tmp_path / "log").write_bytes(with_checksum(b'{"a":1}') + b"\n" + line + b"\n" + b"torn")
    values = read_values(tmp_path / "log", TypeAdapter(dict[str, int]))
    assert next(values)["a"] == 1
    with pytest.raises(BadFile, match=f"log: line 2: .*{why}"):
        next(values)
