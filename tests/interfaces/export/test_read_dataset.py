"""A dataset that went out comes back the same, and one that disagrees with itself does not."""

import asyncio
import csv
import os
import shutil
from dataclasses import replace

import pytest
import seated
from builders import play_study, small_study, write_study
from seated import under
from taking_part import START, take_part

from lockprobe.foundation.errors import BadFile
from lockprobe.foundation.terminal_text import readable
from lockprobe.interfaces.export import read_dataset
from lockprobe.interfaces.export.read_dataset import is_dataset, source_of_dataset
from lockprobe.interfaces.export.write_dataset import write_dataset
from lockprobe.people.import_diaries import DiaryImport
from lockprobe.people.responses import Attempt
from lockprobe.people.scenes import Box
from lockprobe.studies.records.journal import load, read_timings
from lockprobe.studies.records.merge import gather

STUDY = small_study(["participant"], p=[0.0, 0.4], trials=2)
MODELS = replace(STUDY, agents=("random",))
ANN, BOB = "aaaa01", "bbbb02"


@pytest.fixture
def dataset(tmp_path):
    made = tmp_path / "people"
    take_part(made, STUDY, ANN, [(0.4, 1, 1), (0.0, 1, 2)], answers={"why": "=1\r\n2"})
    take_part(made, STUDY, BOB, [(0.0, 1, 1), (0.4, 2, 1)], left_after=1, joined=START + 60)
    write_dataset(made, tmp_path / "out")
    return tmp_path / "out"


def take_in(directory, dataset):
    source = source_of_dataset(dataset)
    diaries = DiaryImport(directory, {source.path: source.trials})
    return gather(directory, [source], beside=diaries.take)


def contents(dataset):
    return {path.relative_to(dataset).as_posix(): path.read_bytes() for path in dataset.rglob("*") if path.is_file()}


def table(dataset, name):
    (path,) = (dataset / "data").glob(f"*description-{name}_data.csv")
    return path


def test_out_and_in_and_out_again_is_the_same(dataset, tmp_path):
    here = write_study(tmp_path / "here", MODELS, play_study(MODELS))
    gathered = take_in(here, dataset)
    assert (gathered.taken, gathered.there, gathered.agents) == (3, 0, ("participant",))
    people = (tmp_path / "people" / "trials.jsonl").read_bytes()
    assert (here / "trials.jsonl").read_bytes().endswith(people)
    seconds = {timing.key: timing for timing in read_timings(here)}
    assert all(seconds[timing.key] == timing for timing in read_timings(tmp_path / "people"))
    write_dataset(here, tmp_path / "again")
    assert contents(tmp_path / "again") == contents(dataset)


def test_a_dataset_of_any_conditions_comes_back_and_names_them(tmp_path):
    study = under("truth", "flip?p=0.4 + nudge", "tremble?p=0.3", trials=3)
    seated.take_part(tmp_path / "study", study, seated.short(), people=2)
    write_dataset(tmp_path / "study", tmp_path / "dataset")
    for name in ("trials", "steps"):
        with table(tmp_path / "dataset", name).open(encoding="utf-8", newline="") as file:
            rows = list(csv.DictReader(file))
        assert {row["condition"] for row in rows} == {one.label for one in study.conditions}
        assert {row["p"] for row in rows} == {"0.0", ""}
    here = write_study(tmp_path / "here", replace(study, agents=("random",)), [])
    assert take_in(here, tmp_path / "dataset").taken == 6
    write_dataset(here, tmp_path / "again")
    assert contents(tmp_path / "again") == contents(tmp_path / "dataset")


def test_what_is_taken_twice_is_there_once(dataset, tmp_path):
    here = write_study(tmp_path / "here", MODELS, [])
    take_in(here, dataset)
    before = contents(here)
    gathered = take_in(here, dataset)
    assert (gathered.taken, gathered.there) == (0, 3)
    assert contents(here) == before
    again = take_in(tmp_path / "people", dataset)  # into the study that it came from
    assert (again.taken, again.there) == (0, 3)


def test_a_dataset_of_another_study_is_refused_and_nothing_is_written(dataset, tmp_path):
    here = write_study(tmp_path / "here", replace(MODELS, seed=2), [])
    before = contents(here)
    with pytest.raises(BadFile, match="seed is 1, not 2"):
        take_in(here, dataset)
    assert contents(here) == before


def test_a_table_that_a_spreadsheet_has_saved_still_agrees(dataset):
    path = table(dataset, "answers")
    path.write_bytes(b"\xef\xbb\xbf" + path.read_bytes())
    path = table(dataset, "steps")
    header, *rows = path.read_text("utf-8").splitlines()
    path.write_text("\r\n".join([f"{header},mine", *(f"{row},5" for row in rows), ""]), "utf-8", newline="")
    assert len(source_of_dataset(dataset).trials) == 3


@pytest.mark.parametrize(
    ("name", "change", "said"),
    [
        ("steps", lambda text: text.replace(",1001.5,", ",1002.5,", 1), "row 1: rt_ms is '1002.5', and '1001.5'"),
        ("steps", lambda text: text.replace(",b0000,", ",0,", 1), "row 1: state is '0', and 'b0000'"),
        ("steps", lambda text: text.rsplit("\n", 2)[0] + "\n", "rows, and the records have"),
        ("steps", lambda text: text.replace("rt_ms", "rt", 1), "has no column rt_ms"),
        ("steps", lambda text: text.replace(",view,", ",rt_ms,", 1), "has two columns rt_ms"),
        ("checks", lambda text: text.rsplit(",", 1)[0] + "\n", "at is None"),
        ("participants", lambda text: text.replace(BOB, "eeee05"), "participant is 'eeee05'"),
        ("checks", lambda text: text.replace(",1,2000.0", ",0,2000.0"), "right is '0', and '1'"),
        ("answers", lambda text: text + '"', "cannot be read"),
        ("trials", lambda text: text.replace(",solved,1,", ",solved,0,", 1), "solved is '0', and '1'"),
        ("participants", lambda text: text.replace("p=0.4", "p=0.5", 1), "conditions is"),
        ("acts", lambda text: "", "has no column participant"),
    ],
)
def test_a_table_that_says_something_else_than_the_records_is_refused(dataset, name, change, said):
    path = table(dataset, name)
    with path.open(encoding="utf-8", newline="") as file:
        before = file.read()
    after = change(before)
    assert after != before
    path.write_text(after, "utf-8", newline="")
    with pytest.raises(BadFile, match=said):
        source_of_dataset(dataset)


def test_a_record_that_was_changed_is_refused_too(dataset):
    path = dataset / "records" / "trials.jsonl"
    path.write_bytes(b"".join(path.read_bytes().splitlines(keepends=True)[1:]))
    with pytest.raises(BadFile, match="the records have"):
        source_of_dataset(dataset)


def test_a_table_that_is_missing_or_no_text_is_refused(dataset):
    table(dataset, "acts").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(BadFile, match="cannot be read"):
        source_of_dataset(dataset)
    table(dataset, "acts").unlink()
    with pytest.raises(BadFile, match="cannot be read"):
        source_of_dataset(dataset)


@pytest.mark.parametrize("name", ["records/trials.jsonl", "records/people", "data"])
def test_no_link_is_followed(dataset, tmp_path, name):
    kept = (dataset / name).rename(tmp_path / "elsewhere")
    (dataset / name).symlink_to(kept)
    with pytest.raises(BadFile, match="a link"):
        source_of_dataset(dataset)


def test_a_file_that_is_too_large_is_not_read(dataset, monkeypatch):
    monkeypatch.setattr(read_dataset, "LARGEST_FILE", 100)
    with pytest.raises(BadFile, match="larger than"):
        source_of_dataset(dataset)


def test_what_is_no_dataset_is_none(dataset, tmp_path):
    assert is_dataset(dataset)
    assert not is_dataset(dataset / "records")
    assert not is_dataset(tmp_path / "nowhere")


def test_strategies_of_a_dataset_come_in_too(tmp_path):
    both = replace(STUDY, agents=("random", "participant"))
    made = write_study(tmp_path / "made", both, play_study(MODELS))
    take_part(made, both, ANN, [(0.4, 1, 1)])
    write_dataset(made, tmp_path / "out", everybody=True)
    take_in(tmp_path / "new", tmp_path / "out")
    assert load(tmp_path / "new") == load(made)


@pytest.mark.parametrize(
    "answer", ["one\rtwo", "\r", "x\r", "a\0b", "a\u2028b\x85c\x0bd", "", '"', "'", ",", "a\n\nb", "=1"]
)
def test_whatever_is_answered_the_dataset_comes_back(tmp_path, answer):
    take_part(tmp_path / "people", STUDY, ANN, [(0.4, 1, 1)], answers={"why": answer, "how": "fine"})
    write_dataset(tmp_path / "people", tmp_path / "out")
    assert len(source_of_dataset(tmp_path / "out").trials) == 1
    with table(tmp_path / "out", "answers").open(encoding="utf-8", newline="") as file:
        said = [row["answer"] for row in csv.DictReader(file, strict=True)]
    assert [text.removeprefix("'") for text in said] == [readable(answer).removeprefix("'"), "fine"]


def test_people_can_take_part_where_a_dataset_with_texts_of_its_own_was_taken_in(tmp_path):
    study, experiment = seated.people_study(), seated.short(language="/lab/ours.toml")
    seated.take_part(tmp_path / "there", study, experiment)
    write_dataset(tmp_path / "there", tmp_path / "out")
    take_in(tmp_path / "here", tmp_path / "out")
    seated.take_part(tmp_path / "here", study, experiment)
    assert len({trial.agent for trial in load(tmp_path / "here")}) == 2


def test_somebody_who_is_further_on_in_a_dataset_goes_on_here_with_the_same_browser(tmp_path):
    study, experiment = seated.people_study(), seated.short()

    def at_step_two(shown):
        return isinstance(shown.scene, Box) and shown.scene.step == 2

    (ann,) = seated.take_part(tmp_path / "here", study, experiment, platform={"PID": "a"}, until=at_step_two)
    shutil.copytree(tmp_path / "here", tmp_path / "there")

    async def one_step(directory):
        async with seated.opened(directory, study, experiment) as reception:
            shown = await reception.enter(ann.token, {})
            attempt = Attempt(joint="A", rt=1.0, claimed="moved")
            return await reception.act(shown.token, shown.lease, shown.turn, attempt, {})

    asyncio.run(one_step(tmp_path / "there"))
    write_dataset(tmp_path / "there", tmp_path / "out")
    take_in(tmp_path / "here", tmp_path / "out")
    shown = asyncio.run(one_step(tmp_path / "here"))
    assert (shown.identity, shown.scene.step) == (ann.identity, 4)


def test_a_table_that_is_a_pipe_is_refused_and_not_waited_for(dataset):
    path = table(dataset, "steps")
    path.unlink()
    os.mkfifo(path)
    with pytest.raises(BadFile, match=r"steps_data.csv: a pipe, not a regular file"):
        source_of_dataset(dataset)
