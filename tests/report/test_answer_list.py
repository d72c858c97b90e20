"""The list of agents, the sentence above it, and the names at the ends of lines."""

import pytest
from builders import SOLUTION, make_trial, small_study
from hypothesis import given
from hypothesis import strategies as st
from reported import found_in

from lockprobe.report.answer import headline
from lockprobe.report.answer_list import answer_list, said_lines
from lockprobe.report.curve import curve_figure, drawable, placed
from lockprobe.report.rows.primary import primary_lines


@given(
    wanted=st.lists(st.floats(-50, 450, allow_nan=False), min_size=1, max_size=9),
    apart=st.sampled_from([12, 24, 40]),
)
def test_no_two_names_overlap_and_none_leaves_the_axes(wanted, apart):
    found = placed(wanted, 0, 400, apart)
    low, high = min(found), max(found)
    assert all(b - a >= apart - 1e-6 for a, b in zip(sorted(found), sorted(found)[1:], strict=False))
    assert (low >= -1e-6, high <= 400 + 1e-6) == (True, True)
    assert [i for _, i in sorted(zip(found, range(len(found)), strict=True))] == [
        i for _, i in sorted(zip(wanted, range(len(wanted)), strict=True))
    ]


def study_in(directory, solved):
    """Agents of which so many of twenty trials are solved when told the truth, and at a flip rate of 0.4."""
    trials = [
        make_trial(SOLUTION if i < count else (0,) * 20, agent=agent, p=p, trial=i + 1)
        for agent, counts in solved.items()
        for p, count in zip((0.0, 0.4), counts, strict=True)
        for i in range(20)
    ]
    return found_in(directory, small_study(tuple(solved), (0.0, 0.4), 1, 20), trials)


@pytest.mark.parametrize(
    ("solved", "said"),
    [
        ({"llm:a": (2, 18)}, "False reports raise the success of llm:a."),
        ({"llm:a": (18, 2)}, "False reports lower the success of llm:a."),
        (
            {"llm:a": (9, 9)},
            "No effect of false reports on the success of llm:a was detected; changes of up to 16 points are not excluded.",
        ),
        (
            {"llm:a": (2, 18), "llm:b": (18, 2), "llm:c": (10, 11)},
            "False reports raise the success of llm:a and lower that of llm:b; no effect on that of llm:c was detected.",
        ),
        (
            {**{f"llm:{one}": (1, 19) for one in "abcd"}, **{f"llm:{one}": (9, 9) for one in "efg"}},
            "False reports raise the success of 4 agents; no effect on that of 3 agents was detected.",
        ),
    ],
)
def test_one_sentence_serves_one_agent_and_many_and_every_agent_has_a_row(tmp_path, solved, said):
    found = study_in(tmp_path, solved)
    lines = primary_lines(found)
    assert headline(lines, "false reports") == said
    assert {line.agent for line in lines} == {*solved}
    for line in lines:
        first, second = (count / 20 for count in solved[line.agent])
        assert (line.first.value, line.second.value, line.change.value) == pytest.approx(
            (first, second, second - first)
        )
    listing = answer_list(found)
    assert listing.many == (len(solved) > 3) == (drawable(found) == [])
    assert sum(number for number, _ in listing.counts) == len(solved)
    assert [line.split()[0] for line in said_lines(lines)] == [line.label for line in lines]
    assert all(abs(line.change.low) <= listing.reach and abs(line.change.high) <= listing.reach for line in lines)


def test_the_figure_names_every_line_wide_and_narrow(tmp_path):
    found = study_in(tmp_path, {"llm:a": (2, 18), "llm:b": (18, 2)})
    for wide in (True, False):
        drawn = curve_figure(found, wide=wide)
        assert all(f">{name} {share} %</text>" in drawn for name, share in (("llm:a", 90), ("llm:b", 10)))
        assert drawn.count('class="told"') == drawn.count('class="false"') - 2 * (not wide)  # points and intervals
