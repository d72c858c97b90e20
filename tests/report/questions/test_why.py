"""Why: the verdict first, numbers that are those of the records, and a trial told in every arm."""

from html import unescape

import pytest
from builders import write_study
from page_parts import part

from lockprobe.report.page import page_of, parts_of, tables_of
from lockprobe.report.results import results
from lockprobe.statistics.why.arms import ARMS
from lockprobe.statistics.why.mechanism import CONTRASTS
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.records.read_records import load

AGENTS = ["cognitive:perseverant", "cognitive:softmax-memory"]


def found_in(directory, name="why", **asked):
    return results(write_study(directory, study(name, **asked)))


@pytest.fixture(scope="module")
def told(tmp_path_factory):
    """The directory of a small study of controls, and its results."""
    directory = tmp_path_factory.mktemp("why") / "study"
    return directory, found_in(directory, agent=AGENTS, trials=50)


def test_every_agent_has_its_arms_as_recorded(told):
    directory, found = told
    trials, rows = load(directory), found.where("success_in_arm")
    for row in rows:
        own = [trial.solved for trial in trials if (trial.agent, trial.condition) == (row.agent, row.condition)]
        assert (row.n, row.count) == (len(own), sum(own))
    assert [row.of for row in rows if row.agent == AGENTS[0]] == list(ARMS)
    share = {row.of: row.value for row in rows if row.agent == AGENTS[0]}
    for row in found.where("arm_contrast", agent=AGENTS[0]):
        pairs = [share[more] - share[less] for more, less in CONTRASTS[row.of]]
        assert row.value == pytest.approx(sum(pairs) / len(pairs))


def test_where_no_effect_is_detected_no_part_is_computed_or_shown(told):
    _, found = told
    assert {row.of for row in found.where("arm_contrast", agent=AGENTS[0])} == set(CONTRASTS)
    assert found.where("arm_contrast", agent=AGENTS[1]) == []
    assert [row for row in found.where("success_difference", agent=AGENTS[1]) if row.family == "arms"] == []
    cells = [row for row in tables_of(found)["arms"] if row[0] == AGENTS[1]]
    assert len(cells) == len(ARMS)
    assert {tuple(row[5:]) for row in cells} == {("\N{EN DASH}", "\N{EN DASH}")}
    said = " ".join(found.said("why", agent=AGENTS[1]))
    assert "two statements" not in said
    assert found.said("why", "assumption", agent=AGENTS[1]) == []


def test_what_the_arms_say_first_and_last_is_no_factor_of_the_report(told):
    _, found = told
    assert tables_of(found)["factors"] == []
    assert not any("correction" in row.family for row in found.where("success_difference"))


def test_the_part_begins_with_the_verdicts_and_what_they_assume(told):
    _, found = told
    page, said = unescape(part(page_of(found), "why")), found.said("why", "verdict")
    assert len(said) == len(AGENTS)
    (assumed,) = found.said("why", "assumption")
    assert max(map(page.index, said)) < page.index(assumed)
    assert found.said("why", "conclusion", agent=AGENTS[0]) == ["says, last"]
    margin = found.one("equivalence_margin", agent=AGENTS[1])
    (conclusion,) = found.said("why", "conclusion", agent=AGENTS[1])
    assert conclusion == ("no change" if margin.p_value < 0.05 else "inconclusive")


def test_other_studies_have_no_such_part(tmp_path):
    asked = {"agent": "random", "sweep": "tremble?p=0,0.2", "trials": 2, "repetitions": 1}
    found = found_in(tmp_path / "study", "flips", **asked)
    assert not {part.name for part in parts_of(found)} & {"why", "arms"}
    assert tables_of(found)["why"] == tables_of(found)["arms"] == []
