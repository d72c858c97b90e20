"""What arm and camera took attempts for, and attempts against the rules of the box: counted, and said in the answer."""

from builders import make_trial, modality_study
from clumsy import CLUMSY, HAND
from reported import found_in, tables_of

from lockprobe.report.page import Page
from lockprobe.report.questions.claims import not_judged
from lockprobe.studies.options.studyfile import study

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


def test_the_answer_counts_them_and_success_is_compared_all_the_same(tmp_path):
    """Two conditions with a hand that misses in one of them, with one that always misses, and with one that never does."""
    studies = []
    for plant, condition in ((HAND, MISSES), (CLUMSY, "tremble?p=0.3"), ("symbolic", "tremble?p=0.3")):
        asked = {"p": [0], "trials": 6, "repetitions": 2, "condition": condition, "max_steps": 9}
        studies.append(found_in(tmp_path / str(len(studies)), study("flips", agent=AGENTS, plant=plant, **asked)))
    missing, clumsy, kept = studies
    for found in (missing, clumsy):
        rows = found.where("against_rules", of="")
        many, attempts = sum(row.count for row in rows), sum(row.n for row in rows)
        broken = f" {many} of {attempts} attempts broke the rules of the box."
        assert found.answer.endswith(broken)
        assert len(found.answer) > len(broken) + 10
        rows = tables_of(found)["claims"][1:]
        assert {row[6] for row in rows} == {"not judged", "not measured"}
        assert {row[7] for row in rows if row[5]} == {not_judged(found)} == {f"No claim is judged:{broken}"}
    (effect,) = missing.where("success_difference", agent="human-inspired", of="", condition=MISSES)
    assert effect.value < 0
    assert {row.quantity for row in clumsy.rows} >= {row.quantity for row in kept.rows}
    assert "broke the rules" not in kept.answer
    assert not_judged(kept) == ""
    assert kept.where("against_rules", of="missed") == kept.where("against_rules", of="attempts") == []
