"""The table of truth, verdict and camera: each against the others, joint by joint."""

from builders import make_trial, modality_study, write_study

from lockprobe.report.page import page_of, tables_of
from lockprobe.report.results import results

TOLD = ("symbolic?source=truth", "symbolic?source=verdict", "symbolic?source=camera")


def found_in(directory, planned, trials):
    return results(write_study(directory, planned, trials))


def played(modality, trial):
    """The arm takes a blocked joint for moved once and fails once; the camera once cannot read a joint."""
    said, readings = ["moved", "moved", "failed"], ["0000", "0001", "0001", "000?"]
    return make_trial(
        [3, 0, 3], budget=3, agent="human-inspired", study="modalities", trial=trial, modality=modality,
        verdicts=said, readings=readings,
    )  # fmt: skip


def test_every_joint_has_a_row_and_its_numbers_are_rows_of_the_results(tmp_path):
    planned = modality_study(["human-inspired"], TOLD, trials=8, plant="twin", max_steps=3)
    found = found_in(tmp_path / "study", planned, [played(one, trial) for one in TOLD for trial in range(1, 9)])
    head, *rows = tables_of(found)["robot"]
    assert head == [
        "joint", "attempts", "moved", "blocked", "verdict right", "failed", "camera right", "unclear",
        "verdict and camera agree",
    ]  # fmt: skip
    assert [row[:4] + row[5::2] for row in rows] == [
        ["revolute-left", "24", "0", "24", "0", "0"],
        ["revolute-right", "48", "48", "0", "24", "24"],
        ["all", "72", "48", "24", "24", "24"],
    ]
    assert [row[4].partition(" [")[0] for row in rows] == ["0 %", "100 %", "50 %"]
    target = found.one("right_verdicts", of="revolute-left")
    assert (target.count, target.n, target.clusters, target.high < 0.5) == (0, 24, 8, True)
    assert found.one("wrong_verdicts").count == found.one("wrong_verdicts", of="moved for blocked").count == 24
    assert found.one("verdict_camera_agreement").count == 24
    page = page_of(found)
    assert "Wrong outcomes: the verdict at 24 of 48 attempts, the camera at 0 of 48 attempts." in page
