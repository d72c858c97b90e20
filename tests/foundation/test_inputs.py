"""What comes from elsewhere is read with bounds: a pipe, a device, a file without end are refused and never waited for."""

import os
import socket
from pathlib import Path

import pytest

from lockprobe.foundation.errors import BadFile
from lockprobe.foundation.inputs import is_there, parse_json, read_input


@pytest.fixture
def pipe(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    return tmp_path / "pipe"


def test_only_regular_files_are_read(tmp_path, pipe):
    with socket.socket(socket.AF_UNIX) as bound:
        bound.bind(str(tmp_path / "socket"))
    (tmp_path / "link").symlink_to(pipe)
    for name in ("pipe", "link", "socket", ".", "/dev/zero"):
        with pytest.raises(BadFile, match="not a regular file$"):
            is_there(tmp_path / name)
        with pytest.raises(BadFile, match="not a regular file$|cannot be read .(Is a directory|No such device)"):
            read_input(tmp_path / name)
    with pytest.raises(BadFile, match="absent: cannot be read"):
        read_input(tmp_path / "absent")
    (tmp_path / "file").write_bytes(b"12345")
    (tmp_path / "other").symlink_to("file")
    assert read_input(tmp_path / "other", most=5) == b"12345"
    assert [is_there(tmp_path / name) for name in ("file", "absent")] == [True, False]


@pytest.mark.parametrize("content", [b"[" * 100_000, b"{", b"1" * 5000, b"\xff"])
def test_json_that_is_none_or_too_deep_is_one_line(content):
    with pytest.raises(BadFile, match="^x: not JSON"):
        parse_json(content, Path("x"))
