"""Tables as files: a dictionary beside each, and no configuration that is read as a number."""

import csv
import io
import json
import subprocess
import sys

import pytest
from builders import play_study, small_study

from lockprobe.foundation.errors import BadFile
from lockprobe.interfaces.export.data_dictionary import COLUMN, as_bits
from lockprobe.interfaces.export.table_files import Rows, rows_of, write_rows, write_table

TRIALS = play_study(small_study(trials=1))


@pytest.mark.parametrize("name", ["steps", "trials"])
@pytest.mark.parametrize("kind", ["csv", "jsonl", "parquet"])
def test_a_dictionary_beside_the_file_describes_every_column(tmp_path, name, kind):
    if kind == "parquet":
        pytest.importorskip("pyarrow")
    path = tmp_path / f"x.{kind}"
    assert write_table(rows_of(name, TRIALS), path, kind) == [path, tmp_path / f"x.{kind}-metadata.json"]
    said = json.loads((tmp_path / f"x.{kind}-metadata.json").read_text("utf-8"))
    assert said["url"] == path.name
    described = {column["name"]: column for column in said["tableSchema"]["columns"]}
    assert list(described) == list(rows_of(name, TRIALS).columns)
    assert all(column["dc:description"] == COLUMN[one].meaning for one, column in described.items())
    assert described["key"]["datatype"] == {"base": "string"}
    assert described["p"]["datatype"] == {"base": "number", "minimum": 0, "maximum": 1}
    if name == "steps":
        assert described["misread"]["datatype"] == {"base": "integer", "minimum": 0, "maximum": 1}
        assert described["step"]["datatype"] == {"base": "integer", "minimum": 1}


def test_neither_is_written_where_one_cannot_be(tmp_path):
    (tmp_path / "x.csv-metadata.json").mkdir()
    with pytest.raises(BadFile, match="is a directory"):
        write_table(rows_of("trials", TRIALS), tmp_path / "x.csv", "csv")
    assert [path.name for path in tmp_path.iterdir()] == ["x.csv-metadata.json"]


def test_no_configuration_in_csv_is_a_number():
    file = io.StringIO()
    write_rows(rows_of("steps", TRIALS), file, "csv")
    states = [row["state"] for row in csv.DictReader(io.StringIO(file.getvalue()))]
    assert states == [as_bits(row["state"]) for row in rows_of("steps", TRIALS).rows]
    for state in states:
        for base in (0, 2, 10):  # with 16 b is a digit; no reader of CSV takes that
            with pytest.raises(ValueError, match="invalid literal"):
                int(state, base)
        with pytest.raises(ValueError, match="could not convert"):
            float(state)


@pytest.mark.parametrize("end", ["\u2028", "\u2029", "\x85"])
def test_a_row_of_json_is_one_line_for_every_reader_and_its_text_comes_back(end):
    file, row = io.StringIO(), {"key": rf"ключ{end}\{end}\u2028"}
    write_rows(Rows("A row.", ("key",), [row]), file, "jsonl")
    (line,) = file.getvalue().splitlines()
    assert json.loads(line) == row
    assert "ключ" in line


def test_the_next_export_deletes_the_drafts_of_a_killed_one_and_leaves_those_of_one_that_goes_on(tmp_path):
    code = (
        "import sys; from pathlib import Path\n"
        "from lockprobe.interfaces.export.table_files import Rows, write_table\n"
        "def rows():\n"
        "    print(flush=True)\n"
        "    sys.stdin.read()\n"
        "    yield {'key': 'late'}\n"
        "write_table(Rows('A row.', ('key',), rows()), Path(sys.argv[1]), 'csv')"
    )
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE}
    start = [sys.executable, "-c", code]
    with (
        subprocess.Popen([*start, tmp_path / "x.csv"], **pipes) as killed,
        subprocess.Popen([*start, tmp_path / "y.csv"], **pipes) as other,
    ):
        for one in (killed, other):
            one.stdout.readline()
        killed.kill()
        killed.wait()
        (tmp_path / ".mine.draft.csv").touch()
        assert len(list(tmp_path.glob(".*.draft*"))) == 5
        write_table(rows_of("trials", TRIALS), tmp_path / "x.csv", "csv")
        left = len(list(tmp_path.glob(".*.draft*")))
        other.communicate()
        assert (left, other.returncode) == (3, 0)
    assert (tmp_path / "y.csv").read_text() == "key\nlate\n"
    assert [path.name for path in tmp_path.glob(".*")] == [".mine.draft.csv"]


def test_parquet_has_the_description_of_every_column(tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet")
    write_table(rows_of("trials", TRIALS), tmp_path / "x.parquet", "parquet")
    schema = parquet.read_schema(tmp_path / "x.parquet")
    assert all(field.metadata[b"description"].decode() == COLUMN[field.name].meaning for field in schema)
    assert (str(schema.field("solved").type), str(schema.field("loop_coverage").type)) == ("int64", "double")
