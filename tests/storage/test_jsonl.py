"""Files of lines: what a crash tore is cut off, and nothing else."""

from contextlib import closing

import pytest

from lockprobe.storage.jsonl import LineFile, whole_lines

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
    ],
    ids=["nothing", "one torn", "blank", "whole", "last torn", "long", "one long", "long after long", "zeroes"],
)
def test_an_unfinished_last_line_is_cut_off(tmp_path, content, kept):
    path = tmp_path / "lines"
    path.write_bytes(content)
    with closing(LineFile(path)) as file:
        file.cut_torn_tail()
        file.append(b"next")
    assert path.read_bytes() == kept + b"next\n"


@pytest.mark.parametrize("size", [65_535, 65_536, 65_537, 131_072])
def test_a_torn_line_of_any_length_is_cut_off_whole(tmp_path, size):
    path = tmp_path / "lines"
    path.write_bytes(b"a\n" + b"x" * size)
    with closing(LineFile(path)) as file:
        file.cut_torn_tail()
    assert path.read_bytes() == b"a\n"


def test_lines_are_numbered_as_in_the_file_and_torn_ones_are_none(tmp_path):
    path = tmp_path / "lines"
    path.write_bytes(b"a\n\n  \nb\r\ntorn")
    assert list(whole_lines(path)) == [(1, b"a\n"), (4, b"b\r\n")]
