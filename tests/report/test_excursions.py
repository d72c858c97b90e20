"""The heading of the section on one false report: the change of success of the first agents, with intervals."""

from lockprobe.report.excursions import ExcursionResult, LieResult, lies_answer


def row(agent, *effects, among="all"):
    found = [
        ExcursionResult(
            outcome="solved", among=among, what="", where="", effect=effect, low=effect - 0.1, high=effect + 0.1,
            p_value=0.5, points=800, clusters=18, smallest=0.15,
        )
        for effect in effects
    ]  # fmt: skip
    return LieResult(agent=agent, modality="symbolic", said="", effects=found, left_out=[])


def test_the_heading_has_the_change_of_success_with_its_interval():
    assert lies_answer([row("a", -0.01), row("b", 0.2)]) == (
        "Success after one more false report, in points: \N{MINUS SIGN}1 [\N{MINUS SIGN}11, +9] a; +20 [+10, +30] b."
    )


def test_further_agents_are_counted_and_effects_on_some_reports_are_left_out():
    many = [row(name, 0.2) for name in "abcde"]
    assert lies_answer(many).endswith("c and 2 more.")
    assert lies_answer([row("a", 0.2, among="in a loop"), row("b")]) == ""
