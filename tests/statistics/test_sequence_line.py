"""What a line of actions may look like, and what no line may: punctuation as an action."""

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lockprobe.foundation.errors import BadValue
from lockprobe.statistics.loops.sequence_line import parse_sequence


@pytest.mark.parametrize(
    ("line", "actions"),
    [
        ("A B C A", ("A", "B", "C", "A")),
        ("left, right,up\tdown", ("left", "right", "up", "down")),
        ("slider1,", ("slider1",)),
        ("  \n", ()),
        (", ,", ()),
        ("A --> B ==> C", ("A", "B", "C")),
        ("A ⇒ B⟶C", ("A", "B", "C")),
        ("A B A'", ("A", "B", "A'")),
        ("slider-1 -> slider_2", ("slider-1", "slider_2")),
        ("A; B;", ("A", "B")),
        ('["A","B"]', ("A", "B")),
        ("[0, 1, 10]", ("0", "1", "10")),
        ('["slider 1", "->", ","]', ("slider 1", "->", ",")),
        ('{"trial": 3, "actions": ["A", "B"]}', ("A", "B")),
        ("äöß", ("ä", "ö", "ß")),
        ("-1 +1 -1", ("-1", "+1", "-1")),
    ],
)
def test_a_line_is_read_as_actions(line, actions):
    assert parse_sequence(line) == actions


@pytest.mark.parametrize(
    "line",
    [
        "A-B-C-A-B-C", "A/B/C", "A.B.C", "A:B:C", "A_B_C", "A+B", "A>B>C", "A\u2013B", "A·B", "'ABC'", '"ABC"', "(A)",
        "A - B - C", "A / B / C", "A > B", "A . B", "A, -, B",
        "(A, B, A, B)", "(A B A B)", "(1, 2, 1",
        "A; B, C", "A -> B | C", "A;B|C",
        '"A B A B"', '"A","B","A"', "'A B A B'", "'A','B'", "“A B A B”", "<A B A B>", "{A B}",
        "A, B, A, B.", "A B A B!", "trial 1: A B", "joints: A B A B", "1. A 2. B", '"A;B;A"',
        "push A; push B", "slider 1 -> slider 2", "slider 1 | slider 2",
        "[A, B]", "['A', 'B']", '["A"', '[["A", "B"], ["C"]]', '[{"joint": "A"}]', '["A", 1]', "[true]", "[null]", "[0.5]",
        '{"a": ["A"], "b": ["B"]}', '{"a": 1}', "{}", "[" * 100_000,
    ],
)  # fmt: skip
def test_what_has_two_readings_or_would_count_punctuation_is_refused_in_one_line(line):
    with pytest.raises(BadValue) as refused:
        parse_sequence(line)
    assert "\n" not in str(refused.value)
    assert len(str(refused.value)) < 260


NAMES = st.lists(st.text(st.characters(categories=["L", "N"]), min_size=1, max_size=6), min_size=2, max_size=12)


@given(NAMES, st.sampled_from([" ", ",", ", ", ";", " ; ", "|", " | ", "->", " -> ", " → ", "\t", "=>"]))
def test_every_separator_gives_back_the_actions(names, separator):
    assert parse_sequence(separator.join(names)) == tuple(names)


@given(st.lists(st.text(), max_size=12))
def test_a_json_array_holds_any_action(names):
    assert parse_sequence(json.dumps(names)) == tuple(names)


@given(st.text(st.characters(exclude_categories=["Cs"]), max_size=30))
def test_no_action_is_punctuation_alone(line):
    try:
        actions = parse_sequence(line)
    except BadValue:
        return
    if line.strip()[:1] not in ("[", "{"):
        assert all(any(character.isalnum() for character in action) for action in actions)
