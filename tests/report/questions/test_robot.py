"""What arm and camera took attempts for, and attempts against the rules of the box: counted, and said in the answer."""

import pytest
from builders import make_trial, modality_study, write_study
from clumsy import CLUMSY, HAND
from reported import found_in, tables_of

from lockprobe.boxes.families import box
from lockprobe.report.page import Page
from lockprobe.report.questions.claims import not_judged
from lockprobe.report.results import results
from lockprobe.statistics.clustered import clustered_proportion
from lockprobe.statistics.rules import Rules
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.records.read_records import load

TOLD = ("symbolic?source=truth", "symbolic?source=verdict", "symbolic?source=camera")


def played(modality, trial):
    """The arm takes a blocked joint for moved once and fails once; the camera once cannot read a joint."""
    said, readings = ["moved", "moved", "failed"], ["0000", "0001", "0001", "000?"]
    return make_trial(
        [3, 0, 3], budget=3, agent="human-inspired", study="modalities", trial=trial, modality=modality,
        verdicts=said, readings=readings,
    )  # fmt: skip


def test_every_joint_has_a_row_and_failures_are_counted_apart(tmp_path):
    planned = modality_study(["human-inspired"], TOLD, trials=8, plant="twin", max_steps=3)
    found = found_in(tmp_path, planned, [played(one, trial) for one in TOLD for trial in range(1, 9)])
    head, *rows = tables_of(found)["robot"]
    assert head == ["joint", "right verdicts", "of", "undecided", "right readings", "of", "undecided"]
    assert [[cell.partition(" [")[0] for cell in row] for row in rows] == [
        ["revolute-left", "0 %", "24", "0", "100 %", "24", "0"],
        ["revolute-right", "100 %", "24", "24", "100 %", "24", "24"],
        ["all", "50 %", "48", "24", "100 %", "48", "24"],
    ]
    target = found.one("verdicts", of="right, revolute-left")
    assert (target.clusters, target.high < 0.5) == (8, True)
    assert found.one("verdicts", of="wrong").count == 24
    assert ((wrong := found.one("readings", of="wrong")).low, wrong.high > 0) == (0, True)
    said = "Wrong: the verdict of the arm at 24 of 48 attempts, the reading of the camera at 0 of 48 attempts."
    assert said in Page(found=found).text()


AGENTS = ["cognitive:careful", "human-inspired"]
MISSES = "plant?forces=9&knocks=2&misses=3;4;5;6;7;8"


@pytest.fixture(scope="module")
def directories(tmp_path_factory):
    """Two conditions with a hand that misses in one of them, with one that always misses, and with one that never does."""
    found = []
    for plant, condition in ((HAND, MISSES), (CLUMSY, "tremble?p=0.3"), ("symbolic", "tremble?p=0.3")):
        asked = {"p": [0], "trials": 6, "repetitions": 2, "condition": condition, "max_steps": 9}
        planned = study("flips", agent=AGENTS, plant=plant, **asked)
        found.append(write_study(tmp_path_factory.mktemp("study") / "study", planned))
    return found


@pytest.fixture(scope="module")
def studies(directories):
    return [results(directory) for directory in directories]


def test_the_answer_counts_them_and_success_is_compared_all_the_same(studies):
    missing, clumsy, kept = studies
    for found in (missing, clumsy):
        rows = found.where("against_rules", of="")
        broken = (
            f" {sum(row.count for row in rows)} of {sum(row.n for row in rows)} attempts broke the rules of the box."
        )
        assert found.answer.endswith(broken)
        assert len(found.answer) > len(broken) + 10
        assert {row[6] for row in tables_of(found)["claims"][1:]} == {"not judged", "not measured"}
        assert found.fact("overview", "chance") == ""
    (effect,) = missing.where("success_difference", agent="human-inspired", of="", condition=MISSES)
    assert effect.value < 0
    assert {row.quantity for row in clumsy.rows} >= {row.quantity for row in kept.rows}
    assert "broke the rules" not in kept.answer
    assert not_judged(kept) == ""
    assert kept.where("against_rules", of="missed") == kept.where("against_rules", of="attempts") == []


def test_misses_are_shares_of_free_and_of_locked_joints_with_trials_as_clusters(studies, directories):
    chain, missing = box("chain-4"), studies[0]
    own = [one for one in load(directories[0]) if (one.group, one.condition) == ("human-inspired", MISSES)]
    judged = [Rules(chain).judged(trial) for trial in own]
    for kind, among, happened in (
        ("missed", lambda one: one.free, lambda one: not one.moved),
        ("forced", lambda one: not one.free, lambda one: one.moved),
        ("moved another", lambda one: True, lambda one: one.other),
    ):
        row = missing.one("against_rules", agent="human-inspired", condition=MISSES, of=kind)
        of = [[happened(one) for one in trial if among(one)] for trial in judged]
        share = clustered_proportion(list(map(sum, of)), list(map(len, of)))
        assert (row.count, row.n, row.low, row.high) == (share.count, share.n, share.low, share.high)
        assert row.count > 0
    for cell in missing.cells:
        assert cell.condition != "truth" or cell.get("against_rules", "missed").count == 0
    assert "attempts at free joints missed" in Page(found=missing).text()
