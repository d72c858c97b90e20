"""Conditions against the control: a circle each, squares for interactions, filled where they were detected."""

from lockprobe.figures.effects import effects
from lockprobe.rows import Condition, Design, Estimate, Player, Results


def difference(condition, value, agent="random", p_value=0.5, **more):
    ends = {"value": value, "low": value - 0.1, "high": value + 0.1, "n": 20}
    of = {"quantity": "success_difference", "agent": agent, "condition": condition, "control": "truth"}
    return Estimate(**of | ends | more, modality="symbolic?tell=state", p_value=p_value)


def found_of(rows):
    shown = {"modality": "symbolic?tell=state"}
    names = ("nudge", "drop?p=1", "nudge + drop?p=1", "lie")
    return Results.model_construct(
        rows=rows,
        design=Design(
            conditions=[
                Condition(name="truth", **shown),
                *(Condition(name=n, control="truth", **shown) for n in names),
            ],
            players=[Player(agent=agent, **shown) for agent in ("random", "round-robin", "participant")],
        ),
    )


def test_marks_are_differences_and_interactions_of_one_agent_and_filled_if_detected():
    crossed = {"quantity": "success_interaction", "of": "nudge \N{MULTIPLICATION SIGN} drop?p=1"}
    found = [
        difference("nudge", 0.2, p_value=0.01),
        difference("drop?p=1", 0.05, p_value=0.01, n=12),  # its interval holds 0
        difference("nudge + drop?p=1", -0.3, p_value=0.02, **crossed),
        difference("nudge", 0.4, agent="round-robin"),
        difference("nudge", 0.7, control="", versus="round-robin"),
        difference("lie", 0.7, of="lie"),
    ]
    axes, other = effects(found_of(found)).axes
    marks = [line for line in axes.lines if line.get_linestyle() == "None"]
    assert [(mark.get_marker(), mark.get_xdata()[0]) for mark in marks] == [("o", 0.2), ("o", 0.05), ("s", -0.3)]
    assert [mark.get_markerfacecolor() == mark.get_color() for mark in marks] == [True, False, True]
    assert "n = 12 to 20 pairs of trials" in axes.get_title(loc="left").replace("\n", " ")
    assert len([line for line in other.lines if line.get_linestyle() == "None"]) == 1


def test_agents_share_one_axis_and_people_are_called_people():
    found = [difference("nudge", 0.1), difference("nudge", 0.6, agent="participant")]
    first, second = effects(found_of(found)).axes
    assert first.get_xlim() == second.get_xlim()
    assert second.get_xlim()[1] > 0.7
    assert second.get_title(loc="left").startswith("people\n")


def test_without_a_comparison_there_is_nothing_to_draw():
    assert effects(found_of([])) is None
