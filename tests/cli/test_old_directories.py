"""The command line goes on in directories that the release before conditions made."""

import shutil
from dataclasses import replace
from pathlib import Path

from lockprobe.studies.journal import load

OLD = Path(__file__).parents[1] / "golden" / "studies_v1" / "flips"


def test_it_goes_on_as_the_box_was_shown_then(lockprobe, tmp_path):
    """Reports told outcomes too; who does not say how the box is shown does not mean to change that."""
    directory = shutil.copytree(OLD, tmp_path / "flips")
    lines = (OLD / "trials.jsonl").read_bytes().splitlines(keepends=True)
    (directory / "trials.jsonl").write_bytes(b"".join(lines[:7]))
    command = ["run", "flips", "--agent", "random", "--agent", "human-inspired", "--p", "0,0.4", "--trials", "3"]
    command += ["--repetitions", "1", "--flip", "sticky", "--max-steps", "12", "--no-report", "--out", str(directory)]
    assert lockprobe(*command)[0] == 0
    played, before = ({trial.key: trial for trial in load(one)} for one in (directory, OLD))
    assert {key: replace(trial, changed={}, changed_steps=0) for key, trial in played.items()} == before
    status, _, said = lockprobe(*command, "--modality", "symbolic?tell=state")
    assert status == 2
    assert "modalities is ['symbolic'] there, ['symbolic?tell=state'] asked" in said
