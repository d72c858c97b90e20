"""Reports from an arm or a camera of the plants here: without error they are the truth, and records hold all three."""

import pytest
from lockprobe_robot import simulated_plant
from saboteur import Evidence

from lockprobe import run_study, run_trial, study
from lockprobe.report.verify import verify
from lockprobe.studies.records.read_records import load

SMALL = "width=96&height=72"
EDITED = {"opening_sensed": {"camera": "0001"}}


def told(trial):
    return trial.opening, [(step.told, step.told_moved, step.told_state) for step in trial.steps]


@pytest.mark.parametrize(
    ("plant", "sources", "steps"),
    [("rig?rung=scripted", ("truth", "verdict"), 20), (f"fast-twin?{SMALL}", ("camera",), 6)],
)
def test_without_error_all_sources_tell_the_truth(plant, sources, steps):
    """Flips act on what each of them says."""
    one = {"agent": "human-inspired", "p": 0.4, "seed": 5, "max_steps": steps}
    ruled = told(run_trial(plant="symbolic", modality="symbolic", **one))
    for source in sources:
        trial = run_trial(plant=plant, modality=f"symbolic?source={source}", **one)
        assert told(trial) == ruled
        arm, camera = "fast" not in plant, "twin" in plant
        assert all(("verdict" in s.sensed, "camera" in s.sensed) == (arm, camera) for s in trial.steps)


def test_a_study_of_readings_is_verified_without_a_picture(tmp_path, monkeypatch):
    """The readings are taken from the record; a report that does not follow from them is found."""
    planned = study(
        "modalities", agent="human-inspired", plant=f"fast-twin?{SMALL}", modality="symbolic?source=camera", trials=1,
        max_steps=4,
    )  # fmt: skip
    run_study(planned, tmp_path / "study")
    (trial,) = load(tmp_path / "study")
    assert trial.plant["renderer"]

    def unseen(*args, **options):
        raise AssertionError("a picture was taken")

    monkeypatch.setattr(simulated_plant, "Renderer", unseen)
    found = {check.name: check for check in verify(tmp_path / "study")}
    assert found["luck"].holds
    files = Evidence(tmp_path / "study")
    files.records[0].update(EDITED)
    files.save()
    (luck,) = (check for check in verify(tmp_path / "study") if check.name == "luck")
    assert luck.failed[0].endswith(": opening")
