"""Tables on a terminal of 80 columns and in a pipe: no number is cut."""

import io
from contextlib import redirect_stdout

import pytest

from lockprobe.cli.printing import new_table, print_table


class Terminal(io.StringIO):
    """Looks like a terminal."""

    def isatty(self):
        return True


@pytest.fixture(params=["terminal", "pipe"])
def shown(request, monkeypatch):
    """Prints something; gives what is written, and the width of the terminal."""
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.setenv("TERM", "dumb")

    def show(printing, *arguments):
        file = Terminal() if request.param == "terminal" else io.StringIO()
        with redirect_stdout(file):
            printing(*arguments)
        return file.getvalue(), 80 if file.isatty() else None

    return show


def test_what_does_not_fit_is_wider_and_whole(shown):
    table = new_table("name", *"abcdefgh")
    table.add_row("x", *["123456.789012"] * 8)
    text, _ = shown(print_table, table)
    assert text.splitlines()[1].split() == ["x", *["123456.789012"] * 8]


def test_names_with_colons_are_no_pictures(shown):
    table = new_table("agent", "robot:robot:robot")
    table.add_row("python:robot:Robot", "python:boom:Boom")
    text, _ = shown(print_table, table)
    assert text.split() == ["agent", "robot:robot:robot", "python:robot:Robot", "python:boom:Boom"]
