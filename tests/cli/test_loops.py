"""``lockprobe loops``, as typed."""

import json
import random
from functools import partial

import pytest
from typed import in_process

from lockprobe.foundation.errors import BadFile, BadValue
from lockprobe.statistics.loops import cover

ask = partial(in_process, "loops")


def test_a_cycle_as_json():
    done = ask("-", "--json", stdin="A B C A B C A B C\n")
    assert json.loads(done.stdout) == {
        "n": 9, "any_loop": True, "coverage": 9, "share": 1.0,
        "words": [["A", "B", "C"]], "intervals": [[0, 3], [3, 3], [6, 3]],
    }  # fmt: skip
    assert done.stderr == ""


def test_the_same_in_words():
    assert ask(stdin="ABCABCABCX\n").stdout == ("10 actions: 9 in loops (90%): A B C at 0+3, 3+3, 6+3\n")
    assert ask(stdin="ABCD\n").stdout == "4 actions: no loop\n"


@pytest.mark.parametrize("solver", ["dp", "ilp"])
def test_both_solvers_cover_as_much(solver):
    done = ask("--json", "--solver", solver, stdin="001001010\n000010010000\n")
    assert [json.loads(line)["coverage"] for line in done.stdout.splitlines()] == [9, 12]


@pytest.mark.parametrize("options", [{}, {"overlap": True}, {"min_length": 2}])
def test_lines_are_the_library_line_by_line(options):
    rng = random.Random(4)
    lines = ["".join(rng.choices("AB", k=n)) for n in range(1, 25)]
    words = {"overlap": ["--overlap"], "min_length": ["--min-length", 2]}
    done = ask("--json", *(word for name in options for word in words[name]), stdin="\n".join(lines))
    for line, row in zip(lines, map(json.loads, done.stdout.splitlines()), strict=True):
        found = cover(line, **options)
        assert (row["n"], row["any_loop"], row["coverage"]) == (found.n, found.any_loop, found.covered)
        assert row["share"] == found.share
        assert [tuple(piece) for piece in row["intervals"]] == list(found.intervals)


def test_empty_lines_are_counted():
    done = ask("--json", stdin="ABCABC\n\n \t\n, ,\nABCD\n")
    assert (len(done.stdout.splitlines()), done.stderr) == (2, "3 empty lines skipped\n")
    assert ask(stdin="\nABCD\n").stderr == "1 empty line skipped\n"
    assert (ask(stdin="").stdout, ask(stdin="").stderr) == ("", "")


@pytest.mark.parametrize(
    "line", ['["A","B","C","A","B","C"]', "A;B;C;A;B;C", "A->B->C->A->B->C", "A | B | C | A | B | C"]
)
def test_usual_separators_and_json_are_read(line):
    assert json.loads(ask("--json", stdin=line).stdout)["words"] == [["A", "B", "C"]]


def test_a_line_whose_separator_would_be_an_action_is_named():
    with pytest.raises(
        BadFile, match=r"-: line 2: sequence: got 'A/B/C', expected one with blanks, commas, .*: '/' would"
    ):
        ask(stdin="ABC\nA/B/C\n")


def test_what_editors_write_is_read(tmp_path):
    (tmp_path / "bom.txt").write_bytes(b"\xef\xbb\xbfABCABC\r\n\r\n")
    assert json.loads(ask(tmp_path / "bom.txt", "--json").stdout)["coverage"] == 6
    (tmp_path / "other.txt").write_bytes(b"\xff\xfe")
    with pytest.raises(BadFile, match="other.txt: not text in UTF-8"):
        ask(tmp_path / "other.txt")


def test_a_line_too_long_for_the_programme_is_named_with_a_way_out():
    with pytest.raises(BadFile, match="line 2: actions for the solver ilp: got 121, expected at most 120; dp"):
        ask("--solver", "ilp", stdin="ABC\n" + "A" * 121)
    assert json.loads(ask("--json", stdin="ABC" * 4000).stdout)["coverage"] == 12_000


def test_ten_thousand_lines_go_through_at_once():
    rng = random.Random(1)
    lines = "\n".join(" ".join(rng.choices("ABCD", k=20)) for _ in range(10_000))
    rows = [json.loads(line) for line in ask("--json", stdin=lines).stdout.splitlines()]
    assert len(rows) == 10_000
    assert 0.78 < sum(row["any_loop"] for row in rows) / 10_000 < 0.82  # chance: 0.8008


def test_only_line_ends_end_a_line():
    text = "A B C\u2028A B C\nA B\x85A B\r\nA\x0bA\x0cA\x1cA\rAB"
    assert [json.loads(line)["n"] for line in ask("--json", stdin=text).stdout.splitlines()] == [6, 4, 4, 2]


def test_a_file_without_a_name_is_refused():
    with pytest.raises(BadValue, match="file: got '', expected the name of a file"):
        ask("")


def test_actions_do_not_steer_the_terminal():
    line = "\x1b[31m \u202eX é " * 2
    said = ask(stdin=line).stdout
    assert said.endswith(": ?[31m ?X é at 0+3, 3+3\n")
    assert json.loads(ask("--json", stdin=line).stdout)["words"] == [["\x1b[31m", "\u202eX", "é"]]


def test_a_shortest_loop_beyond_every_number_is_never_reached():
    huge = ask("--min-length", 10**20, stdin="ABC" * 70_000)
    assert huge.stdout == "210000 actions: no loop\n"
