"""A study of conditions end to end: each against the control, crossed ones, doses, and nothing pooled with the truth."""

import json
import re
from dataclasses import dataclass, replace

import pytest
from builders import play_study, write_study
from captions import too_long
from clumsy import CLUMSY

from lockprobe.export import tidy_rows
from lockprobe.fit.fitting import fit_agents
from lockprobe.formatting import share
from lockprobe.report import write_report
from lockprobe.studies.journal import load
from lockprobe.studies.studyfile import study

ASKED = {
    "agent": ["cognitive:perseverant", "random"], "p": [0, 0.3, 0.6], "sweep": "tremble?p=0.1,0.2,0.4",
    "condition": ["nudge", "nudge + flip?p=0.6"], "trials": 8, "repetitions": 2, "name": "lab",
}  # fmt: skip


@pytest.fixture(scope="module")
def reported(tmp_path_factory, drawn):
    """The directory of a study of eight conditions with its report, and the content of results.json."""
    directory = write_study(tmp_path_factory.mktemp("lab") / "study", study("flips", **ASKED))
    with drawn("effects", "series-1-success", "series-1-loops"):
        page = write_report(directory).read_text()
    return directory, page, json.loads((directory / "results.json").read_text())


def test_every_agent_has_a_row_under_every_condition(reported):
    _, _, content = reported
    labels = [row["condition"] for row in content["conditions"] if row["agent"] == "random"]
    assert labels == [
        "truth", "flip?p=0.3", "flip?p=0.6", "nudge", "nudge + flip?p=0.6",
        "tremble?p=0.1", "tremble?p=0.2", "tremble?p=0.4",
    ]  # fmt: skip
    assert {row["trials"] for row in content["conditions"]} == {16}
    assert [row["p"] for row in content["conditions"]][:5] == [0, 0.3, 0.6, None, None]


def test_counts_are_those_of_the_records(reported):
    directory, _, content = reported
    trials = load(directory)
    for row in content["conditions"]:
        own = [trial for trial in trials if (trial.agent, trial.condition) == (row["agent"], row["condition"])]
        assert (len(own), sum(trial.solved for trial in own)) == (row["trials"], row["solved"])


def test_differences_are_to_the_control_and_paired(reported):
    _, _, content = reported
    solved = {(row["agent"], row["condition"]): row["solved"] for row in content["conditions"]}
    assert len(content["effects"]) == 2 + 2 * 5  # a random agent hears no report, so no flip rate is tested
    for row in content["effects"]:
        family = 2 if row["condition"].startswith("flip") else 5
        assert (row["control"], row["trials"], row["corrected_for"]) == ("truth", 16, family)
        away = solved[row["agent"], row["condition"]] - solved[row["agent"], "truth"]
        assert row["difference"] == pytest.approx(away / 16)
    assert all(
        row["difference"] == 0
        for row in content["effects"]
        if row["agent"] == "random" and "trem" not in row["condition"]
    )


def test_what_was_crossed_has_its_interaction(reported):
    _, page, content = reported
    (one, two) = content["crossings"]
    assert (one["first"], one["second"], one["both"]) == ("nudge", "flip?p=0.6", "nudge + flip?p=0.6")
    assert one["difference"] == two["difference"] == 0  # neither agent reads words
    assert "Interactions of interventions" in page


def test_doses_make_series_that_are_called_by_their_name(reported):
    directory, page, content = reported
    (tremble,) = content["series"]
    assert tremble["name"] == "tremble p"
    assert tremble["conditions"] == {"truth": 0, "tremble?p=0.1": 0.1, "tremble?p=0.2": 0.2, "tremble?p=0.4": 0.4}
    said = " ".join([*tremble["findings"], *tremble["loop_findings"], tremble["courses_said"]])
    assert "tremble" in said
    assert "flip rate" not in said
    assert "false report" not in said.lower()
    asks = {test["asks"] for test in tremble["tests"]}
    assert not any("flip" in one or "alse report" in one for one in asks)
    for name in ("effects", "series-1-success", "series-1-loops"):
        assert (directory / "figures" / f"{name}.svg").read_bytes().startswith(b"<?xml")
    assert (
        page.count("<figure") == 17
    )  # ten of the flip rates, two of each dose and of conditions, and the first screen


def test_exports_name_the_condition_and_leave_p_empty_where_other_things_acted(reported):
    directory, _, _ = reported
    rows = list(tidy_rows(load(directory)))
    assert {row["p"] for row in rows if row["condition"] == "nudge"} == {""}
    assert {row["p"] for row in rows if row["condition"] == "flip?p=0.3"} == {0.3}
    assert {row["chosen"] != "" for row in rows if row["condition"] == "tremble?p=0.4"} == {True, False}


def test_nothing_is_fitted_that_has_no_flip_rate(reported):
    directory, _, _ = reported
    (found,) = fit_agents(load(directory), agents=["cognitive:perseverant"], models=["random"], folds=2).agents
    assert found.p == (0, 0.3, 0.6)
    assert found.trials == 48


def test_equal_records_make_equal_pages(reported, drawn):
    directory, page, _ = reported
    with drawn("effects", "series-1-success", "series-1-loops"):
        assert write_report(directory).read_text() == page


def test_a_part_of_a_study_says_so(tmp_path):
    planned = study("flips", **{**ASKED, "agent": ["random"]})
    directory = write_study(tmp_path / "study", planned, load_part(tmp_path / "whole", planned))
    page = write_report(directory).read_text()
    assert "Partial: 20 of 128 trials" in page


def load_part(directory, planned):
    """The first trials of a study."""
    return load(write_study(directory, planned))[:20]


def test_captions_are_short(reported):
    _, page, content = reported
    assert too_long(page, content) == []


def test_the_first_screen_has_success_with_its_interval_and_says_who_does_not_exceed_chance(reported):
    _, page, content = reported
    overview, found = content["overview"], {row["key"]: row for row in content["conditions"]}
    own = next(row for row in found.values() if (row["agent"], row["condition"]) == ("cognitive:perseverant", "truth"))
    first = overview["numbers"][0]
    assert first["agent"] == "cognitive:perseverant"
    assert first["success"] == share(own["solved"] / 16, own["success_low"], own["success_high"])
    assert own["success_low"] < content["box"]["no_repeat"][-1]
    assert overview["chance"].startswith("When told the truth, ")
    assert overview["chance"].endswith(" random agents without immediate repeats (69 %).")
    assert overview["chance"] in re.sub("<[^>]*>", "", page)


@pytest.mark.parametrize("kept", [[], ["random"], ["random", "round-robin"]])
def test_while_no_two_conditions_share_a_trial_the_report_says_so(tmp_path, kept):
    """Only the control of these agents has been played."""
    planned = study("flips", agent=["random", "round-robin"], condition=["nudge"], p=[0], trials=1, repetitions=1)
    trials = [one for one in play_study(planned) if one.agent in kept and one.condition == "truth"]
    write_report(write_study(tmp_path / "study", planned, trials))
    overview = json.loads((tmp_path / "study" / "results.json").read_text())["overview"]
    assert overview["answer"] == "No two conditions have a trial in common yet."
    assert (overview["chance"], overview["needed"], overview["numbers"], overview["figure"]) == ("", "", [], "")


@dataclass(frozen=True, kw_only=True)
class OutcomeAlone:
    """Says the opposite outcome, and leaves positions as they are: no report of states shows that."""

    def perceive(self, percept, past, task, rng):
        return percept if percept.joint is None else replace(percept, outcome="moved")


def test_a_condition_that_changed_nothing_is_named_and_has_no_effect(tmp_path):
    acts = f"python:{__name__}:OutcomeAlone"
    planned = study("flips", agent=["human-inspired", "round-robin"], condition=acts, p=[0], trials=6, repetitions=1)
    directory = write_study(tmp_path / "study", planned)
    page, content = write_report(directory).read_text(), json.loads((directory / "results.json").read_text())
    (row, _) = [one for one in content["conditions"] if one["condition"] == acts]
    assert (row["changed_steps"], row["changed"], row["never_acted"]) == (0, {acts: 0}, True)
    steps = sum(one["steps"] for one in content["conditions"] if one["condition"] == acts)
    said = f"{acts} changed nothing for any agent (0 of {steps} steps), so nothing is concluded from it."
    assert content["overview"]["answer"] == content["condition_findings"][0] == said
    assert content["effects"] == []
    assert "No effect" not in page
    assert "No difference from" not in page


def test_beside_a_condition_that_changed_nothing_only_the_other_ones_are_concluded_from(tmp_path):
    """A baseline's is named too, though nothing is said of its effects."""
    agents = ["cognitive:careful", "cognitive:insistent", "random"]
    acts = ["history?last=50", "distract?p=0.3"]
    planned = study("flips", agent=agents, condition=acts, p=[0], trials=6, repetitions=1)
    directory = write_study(tmp_path / "study", planned)
    page, content = write_report(directory).read_text(), json.loads((directory / "results.json").read_text())
    idle = [one for one in content["conditions"] if one["never_acted"]]
    assert {(one["agent"], one["condition"]) for one in idle} == {(agent, acts[0]) for agent in agents}
    assert {one["condition"] for one in content["effects"]} == {acts[1]}
    assert content["overview"]["answer"].endswith("o effect of any other condition on success was detected.")
    assert "any condition" not in page
    steps = sum(one["steps"] for one in idle)
    said = f"{acts[0]} changed nothing for any agent (0 of {steps} steps), so nothing is concluded from it."
    assert content["condition_findings"][0] == said
    first = sum(one["steps"] for one in idle if one["agent"] != "random")
    assert f"{acts[0]} changed nothing for any agent (0 of {first} steps)" in content["overview"]["changed_nothing"]


def test_a_condition_that_changed_nothing_for_a_baseline_alone_is_named(tmp_path):
    """No loop of the baseline can be named, since it has none."""
    acts = "nudge"
    planned = study(
        "flips", agent=["cognitive:insistent", "human-inspired"], condition=acts, p=[0], trials=6, repetitions=1
    )
    directory = write_study(tmp_path / "study", planned)
    write_report(directory)
    content = json.loads((directory / "results.json").read_text())
    rows = {one["agent"]: one for one in content["conditions"] if one["condition"] == acts}
    assert (rows["human-inspired"]["never_acted"], rows["cognitive:insistent"]["never_acted"]) == (True, False)
    (said,) = [one for one in content["condition_findings"] if "changed nothing" in one]
    assert said.startswith(f"{acts} changed nothing for human-inspired (0 of ")


@pytest.mark.parametrize("acts", [None, "tremble?p=0.5"])
def test_attempts_against_the_rules_stand_in_the_first_sentence(tmp_path, acts):
    more = {"condition": acts} if acts else {}
    planned = study("flips", agent="round-robin", p=[0], trials=4, repetitions=1, plant=CLUMSY, max_steps=4, **more)
    directory = write_study(tmp_path / "study", planned)
    page, content = write_report(directory).read_text(), json.loads((directory / "results.json").read_text())
    against = sum(row["against_rules"] for row in content["conditions"])
    attempts = sum(row["rules"]["attempts"] for row in content["conditions"])
    assert 0 < against < attempts
    assert f" {against} of {attempts} attempts broke the rules of the box" in content["overview"]["answer"]
    assert content["overview"]["chance"] == ""
    assert content["rules_said"].startswith(f"{against} of {attempts} attempts (")
    assert content["rules_said"] in page
    assert "against the rules" in (directory / "tables" / "conditions.csv").read_text()
