"""One report for every design: each condition beside its control in its own family, and none changes another's numbers."""

from dataclasses import dataclass, replace
from operator import attrgetter

import pytest
from builders import write_study
from reported import found_in

from lockprobe.report.page import Page
from lockprobe.report.results import results
from lockprobe.report.rows import IDENTITY
from lockprobe.studies.options.studyfile import study

SMALL = {"agent": ["cognitive:perseverant", "human-inspired"], "trials": 4, "repetitions": 2, "seed": 5}
FAMILIES = {
    "success by flip rate": {"p": [0, 0.4, 0.8]},
    "success by tremble p": {"sweep": "tremble?p=0.2,0.5"},
    "conditions against the control": {"condition": ["drop?p=0.5", "distract?p=0.3", "tremble?p=0.2 + drop?p=0.5"]},
}


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    """The results of a study of each family alone, and of one of all of them."""
    whole = {name: value for family in FAMILIES.values() for name, value in family.items()}
    under = tmp_path_factory.mktemp("families")
    return {
        name: results(write_study(under / str(i), study("flips", **SMALL | {"p": [0]} | asked)))
        for i, (name, asked) in enumerate((FAMILIES | {"": whole}).items())
    }


def test_other_conditions_change_nothing_that_is_found_of_flips(found):
    """Every number, curve, property, trial and sentence stays but the first sentences, which say what is beside."""
    before, now = found["success by flip rate"], found[""]
    known = {(type(row), attrgetter(*IDENTITY)(row)): row for row in (*now.rows, *now.curves)}
    rows = (*before.rows, *before.curves)
    assert [row for row in rows if known.get((type(row), attrgetter(*IDENTITY)(row))) != row] == []
    assert len(now.rows) > len(before.rows)
    changed = {(one.about, one.name) for one in before.facts if one not in now.facts}
    assert changed <= {("overview", kind) for kind in ("question", "trial", "answer")}
    assert now.answer.startswith(before.answer)


@pytest.mark.parametrize(("family", "many"), [*zip(FAMILIES, (2, 2, 3), strict=True)])
def test_no_family_changes_a_p_value_of_another(found, family, many):
    own, of_all = (one.where("success_difference", family=family, of="") for one in (found[family], found[""]))
    assert own == of_all
    assert {row.corrected_for for row in own} == {many}  # of two agents, which are judged apart


# What never acted.


@dataclass(frozen=True, kw_only=True)
class OutcomeAlone:
    """Says the opposite outcome, and leaves positions as they are: no report of states shows that."""

    def perceive(self, percept, past, task, rng):
        return percept if percept.joint is None else replace(percept, outcome="moved")


IDLE = {"p": [0], "trials": 6, "repetitions": 1}


def never_acted(found, condition):
    """The agents for which a condition changed nothing, and what is said of that of some of them."""
    idle = [cell for cell in found.cells if cell.condition == condition and cell.get("success").note == "never acted"]
    assert {cell.value("steps", of) for cell in idle for of in ("changed", f"changed by {condition}")} == {0}

    def said(agents):
        steps = sum(cell.value("steps") for cell in idle if cell.agent in agents)
        return f"{condition} changed nothing for any agent (0 of {steps:g} steps), so nothing is concluded from it."

    return {cell.agent for cell in idle}, said


def test_a_condition_that_changed_nothing_is_the_answer_and_has_no_effect(tmp_path):
    acts, agents = f"python:{__name__}:OutcomeAlone", {"human-inspired", "round-robin"}
    found = found_in(tmp_path, study("flips", agent=[*agents], condition=acts, **IDLE))
    idle, said = never_acted(found, acts)
    assert idle == agents
    assert found.answer == said(agents)
    assert not [row for row in found.rows if row.control]
    assert not [words for words in ("No effect", "No difference from") if words in Page(found=found).text()]
