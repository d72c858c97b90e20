"""Why: two plain sentences an agent that follow from the rows."""

import pytest
from reported import found_in

from lockprobe.report.page import parts_of
from lockprobe.report.questions.first_screen import answer_of
from lockprobe.report.questions.why import TABLE
from lockprobe.statistics.why import CONTRASTS
from lockprobe.studies.options.studyfile import study

AGENTS = ["cognitive:perseverant", "cognitive:softmax-memory"]


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    """The results of a small study of controls."""
    return found_in(tmp_path_factory.mktemp("why"), study("why", agent=AGENTS, trials=50, repetitions=1))


def test_where_no_effect_is_detected_no_part_is_computed_or_shown(found):
    assert {row.of for row in found.where("arm_contrast", agent=AGENTS[0])} == set(CONTRASTS)
    assert found.where("arm_contrast", agent=AGENTS[1]) == []
    named, drawn = zip(*((row[0], row[4]) for row in TABLE.cells(found)[1:]), strict=True)
    assert [*named] == [row.agent for row in drawn] == [AGENTS[0]] * (1 + len(CONTRASTS)) + [AGENTS[1]]
    assert [row.quantity == "arm_contrast" for row in drawn] == [False, *[True] * len(CONTRASTS), False]
    (part,) = [part for part in parts_of(found) if part.name == "why"]
    assert part.answer == "A cause is named for 1 of 2 agents."
    (evidence,) = part.blocks[0]
    assert evidence == (
        f"{AGENTS[0]}: of reports that are given and then corrected, a false last statement raises it, whatever the first "
        "one says."
    )
    assert found.answer == (
        f"False reports raise the success of {AGENTS[0]}, because of what they say. No effect of false reports on the "
        f"success of {AGENTS[1]} was detected, and a change of 10 points or more is excluded."
    )


def test_agents_for_comparison_are_not_in_the_answer(found):
    players = tuple(one.model_copy(update={"subject": one.agent == AGENTS[0]}) for one in found.design.players)
    beside = found.changed(design=found.design.model_copy(update={"players": players}))
    assert answer_of(beside) == f"False reports raise the success of {AGENTS[0]}, because of what they say."


def test_what_the_arms_say_first_and_last_is_no_factor_of_the_report(found):
    assert not found.where("success_difference", axis="first")
    assert not any("correction" in row.family for row in found.where("success_difference"))
