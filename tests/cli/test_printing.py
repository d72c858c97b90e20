"""Tables on a terminal of 80 columns and in a pipe: no number is cut."""

import io
from contextlib import redirect_stdout

import pytest

from lockprobe.cli.printing import print_rows


class Terminal(io.StringIO):
    """Looks like a terminal."""

    def isatty(self):
        return True


@pytest.mark.parametrize("kind", [Terminal, io.StringIO])
def test_no_number_is_cut(monkeypatch, kind):
    monkeypatch.setenv("COLUMNS", "80")
    names = ["the name of something that is told in many words, one after another", "x", "python:robot:Robot"]
    rows = [["name", *"abcde"], *([name, *["123456.789012"] * 5] for name in names), ["", *"12345"]]
    with redirect_stdout(kind()) as file:
        print_rows(rows)
    text = file.getvalue()
    assert text.count("123456.789012") == 15
    assert " ".join(text.split()).count("something") == 1
    lines = text.splitlines()
    if kind is io.StringIO:
        assert [" ".join(line.split()) for line in lines] == [" ".join(row).strip() for row in rows]
    else:
        assert max(map(len, lines)) <= len("something") + 2 * 5 + 13 * 5 + 10  # the longest word, and no more
    assert text.split()[:2] == ["name", "a"]
