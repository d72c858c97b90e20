"""No command writes in the place of what belongs to a study: this one, another one, or the one around it."""

import pytest

from lockprobe.cli.out_file import refuse_study_file
from lockprobe.foundation.errors import BadFile

STORES = ("study.db", "study.db-wal", "study.db-shm", "study.db-journal", "study.db.rescued", "study.db.rescued-2")
KEPT = (*STORES, "results.json", "people/experiment.json", "pictures/new.png")


def test_what_a_study_keeps_is_refused_and_other_files_beside_it_are_not(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "link.csv").symlink_to(tmp_path / "study.db")
    kept = ("study.json", *KEPT, "report.html", "link.csv")
    for name in kept:
        refuse_study_file(tmp_path / "elsewhere" / name)  # there is no study
        refuse_study_file(tmp_path / name)
    (tmp_path / "study.json").write_text("{}")
    for name in kept:
        for path in (tmp_path / name, tmp_path / "no" / ".." / name, tmp_path.relative_to(tmp_path) / name):
            with pytest.raises(BadFile, match="belongs to the study; choose another file"):
                refuse_study_file(path)
    for name in ("steps.csv", "compare.html", "tables/steps.csv", "inner/study.db"):
        refuse_study_file(tmp_path / name)
