"""The directory for ``load_dataset`` holds every trial once, in the split of its agent, as its card says."""

import json
from collections import Counter
from dataclasses import replace

import pytest
import yaml
from builders import make_trial, play_study, small_study

import lockprobe
from lockprobe.foundation.errors import BadFile, BadValue
from lockprobe.interfaces.export import tidy_rows, trial_rows
from lockprobe.interfaces.export.hub_dataset import split_names, write_hub_dataset

ROWS = {"steps": tidy_rows, "trials": trial_rows}


def test_the_card_leads_to_all_rows(tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet")
    trials = play_study(small_study(trials=2))
    (out,) = write_hub_dataset(trials, tmp_path / "set")
    card = yaml.safe_load((out / "README.md").read_text("utf-8").split("---\n")[1])
    assert [config["config_name"] for config in card["configs"]] == ["steps", "trials"]
    for config in card["configs"]:
        tables = {one["split"]: parquet.read_table(out / one["path"]) for one in config["data_files"]}
        rows = {split: table.to_pylist() for split, table in tables.items()}
        for split, agent in (("human_inspired", "human-inspired"), ("random", "random")):
            assert rows[split] == [row for row in ROWS[config["config_name"]](trials) if row["agent"] == agent]
        assert len({table.schema for table in tables.values()}) == 1


def test_splits_have_names_of_letters_and_differ():
    assert list(split_names(["a-b", "a/b", "?"]).values()) == ["a_b", "a_b_2", "agent"]


def test_a_study_without_trials_is_refused(tmp_path):
    with pytest.raises(BadValue, match="no trials"):
        write_hub_dataset([], tmp_path / "set")


def test_pictures_stand_in_the_row_of_their_step_as_images(tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet")
    album, png = tmp_path / "pictures", b"\x89PNG of a step"
    album.mkdir()
    trial = make_trial([3, 0])
    after, before = f"{'a' * 20}.png", f"{'b' * 20}.png"
    for name in (after, before):
        (album / name).write_bytes(png + name.encode())
    first, second = trial.steps
    trial = replace(trial, steps=(replace(first, pictures={"rgb": after}), second), opening_pictures={"rgb": before})
    write_hub_dataset([trial], tmp_path / "set", album, "cc-by-4.0")
    steps, trials = (parquet.read_table(next((tmp_path / "set" / name).iterdir())) for name in ("steps", "trials"))
    assert steps.column("picture_rgb").to_pylist() == [{"bytes": png + after.encode(), "path": after}, None]
    assert trials.column("opening_rgb").to_pylist() == [{"bytes": png + before.encode(), "path": before}]
    features = json.loads(steps.schema.metadata[b"huggingface"])["info"]["features"]
    assert list(features) == steps.column_names
    assert features["picture_rgb"] == {"_type": "Image"}
    card = (tmp_path / "set" / "README.md").read_text("utf-8")
    assert yaml.safe_load(card.split("---\n")[1])["license"] == "cc-by-4.0"
    assert "The tables contain the pictures." in card


def test_a_picture_that_is_gone_is_named(tmp_path):
    pytest.importorskip("pyarrow")
    trial = replace(make_trial([3]), opening_pictures={"rgb": f"{'b' * 20}.png"})
    with pytest.raises(BadFile, match="bbbb.png: cannot be read"):
        write_hub_dataset([trial], tmp_path / "set", tmp_path)
    assert not (tmp_path / "set").exists()


@pytest.mark.parametrize("licence", ["", "CC BY", "mit\nx: y", "-"])
def test_a_licence_is_a_name(tmp_path, licence):
    with pytest.raises(BadValue, match="--licence"):
        write_hub_dataset([make_trial([3])], tmp_path / "set", licence=licence)


def test_the_library_of_the_hub_reads_it_and_its_numbers_are_those_of_the_results(tmp_path, monkeypatch):
    pytest.importorskip("pyarrow")
    monkeypatch.setenv("HF_HUB_OFFLINE", "1")
    datasets = pytest.importorskip("datasets")
    directory = tmp_path / "study"
    trials = lockprobe.run_study(small_study(trials=5), directory)
    write_hub_dataset(trials, tmp_path / "set", directory / "pictures")
    found = datasets.load_dataset(str(tmp_path / "set"), "trials", cache_dir=str(tmp_path / "cache"))
    rows = [row for split in found.values() for row in split]
    solved = Counter((row["agent"], row["p"]) for row in rows if row["solved"])
    held = {
        (cell.agent, cell.p): (cell.get("success").count, cell.trials) for cell in lockprobe.results(directory).cells
    }
    assert {key: (solved[key], n) for key, n in Counter((row["agent"], row["p"]) for row in rows).items()} == held
    steps = datasets.load_dataset(str(tmp_path / "set"), cache_dir=str(tmp_path / "cache"))
    assert sum(map(len, steps.values())) == sum(len(trial.steps) for trial in trials)
