"""One report for every design: a condition beside flips adds to it, takes nothing away, and changes no P value."""

import pytest
from builders import write_study

from lockprobe.report.page import tables_of
from lockprobe.report.results import results
from lockprobe.report.rows import Results
from lockprobe.report.write import write_report
from lockprobe.studies.options.studyfile import study

SMALL = {"agent": ["cognitive:perseverant", "human-inspired"], "trials": 8, "repetitions": 2, "seed": 5}
FLIPS = {"p": [0, 0.4, 0.8]}
BESIDE = [
    {"condition": ["nudge"]},
    {"sweep": "tremble?p=0.2,0.5"},
    {"condition": ["flip?p=0.4&others=kept", "drop?p=0.5 + flip?p=0.4"]},
]
FAMILIES = {
    "success by tremble p": {"sweep": "tremble?p=0.2,0.5"},
    "conditions against the control": {"condition": ["drop?p=0.5", "distract?p=0.3", "tremble?p=0.2 + drop?p=0.5"]},
}


def played(directory, **asked):
    return write_study(directory, study("flips", **SMALL, **asked))


def reported(directory):
    """The results of a study as its report has written them."""
    write_report(directory)
    return Results.model_validate_json((directory / "results.json").read_bytes())


@pytest.fixture(scope="module")
def alone(tmp_path_factory):
    return played(tmp_path_factory.mktemp("alone") / "study", **FLIPS)


@pytest.fixture(scope="module")
def found_alone(alone):
    return results(alone)


@pytest.fixture(scope="module")
def families(tmp_path_factory):
    """The results of a study without flips for each family."""
    under = tmp_path_factory.mktemp("families")
    return {
        name: results(played(under / str(number), p=[0], **asked))
        for number, (name, asked) in enumerate(FAMILIES.items())
    }


@pytest.fixture(scope="module", params=[[0, 0.4], [0, 0.1, 0.2, 0.9]], ids=str)
def whole(request, tmp_path_factory):
    """The results of a study of flip rates, of another dose and of conditions."""
    more = {name: value for family in FAMILIES.values() for name, value in family.items()}
    return results(played(tmp_path_factory.mktemp("whole") / "study", p=request.param, **more))


def of_family(found, family):
    """Every condition of a family against the control."""
    return found.where("success_difference", family=family, of="")


@pytest.mark.parametrize("more", BESIDE, ids=["a condition", "a dose", "other flips"])
def test_other_conditions_change_nothing_that_is_found_of_flips(found_alone, more, tmp_path):
    """Every number, curve, property, trial and sentence stays but the first sentences, which say what is beside."""
    before, now = found_alone, results(played(tmp_path / "study", **FLIPS, **more))
    known = {(type(row), row.identity): row for row in (*now.rows, *now.curves)}
    assert [row for row in (*before.rows, *before.curves) if known.get((type(row), row.identity)) != row] == []
    assert len(now.rows) > len(before.rows)
    assert [one for one in before.facts if one not in now.facts] == []
    changed = [(one.section, one.kind) for one in before.findings if one not in now.findings]
    first = {("overview", kind) for kind in ("question", "trial", "answer", "needed", "untested", "cause")}
    assert {*changed} <= first | {("readings", "untested")}
    assert now.answer.startswith(before.answer)


@pytest.mark.parametrize(("family", "many"), [*zip(FAMILIES, (2, 3), strict=True)])
def test_no_family_changes_a_p_value_of_another(whole, families, family, many):
    own = of_family(families[family], family)
    assert of_family(whole, family) == own
    assert [row.corrected_for for row in own] == [many] * 2 * many  # of two agents, which are judged apart


def test_a_modality_more_changes_no_p_value_of_another(tmp_path):
    """Each modality has its own control, so its own families; the first screen corrects for all of them."""
    of = {**FLIPS, **FAMILIES["success by tremble p"], **FAMILIES["conditions against the control"]}
    shown = ["symbolic?tell=state", "symbolic?tell=outcome"]
    one, both = (results(played(tmp_path / str(len(of_)), **of, modality=of_)) for of_ in (shown[:1], shown))
    for family in ("success by flip rate", *FAMILIES):
        own = of_family(one, family)
        assert own
        assert [row for row in own if row not in of_family(both, family)] == []
    assert "positions in words" in both.answer
    assert "outcomes in words" in both.answer


def test_every_dose_stands_in_the_table_of_effects_with_the_p_value_of_its_axis(whole):
    """A contrast is one row: that of the axis is the one of the table."""
    compared, (flips, tremble) = whole.against_control(), whole.design.axes
    courses = [course for axis in (flips, tremble) for course in whole.courses(axis)]
    of_axes = [row for course in courses for _, row in course.changes()]
    assert len(of_axes) == 2 * (len(flips.doses) - 1 + 2) == len(compared) - 2 * 3
    assert [row for row in of_axes if row not in compared] == []
    assert [tuple(row[:2]) for row in tables_of(whole)["effects"][1:]] == [(r.agent, r.condition) for r in compared]


def test_conditions_without_flips_have_speed_loops_and_agents_compared(tmp_path):
    directory = played(tmp_path / "study", p=[0], condition=["nudge"], sweep="tremble?p=0.2,0.5")
    found = reported(directory)
    assert [row for row in found.where("success_difference") if row.versus]
    labels = {"truth", "nudge", "tremble?p=0.2", "tremble?p=0.5"}
    for quantity, of in (("mean_steps_all", ""), ("loop_rate", "")):
        assert {cell.condition for cell in found.cells if cell.get(quantity, of)} == labels, quantity
    chosen = {row.condition for row in found.where("optimal_actions")}
    assert {"truth", "nudge"} <= chosen  # a trembling hand is not the choice
    for name in ("speed", "loops"):
        assert "tremble?p=0.5" in (directory / "tables" / f"{name}.csv").read_text()


def test_flips_of_another_kind_have_a_name_of_their_own_and_are_told_apart_in_every_table(tmp_path):
    directory = played(tmp_path / "study", p=[0, 0.4], flip="integrated", condition=["flip?p=0.4", "flip?p=0.1"])
    found = reported(directory)
    assert found.design.flip_kind == "integrated outcome noise"
    contrasts = found.where("success_difference", axis="flip rate", of="", versus="")
    assert [row.doses for row in contrasts] == [{"flip.p": 0.4, "flip.keep": 1}] * 2
    others = found.where("success_difference", axis="flip rate (others=fresh)", of="")
    assert {row.condition for row in others} == {"flip?p=0.4", "flip?p=0.1"}
    assert not of_family(found, "conditions against the control")
    (question,) = found.said("overview", "question")
    assert question == "Do false reports change how agents open chain-4?"
    for name in ("speed", "loops"):
        rows = [line.split(",")[:2] for line in (directory / "tables" / f"{name}.csv").read_text().splitlines()]
        assert len({tuple(row) for row in rows}) == len(rows), name


def test_a_dose_that_never_acted_is_no_other_condition_and_no_question_is_asked_twice(tmp_path):
    doses = ["tremble?p=0.0001", "tremble?p=0.2", "tremble?p=0.4"]
    found = results(played(tmp_path / "idle", p=[0], condition=doses))
    asked = "Do higher doses of tremble change how agents open chain-4?"
    assert found.said("overview", "question") == [asked]
    assert {row.condition for row in of_family(found, "success by tremble p")} == {*doses[1:]}
    shown = {"modality": ["symbolic?tell=state", "symbolic?tell=outcome"]}
    found = results(played(tmp_path / "shown", p=[0], **FAMILIES["success by tremble p"], **shown))
    (question,) = found.said("overview", "question")
    assert question.count("tremble") == 1
