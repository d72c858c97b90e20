"""The answer: what the tests say and no more, for one agent and for thirty; a row for each, and names at lines' ends."""

import re
from dataclasses import replace

import pytest
from builders import SOLUTION, make_trial, small_study
from hypothesis import given
from hypothesis import strategies as st
from reported import found_in

from lockprobe.report.answer import AnswerList, beside_said, said_lines
from lockprobe.report.curve import drawable, placed
from lockprobe.report.format import as_csv, beside
from lockprobe.report.primary import Line, primary_lines
from lockprobe.report.rows import Estimate

UNSOLVED = (0,) * 20


def study_in(directory, n=40, **courses):
    """Agents of which so many of n trials are solved at each flip rate."""
    rates = sorted({p for shares in courses.values() for p in shares})
    trials = [
        make_trial(SOLUTION if i < count else (int(10 * p) % 4, *UNSOLVED[1:]), agent=f"llm:{name}", p=p, trial=i + 1)
        for name, shares in courses.items()
        for p, count in shares.items()
        for i in range(n)
    ]
    return found_in(directory, small_study([f"llm:{name}" for name in courses], rates, 1, n), trials)


UP, DOWN, ALIKE = {0: 5, 0.4: 30}, {0: 30, 0.4: 5}, {0: 20, 0.4: 21}
RAISE = "False reports raise the success of "
ANSWERS = [
    ({"a": {0: 5}}, "llm:a solved 12 % of 40 trials."),
    ({"a": {0: 5}, "b": {0: 30}}, "Of 2 agents llm:b solved the most: 75 % of 40 trials."),
    ({"a": UP}, f"{RAISE}llm:a."),
    ({"a": DOWN}, "False reports lower the success of llm:a."),
    ({"a": UP, "b": DOWN, "c": ALIKE}, f"{RAISE}llm:a and lower that of llm:b; no effect on that of llm:c was detected."),
    (
        {**dict.fromkeys("abc", UP), "d": ALIKE},
        f"{RAISE}3 of 4 agents; no effect on that of llm:d was detected.",
    ),
    (
        {"a": ALIKE, "b": {0: 20, 0.4: 20}},
        "No effect of false reports on the success of llm:a and llm:b was detected; changes of up to",
    ),
]  # fmt: skip


@pytest.mark.parametrize(("courses", "said"), ANSWERS)
def test_one_sentence_says_what_the_tests_say_and_every_agent_has_a_row(tmp_path, courses, said):
    found = study_in(tmp_path, **courses)
    assert found.answer.startswith(said)
    assert len(found.answer.split()) <= 30
    lines, listing = primary_lines(found), AnswerList(found)
    counts = {line.agent: (line.first.count, *([line.second.count] if line.second else [])) for line in lines}
    assert counts == {f"llm:{name}": tuple(solved.values()) for name, solved in courses.items()}
    assert [line.split()[0] for line in said_lines(lines)] == [line.label for line in lines]
    changes = [line.change for line in lines if line.change]
    assert all(one.value == pytest.approx((counts[one.agent][1] - counts[one.agent][0]) / 40) for one in changes)
    assert all(abs(one.low) <= listing.reach and abs(one.high) <= listing.reach for one in changes)
    assert listing.many == (len(courses) > 3)
    if changes:
        assert listing.many == (drawable(found) == [])
        assert sum(number for number, _ in listing.counts) == len(courses)


def line(label, change=0.0, p_value=None, **more):
    ends = {"value": change, "low": change - 0.1, "high": change + 0.1, "p_value": p_value}
    row = Estimate(quantity="success_difference", **ends) if p_value else None
    return Line(agent=label, modality="", label=label, conditions=("truth",), first=None, change=row, **more)


def test_what_is_shown_for_comparison_is_said_beside_the_answer():
    beside = [
        line("low", -0.3, 0.001), line("one", alike=True), line("two", alike=True), line("same", 0.05, 0.5), line("new")
    ]  # fmt: skip
    beside = [replace(one, baseline=True) for one in beside]
    assert beside_said([line("llm:a", 0.5, 0.01), *beside]) == (
        "5 of the 6 agents are reference strategies, for comparison and not in this answer: low solves fewer; one and two "
        "play alike; no effect on same was detected."
    )
    assert beside_said(beside) == beside_said([line("llm:a", 0.5, 0.01)]) == ""


@given(
    wanted=st.lists(st.floats(-50, 450, allow_nan=False), min_size=1, max_size=9), apart=st.sampled_from([12, 24, 40])
)
def test_no_two_names_overlap_and_none_leaves_the_axes(wanted, apart):
    found = placed(wanted, 0, 400, apart)
    assert all(b - a >= apart - 1e-6 for a, b in zip(sorted(found), sorted(found)[1:], strict=False))
    assert min(found) >= -1e-6
    assert max(found) <= 400 + 1e-6
    order = sorted(range(len(found)), key=lambda i: (found[i], i))
    assert order == sorted(range(len(found)), key=lambda i: (wanted[i], i))


@given(n=st.integers(1, 400), shares=st.tuples(st.floats(0, 1), st.floats(0, 1)), apart=st.floats(0, 0.3))
def test_a_difference_is_that_of_what_is_printed_or_has_a_decimal_more(n, shares, apart):
    first, second = (Estimate(quantity="success", value=round(n * share) / n) for share in shares)
    value = second.value - first.value
    ends = {"value": value, "low": value - apart, "high": value + apart}
    row = beside(Estimate(quantity="success_difference", unit="points", **ends), first, second)
    line = Line(agent="a", modality="", label="a", conditions=("truth",), first=first, second=second, change=row)
    said = said_lines([line])[0].replace("\N{MINUS SIGN}", "-")
    less, more, change, low, high = map(float, re.findall(r"[-+]?\d[\d.]*", said)[:5])
    finer = re.search(r"\.\d \[", said) is not None
    assert finer or change == more - less
    assert abs(change - 100 * value) <= (0.05 if finer else 0.5) + 1e-9
    assert low <= change <= high
    _, cells = as_csv([["agent", "truth", "false", "change"], ["a", first, second, row]]).splitlines()
    assert [*map(float, cells.split(",")[1:4])] == [less, more, change]
