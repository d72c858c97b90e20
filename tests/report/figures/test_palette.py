"""An agent has one colour and one mark in every report."""

from itertools import combinations

import numpy as np
import pytest
from drawn import course
from matplotlib.colors import to_rgb

from lockprobe.agents.cognitive import CHARACTERS, MODELS
from lockprobe.report.figures.palette import SUBJECTS, of_text, shifts, styles

NAMED = ["participant", "llm:local", "human-inspired", "random", "llm:openai/gpt-4o"]
COGNITIVE = [f"cognitive:{name}" for name in (*CHARACTERS, *MODELS)]


def drawn(names, **more):
    return [style for _, style in styles([course(name, **more) for name in names])]


def looks(names, **more):
    """Colour and marker of agents of these names."""
    return dict(zip(names, ((style.colour, style.marker) for style in drawn(names, **more)), strict=True))


def test_an_agent_looks_the_same_whoever_is_beside_it():
    """In another place, among others, and whether the study is about it or not."""
    first = looks(["llm:a/x", "llm:local", "human-inspired", "random", "round-robin"])
    other = looks(["random", "human-inspired", "llm:a/x"], subject=False)
    alone = looks(["llm:a/x"])
    assert other.items() <= first.items()
    assert alone.items() <= first.items()


def test_looks_do_not_change_from_release_to_release():
    assert looks(NAMED) == {
        "participant": ("#0072B2", "o"),
        "llm:local": ("#D55E00", "s"),
        "human-inspired": ("#009E73", "D"),
        "random": ("#7a7a7a", "X"),
        "llm:openai/gpt-4o": ("#AA4499", "h"),
    }


def test_cognitive_agents_have_colours_of_their_own():
    found = looks([*COGNITIVE, "human-inspired"])
    assert len({colour for colour, _ in found.values()}) == len({marker for _, marker in found.values()}) == 6
    assert "#AA4499" not in {colour for colour, _ in found.values()}
    beside = looks(["llm:openai/gpt-4o", *COGNITIVE])
    assert beside["llm:openai/gpt-4o"] == ("#AA4499", "h")  # and no agent has another look because of them


def test_agents_of_one_colour_share_neither_marker_nor_dash():
    """Of so many specs more than one has to get a colour again."""
    for i in range(40):
        names = [f"llm:a/{i}", f"llm:b/{i}", f"cognitive:random-map?window={i}"]
        for one, other in combinations(drawn(names), 2):
            assert one.colour != other.colour or (one.marker != other.marker and one.dash != other.dash), names


def test_agents_of_one_study_have_different_colours_as_long_as_there_are_enough():
    """The colour of an agent that does not ship comes out of its name: two of three could get the same."""
    for i in range(40):
        found = looks([f"llm:openai/gpt-{i}", f"llm:anthropic/claude-{i}", f"llm:google/gemini-{i}", *NAMED[::3]])
        assert len({colour for colour, _ in found.values()}) == len(found)


def test_agents_differ_in_grey_as_well(studies):
    for case in ("strategies", "hostile names", "people"):
        courses = studies[case].courses()
        found = [style for _, style in styles(courses)]
        assert len({(style.marker, style.dash) for style in found}) == len(found) == len(courses)
        assert [style.lead for style in found] == sorted((style.lead for style in found), reverse=True)
        assert {one.agent for one, style in styles(courses) if style.lead} == set(studies[case].subjects)


def test_ways_of_showing_the_box_are_shades_of_one_colour():
    found = [style for _, style in styles([course("llm:x", one, shown=one) for one in ("rgb", "rgbd", "symbolic")])]
    assert len({style.marker for style in found}) == 1
    assert len({style.colour for style in found}) == len({style.dash for style in found}) == 3


def test_bars_of_agents_are_moved_apart(studies):
    moved = list(shifts(studies["three"].courses()).values())
    assert len(set(moved)) == len(moved) == 6
    assert moved[0] == 0
    assert max(map(abs, moved)) < 0.05


@pytest.mark.parametrize("colour", [*SUBJECTS, "#ffffff", "#95d840", "#e69f57", "#000000"])
def test_text_in_a_colour_is_dark_enough_on_white_and_not_darker_than_it_has_to_be(colour):
    def contrast(of):
        parts = [part / 12.92 if part <= 0.04 else ((part + 0.055) / 1.055) ** 2.4 for part in to_rgb(of)]
        return 1.05 / (0.05 + np.dot([0.2126, 0.7152, 0.0722], parts))

    found = of_text(colour)
    assert contrast(found) >= 4.5
    assert found == colour or contrast(found) < 5.2
