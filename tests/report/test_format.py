"""Tables stay tables, whatever an agent is called."""

import csv
import io

import pytest

from lockprobe.foundation.terminal_text import printable
from lockprobe.report.format import as_csv

HOSTILE = "a\nb\x00\x1b\t\u202e\u2066\u2069c"


def test_what_is_not_seen_is_a_question_mark():
    assert printable(HOSTILE) == "a?b??????c"
    assert printable("Ünï ±5 % \u9501") == "Ünï ±5 % \u9501"


@pytest.mark.parametrize("lead", ["=", "+", "-", "@", "\t", "\r"])
def test_no_cell_is_a_formula(lead):
    ((cell, plain),) = csv.reader(io.StringIO(as_csv([[f"{lead}1+1", "1+1"]])))
    assert cell == f"'{printable(lead)}1+1"
    assert plain == "1+1"


def test_nothing_invisible_is_in_a_file():
    table = [["agent", "p"], [HOSTILE, "0"]]
    assert as_csv(table) == "agent,p\na?b??????c,0\n"
