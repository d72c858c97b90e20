"""``lockprobe loops`` and ``lockprobe chance``, as typed."""

import json
from functools import partial

import pytest
from typed import in_process

from lockprobe.cli.loops import parse_sequence
from lockprobe.foundation.errors import BadFile, BadValue
from lockprobe.statistics.loops.chance import chance_level

loops, chance = partial(in_process, "loops"), partial(in_process, "chance")


def rows(*words, stdin):
    return [json.loads(line) for line in loops("--json", *words, stdin=stdin).stdout.splitlines()]


def test_a_cycle_as_json_and_in_words():
    found = {"n": 9, "any_loop": True, "coverage": 9, "share": 1.0,
             "words": [["A", "B", "C"]], "intervals": [[0, 3], [3, 3], [6, 3]]}  # fmt: skip
    for words in ((), ("--solver", "ilp")):
        assert rows(*words, stdin="A B C A B C A B C\n") == [found]
    assert loops(stdin="ABCABCABCX\n").stdout == "10 actions: 9 in loops (90%): A B C at 0+3, 3+3, 6+3\n"
    assert loops(stdin="ABCD\n").stdout == "4 actions: no loop\n"


def test_empty_lines_are_skipped_and_only_line_ends_end_them():
    assert len(rows(stdin="ABCABC\n\n \t\n, ,\nABCD\n")) == 2
    text = "\ufeffA B C\u2028A B C\nA B\x85A B\r\nA\x0bA\x0cA\x1cA\rAB"
    assert [row["n"] for row in rows(stdin=text)] == [6, 4, 4, 2]


def test_the_level_of_a_length():
    found = json.loads(chance("--length", 10, "--null", "no-repeat", "--json").output)
    assert found == {"probability": chance_level(10, null="no-repeat").probability, "method": "exact", "error": 0.0}
    assert chance().output == "0.8008 (exact; uniform, 20 steps, 4 joints)\n"


@pytest.mark.parametrize(
    ("words", "stdin", "said"),
    [
        ([""], "", "Is a directory"),
        (["-"], b"\xff\xfe\x00", "not text in UTF-8"),
        ([], "ABC\nA/B/C\n", "-: line 2: sequence: got 'A/B/C', expected actions with blanks or c"),
        (["--solver", "ilp"], "ABC\n" + "A" * 121, "line 2: actions for the solver ilp: got 121"),
    ],
)
def test_what_cannot_be_read_is_refused(words, stdin, said):
    with pytest.raises(BadFile) as found:
        loops(*words, stdin=stdin)
    assert said in str(found.value)


@pytest.mark.parametrize(
    ("line", "actions"),
    [
        ("left, right,up\tdown left", ["left", "right", "up", "down", "left"]),
        ("slider1,", ["slider1"]),
        (", ,", []),
        ("-1 +1 A'", ["-1", "+1", "A'"]),
        ("äöß", ["ä", "ö", "ß"]),
        *((line, None) for line in (
            "A-B-C", "A/B", "A.B", "A_B", "A>B", "A - B", "(A B)", "A; B", "A->B", '"A B A"', "trial 1: A", "1. A 2. B",
            "[A, B]", '["A", "B"]', "[" * 100_000,
        )),
    ],
)  # fmt: skip
def test_a_line_is_read_as_actions_and_what_would_count_punctuation_is_refused(line, actions):
    if actions is None:
        with pytest.raises(BadValue, match="sequence"):
            parse_sequence(line)
    else:
        assert [*parse_sequence(line)] == actions
