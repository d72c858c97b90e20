"""Tables on a terminal of 80 columns and in a pipe: no number is cut."""

import io
from contextlib import redirect_stdout

import pytest

from lockprobe.cli import power
from lockprobe.cli.printing import new_table, print_table
from lockprobe.simulation.power.simulator import Needed, Rate

TESTS = ("greatest difference from the lowest dose, permutation", "order 2 by AIC and cross-validation, maximum inside")


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


def test_power(shown):
    detected = dict(zip((15, 30, 60, 120, 240), (731, 812, 900, 950, 999), strict=True))
    measured = tuple(Rate(trials=trials, studies=1000, detected=many) for trials, many in detected.items())
    needed = Needed(measured=measured, trials=27, low=23, high=None, below=False)
    rows = [("as stated", test, needed) for test in TESTS]
    text, width = shown(power._print_tables, "test", rows, "trials per flip rate for 0.8")
    table = text[text.index("n=15") :]
    for number in ("0.73±0.01", "0.81±0.01", "0.90±0.01", "0.95±0.01", "1.00±0.00", "27", "[23,", "240]"):
        assert table.count(number) == len(TESTS)
    assert "…" not in text
    if width:
        assert max(map(len, table.splitlines())) <= width
    else:
        assert TESTS[1] in text
        assert "27 [23, more than 240]" in text


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
