"""Agents compared under other conditions: rows counted by hand, the sentence, both tables and the figure."""

from itertools import product

import pytest
from builders import write_study

from lockprobe.report.figures.differences import by_condition
from lockprobe.report.page import tables_of
from lockprobe.report.questions.agents_by_condition import SECTIONS
from lockprobe.report.results import results
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.records.read_records import load

AGENTS = ("cognitive:perseverant", "cognitive:careful", "human-inspired")
CONDITIONS = ("drop?p=0.5", "tremble?p=0.2", "nudge")


@pytest.fixture(scope="module")
def directory(tmp_path_factory):
    asked = {"agent": [*AGENTS], "p": [0, 0.4], "condition": [*CONDITIONS], "trials": 20, "repetitions": 2, "seed": 1}
    return write_study(tmp_path_factory.mktemp("by-condition") / "study", study("flips", **asked))


@pytest.fixture(scope="module")
def found(directory):
    return results(directory)


def test_rows_are_counted_in_the_records(found, directory):
    solved = {
        (trial.agent, trial.condition, trial.repetition, trial.trial): trial.ending == "solved"
        for trial in load(directory)
    }
    share = {
        (agent, label): sum(
            solved[agent, label, repetition, i] for repetition, i in product((1, 2), range(1, 21))
        ) / 40
        for agent, label in product(AGENTS, ("truth", *CONDITIONS[:2]))
    }  # fmt: skip
    pair = {"agent": AGENTS[0], "versus": AGENTS[1]}
    for label in CONDITIONS[:2]:
        gap = share[AGENTS[0], label] - share[AGENTS[1], label]
        row = found.one("success_difference", **pair, condition=label)
        assert (row.value, row.n, row.corrected_for, row.test) == (pytest.approx(gap), 40, 2, "McNemar")
        assert row.family == "agents, conditions"
        change = found.one("success_change_difference", **pair, condition=label)
        before = share[AGENTS[0], "truth"] - share[AGENTS[1], "truth"]
        assert (change.value, change.control, change.corrected_for) == (pytest.approx(gap - before), "truth", 2)
        baseline = found.one("success_difference", agent=AGENTS[0], versus="human-inspired", condition=label)
        assert (baseline.family, baseline.corrected_for) == ("agents and baselines, conditions", 4)
    assert not found.where("success_difference", **pair, condition="nudge")  # strategies read no remarks


def test_the_sentences_name_what_was_detected(found):
    for quantity, what in (
        ("success_difference", "differences between agents"),
        ("success_change_difference", "differences in the effect of a condition"),
    ):
        rows = [row for row in found.where(quantity, of="") if row.condition in CONDITIONS and row.versus]
        clear = [row for row in rows if row.detected]
        assert 0 < len(clear) < len(rows)
        assert f"{len(clear)} of {len(rows)} {what}" in found.answer_of("agents_by_condition")
        (said,) = found.said("agents_by_condition", quantity)
        assert said.count("points)") == min(3, len(clear))
        own = [row for row in clear if row.family == "agents, conditions"]
        assert all(row.condition in said and row.versus in said for row in own)


def test_a_study_of_flip_rates_has_no_such_section(found):
    alone = found.with_rows([row for row in found.rows if row.condition not in CONDITIONS])
    (section,) = SECTIONS
    assert not any(tables_of(alone, section.tables).values())
    assert not list(section.show(alone))
    assert by_condition(alone) is None
