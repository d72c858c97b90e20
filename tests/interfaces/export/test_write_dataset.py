"""A dataset follows Psych-DS (rules of its schema 1.5.0, as its validator applies them), and says no more than it may."""

import csv
import json
import re
from dataclasses import replace

import pytest
from builders import (
    make_trial,
    modality_study,
    play_study,
    small_study,
    with_right_checksums,
    write_study,
)
from taking_part import START, take_part

from lockprobe.foundation.errors import BadFile
from lockprobe.interfaces.export.read_dataset import source_of_dataset
from lockprobe.interfaces.export.write_dataset import write_dataset
from lockprobe.people.experiment import SECRET
from lockprobe.people.import_diaries import DiaryImport
from lockprobe.people.journey import fingerprint
from lockprobe.people.texts import read_words, words_file
from lockprobe.people.withdrawal import count_withdrawn, withdrawn
from lockprobe.studies.options.settings import read_study
from lockprobe.studies.records.journal import load
from lockprobe.studies.records.merge import gather

STUDY = small_study(["random", "participant"], p=[0.0, 0.4], trials=2)
ANN, BOB = "aaaa01", "bbbb02"
FILE_NAME = re.compile(r"([a-z]+-[a-zA-Z0-9]+)(_[a-z]+-[a-zA-Z0-9]+)*_data\.csv")
KEYWORDS = {"study", "site", "subject", "session", "task", "condition", "trial", "stimulus", "description"}


@pytest.fixture
def directory(tmp_path):
    made = write_study(tmp_path / "study", STUDY, play_study(replace(STUDY, agents=("random",))))
    answers = {"why": 'two\r\nlines, "quoted", ü'}
    take_part(made, STUDY, ANN, [(0.4, 1, 1), (0.0, 1, 2)], answers=answers, platform={"PROLIFIC_PID": "5f00ab"})
    take_part(made, STUDY, BOB, [(0.0, 1, 1), (0.4, 2, 1)], left_after=1, joined=START + 60)
    return made


@pytest.fixture
def dataset(directory, tmp_path):
    write_dataset(directory, tmp_path / "out")
    return tmp_path / "out"


def read(path):
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.reader(file, strict=True))


def everything(dataset):
    return "".join(path.read_text("utf-8") for path in sorted(dataset.rglob("*")) if path.is_file())


def test_files_and_their_names(dataset):
    assert {path.name for path in dataset.iterdir()} == {
        "dataset_description.json", "README.md", "CHANGES.md", ".psychds-ignore", "data", "records",
    }  # fmt: skip
    names = [path.name for path in (dataset / "data").iterdir()]
    assert len(names) == 6
    assert all(FILE_NAME.fullmatch(name) for name in names)
    assert {part.split("-")[0] for name in names for part in name.split("_")[:-1]} <= KEYWORDS
    assert "records/" in (dataset / ".psychds-ignore").read_text().splitlines()
    assert all(path.stat().st_size for path in dataset.rglob("*") if path.is_file())


def test_the_description_is_a_dataset_of_schema_org(dataset):
    about = json.loads((dataset / "dataset_description.json").read_text("utf-8"))
    assert (about["@context"], about["@type"]) == ("https://schema.org/", "Dataset")
    assert all(about[name] for name in ("name", "description", "variableMeasured", "schemaVersion"))
    of_schema_org = {"@type", "name", "description", "unitText", "minValue", "maxValue"}
    assert all(set(variable) <= of_schema_org for variable in about["variableMeasured"])
    assert {variable["@type"] for variable in about["variableMeasured"]} == {"PropertyValue"}
    assert "2 people, 2 with trials (3 in all)" in about["description"]
    assert "are not included" in about["description"]


def test_every_column_is_measured_and_what_is_measured_is_a_column(dataset):
    about = json.loads((dataset / "dataset_description.json").read_text("utf-8"))
    measured = [variable["name"] for variable in about["variableMeasured"]]
    assert len(set(measured)) == len(measured)
    headers = [read(path)[0] for path in (dataset / "data").iterdir()]
    assert {name for header in headers for name in header} == set(measured)
    assert all(len(set(header)) == len(header) and "row_id" not in header for header in headers)


def test_every_row_is_as_long_as_the_header(dataset):
    for path in (dataset / "data").iterdir():
        header, *rows = read(path)
        assert rows
        assert {len(row) for row in rows} == {len(header)}


def test_what_was_answered_reads_back_as_it_was_said(dataset):
    (path,) = (dataset / "data").glob("*answers*")
    header, row = read(path)
    assert dict(zip(header, row, strict=True))["answer"] == 'two\r\nlines, "quoted", ü'


def test_nothing_says_who_or_when(dataset, directory):
    text = everything(dataset)
    assert "5f00ab" not in text
    assert "f" * 64 not in text
    assert str(int(START))[:6] not in text
    assert str(directory) not in text


def test_the_platform_is_named_where_that_is_asked_for(directory, tmp_path):
    write_dataset(directory, tmp_path / "with", platform_ids=True)
    (path,) = (tmp_path / "with" / "data").glob("*participants*")
    header, ann, bob = read(path)
    assert [dict(zip(header, row, strict=True))["platform_PROLIFIC_PID"] for row in (ann, bob)] == ["5f00ab", ""]


def test_where_people_go_on_afterwards_and_what_lies_where_stays_here(directory, tmp_path):
    settings = {
        **{name: "https://example.org/done?cc=SECRET1" if name.endswith("url") else "SECRET2" for name in SECRET},
        "language": "/home/SECRET4/ours.toml",
    }
    (directory / "people" / "experiment.json").write_text(json.dumps(settings))
    (directory / "people" / "secret").write_bytes(b"SECRET3")
    write_dataset(directory, tmp_path / "out")
    assert "SECRET" not in everything(tmp_path / "out")
    assert (tmp_path / "out" / "records" / "people" / "experiment.json").is_file()


@pytest.fixture
def own_texts(tmp_path):
    """Texts of an experimenter, their fingerprint in the diaries of a study."""
    texts = tmp_path / "lab" / "ours.toml"
    texts.parent.mkdir()
    texts.write_text(words_file("en").read_text("utf-8").replace('title = "', 'title = "Ours: ', 1), "utf-8")
    study = tmp_path / "own"
    take_part(study, STUDY, ANN, [(0.4, 1, 1)])
    diary = study / "people" / f"{ANN}.jsonl"
    diary.write_text(diary.read_text("utf-8").replace("en 3f9a01bc22d1", fingerprint(read_words(str(texts)))), "utf-8")
    with_right_checksums(diary)
    (study / "people" / "experiment.json").write_text(json.dumps({"language": str(texts)}))
    return texts


def test_the_texts_that_were_read_come_along(own_texts, tmp_path):
    write_dataset(tmp_path / "own", tmp_path / "out")
    assert (tmp_path / "out" / "materials" / "texts.toml").read_bytes() == own_texts.read_bytes()
    assert "materials/texts.toml" in (tmp_path / "out" / "README.md").read_text("utf-8")
    assert str(own_texts) not in everything(tmp_path / "out")


def test_they_come_along_again_from_where_they_were_taken_in(own_texts, tmp_path):
    write_dataset(tmp_path / "own", tmp_path / "out")
    own_texts.unlink()
    source = source_of_dataset(tmp_path / "out")
    gather(tmp_path / "new", [source], beside=DiaryImport(tmp_path / "new", {source.path: source.trials}).take)
    write_dataset(tmp_path / "new", tmp_path / "again")
    assert everything(tmp_path / "again") == everything(tmp_path / "out")
    assert (tmp_path / "again" / "materials" / "texts.toml").is_file()


@pytest.mark.parametrize(
    "change",
    [
        lambda texts: texts.unlink(),
        lambda texts: texts.write_text("x = 1"),
        lambda texts: texts.write_text(texts.read_text("utf-8").replace("Ours:", "Edited:", 1), "utf-8"),
    ],
)
def test_texts_that_are_gone_or_were_edited_since_are_left_out(own_texts, tmp_path, change):
    change(own_texts)
    write_dataset(tmp_path / "own", tmp_path / "out")
    assert not (tmp_path / "out" / "materials").exists()
    assert "materials" not in (tmp_path / "out" / "README.md").read_text("utf-8")


def test_the_records_are_the_study_of_people_byte_by_byte(dataset, directory):
    people = [trial for trial in load(directory) if trial.agent != "random"]
    assert load(dataset / "records") == people
    theirs = (directory / "trials.jsonl").read_bytes().splitlines()
    assert (dataset / "records" / "trials.jsonl").read_bytes().splitlines() == [
        line for line in theirs if b'"agent":"participant:' in line
    ]
    assert read_study(dataset / "records") == replace(STUDY, agents=("participant",))


def test_the_number_of_withdrawals_comes_along_for_the_report(directory, tmp_path):
    count_withdrawn(directory, 3)
    write_dataset(directory, tmp_path / "out")
    assert withdrawn(tmp_path / "out" / "records") == 3


def test_strategies_are_in_it_where_that_is_asked_for(directory, tmp_path):
    write_dataset(directory, tmp_path / "all", everybody=True)
    assert load(tmp_path / "all" / "records") == load(directory)
    assert read_study(tmp_path / "all" / "records") == STUDY
    (path,) = (tmp_path / "all" / "data").glob("*steps*")
    assert {row[0] for row in read(path)[1:]} == {"", ANN, BOB}


def test_pictures_that_people_saw_come_along(tmp_path):
    names = ["0" * 20 + ".png", "1" * 20 + ".png"]
    shown = [{"rgb": name} for name in names]
    trial = make_trial([0], agent=f"participant:{ANN}", budget=1, modality="rgb", study="modalities", pictures=shown)
    study = replace(modality_study(["participant"], ["rgb"], trials=1), max_steps=1)
    here = write_study(tmp_path / "here", study, [trial])
    (here / "pictures").mkdir()
    for name in (names[0], "2" * 20 + ".png"):
        (here / "pictures" / name).write_bytes(b"png")
    write_dataset(here, tmp_path / "out")
    assert [path.name for path in (tmp_path / "out" / "records" / "pictures").iterdir()] == names[:1]


def test_a_study_without_people_is_no_dataset(tmp_path):
    directory = write_study(tmp_path / "study", small_study(["random"], trials=1))
    with pytest.raises(BadFile, match="nobody took part"):
        write_dataset(directory, tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_nothing_is_written_over_and_nothing_is_left_of_what_failed(directory, tmp_path):
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "x").write_text("mine")
    with pytest.raises(BadFile, match="not empty"):
        write_dataset(directory, tmp_path / "full")
    (tmp_path / "file").write_text("mine")
    with pytest.raises(BadFile, match="not empty"):
        write_dataset(directory, tmp_path / "file")
    with pytest.raises(BadFile, match="cannot be written"):
        write_dataset(directory, tmp_path / "file" / "out")
    (tmp_path / "empty").mkdir()
    write_dataset(directory, tmp_path / "empty")
    assert {path.name for path in tmp_path.iterdir()} == {"study", "full", "file", "empty"}
