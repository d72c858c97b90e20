"""An agent has one colour and one mark in every report."""

from dataclasses import replace
from itertools import combinations

from lockprobe.agents.cognitive import CHARACTERS, MODELS
from lockprobe.figures.palette import shifts, styles


def looks(study, names):
    """Colour and marker of agents of these names, the first one the study's own."""
    agents = [replace(agent, agent=name) for agent, name in zip(study.agents, names, strict=False)]
    return {agent.agent: (style.colour, style.marker) for agent, style in styles(replace(study, agents=tuple(agents)))}


def test_an_agent_looks_the_same_whoever_is_beside_it(studies):
    """In another place, among others, and whether the study is about it or not."""
    first = looks(studies["three"], ["llm:a/x", "llm:local", "human-inspired", "random", "round-robin"])
    other = looks(studies["three"], ["random", "human-inspired", "llm:a/x"])
    alone = looks(studies["three"], ["llm:a/x"])
    assert other.items() <= first.items()
    assert alone.items() <= first.items()


def test_looks_do_not_change_from_release_to_release(studies):
    found = looks(studies["three"], ["participant", "llm:local", "human-inspired", "random", "llm:openai/gpt-4o"])
    assert found == {
        "participant": ("#0072B2", "o"),
        "llm:local": ("#D55E00", "s"),
        "human-inspired": ("#009E73", "D"),
        "random": ("#7a7a7a", "X"),
        "llm:openai/gpt-4o": ("#AA4499", "h"),
    }


COGNITIVE = [f"cognitive:{name}" for name in (*CHARACTERS, *MODELS)]


def test_cognitive_agents_have_colours_of_their_own(studies):
    found = looks(studies["three"], [*COGNITIVE, "human-inspired"])
    assert len({colour for colour, _ in found.values()}) == len({marker for _, marker in found.values()}) == 6
    assert "#AA4499" not in {colour for colour, _ in found.values()}
    beside = looks(studies["three"], ["llm:openai/gpt-4o", *COGNITIVE])
    assert beside["llm:openai/gpt-4o"] == ("#AA4499", "h")  # and no agent has another look because of them


def test_agents_of_one_colour_share_neither_marker_nor_dash(studies):
    """Of so many specs more than one has to get a colour again."""
    agent = studies["three"].agents[0]
    for i in range(40):
        names = [f"llm:a/{i}", f"llm:b/{i}", f"cognitive:random-map?window={i}"]
        shown = tuple(replace(agent, agent=name) for name in names)
        found = [style for _, style in styles(replace(studies["three"], agents=shown))]
        for one, other in combinations(found, 2):
            assert one.colour != other.colour or (one.marker != other.marker and one.dash != other.dash), names


def test_agents_of_one_study_have_different_colours_as_long_as_there_are_enough(studies):
    """The colour of an agent that does not ship comes out of its name: two of three could get the same."""
    for i in range(40):
        names = [f"llm:openai/gpt-{i}", f"llm:anthropic/claude-{i}", f"llm:google/gemini-{i}", "random", "participant"]
        found = looks(studies["three"], names)
        assert len({colour for colour, _ in found.values()}) == len(found)


def test_agents_differ_in_grey_as_well(studies):
    for study in studies.values():
        found = [style for _, style in styles(study)]
        assert len({(style.marker, style.dash) for style in found}) == len(found)
        assert [style.lead for style in found] == sorted((style.lead for style in found), reverse=True)
        assert {agent.agent for agent, style in styles(study) if style.lead} == {a.agent for a in study.subjects}


def test_ways_of_showing_the_box_are_shades_of_one_colour(studies):
    agent = studies["three"].agents[0]
    shown = [replace(agent, modality=one, shown=one) for one in ("rgb", "rgbd", "symbolic")]
    found = [style for _, style in styles(replace(studies["three"], agents=tuple(shown)))]
    assert len({style.marker for style in found}) == 1
    assert len({style.colour for style in found}) == len({style.dash for style in found}) == 3


def test_bars_of_agents_are_moved_apart(studies):
    moved = list(shifts(studies["three"]).values())
    assert len(set(moved)) == len(moved) == 6
    assert moved[0] == 0
    assert max(map(abs, moved)) < 0.05
