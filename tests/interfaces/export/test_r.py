"""The lines for R in the docs name columns that are there, and run as they are typed where R is."""

import re
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import pytest
from builders import play_study, small_study, write_study
from taking_part import take_part

from lockprobe.interfaces.export.data_dictionary import COLUMN
from lockprobe.interfaces.export.table_files import write_table
from lockprobe.interfaces.export.tables import TABLES, table_of
from lockprobe.studies.records.read_records import load

STUDY = small_study(["random", "participant"], p=[0.0, 0.4], trials=4)
DOCS = Path(__file__).parents[3] / "docs" / "participants.md"
SNIPPETS = re.findall(r"```r\n(.*?)```", DOCS.read_text("utf-8"), re.DOTALL)


@pytest.fixture
def study(tmp_path):
    directory = write_study(tmp_path / "study", STUDY, play_study(replace(STUDY, agents=("random",))))
    for number in (1, 2, 3, 4):
        answers = {"age": "34", "why": 'two\nlines, "quoted", ü'}
        take_part(directory, STUDY, f"000{number}", [(0.0, 1, number), (0.4, 2, number)], answers=answers)
    return directory


def test_the_lines_for_r_name_columns_that_are_there(study):
    columns = {name: set(table_of(study, name).columns) for name in TABLES}
    code = re.sub(r"#.*", "", SNIPPETS[0])
    assert (
        set(re.findall(r'read\("(\w+)\.csv"\)', code)) == {"trials", "steps", "participants", "answers"} < set(TABLES)
    )
    uses = {
        "trials": r"aggregate\((\w+) ~ (\w+), (?:subset\()?people",
        "steps": r"aggregate\((\w+) ~ (\w+), steps",
        "participants": r"subset\(participants, (\w+) == 1 & (\w+) == 0",
        "answers": r'answers\[c\("(\w+)", "(\w+)", "(\w+)"\)\]',
    }
    for table, use in uses.items():
        named = {name for found in re.findall(use, code) for name in found}
        assert named
        assert named <= columns[table], (table, named)
    assert set(re.findall(r"aggregate\((\w+) ~", SNIPPETS[1])) <= set(COLUMN)


@pytest.mark.skipif(shutil.which("Rscript") is None, reason="no R here")
def test_the_lines_for_r_run_as_they_are_typed(study, tmp_path):
    trials = load(study)
    for name in TABLES:
        write_table(table_of(study, name), tmp_path / f"{name}.csv", "csv")
    for code in SNIPPETS:
        (tmp_path / "snippet.R").write_text(code, "utf-8")
        done = subprocess.run(["Rscript", "snippet.R"], cwd=tmp_path, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        assert "Warning message" not in done.stderr
        printed = done.stdout
    people = [trial for trial in trials if trial.agent.startswith("participant:") and trial.p == 0.4]
    share = sum(trial.solved for trial in people) / len(people)
    (row,) = re.findall(r"people 0\.4\s+([0-9.]+)", printed)
    assert float(row) == pytest.approx(share, abs=1e-4)
