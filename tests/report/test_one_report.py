"""One report for every design: each condition beside its control in its own family, and none changes another's numbers."""

from operator import attrgetter

import pytest
from builders import write_study

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
