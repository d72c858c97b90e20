"""The directory for ``load_dataset`` holds every trial once, in the split of its agent, as its card says."""

import pytest
import yaml
from builders import play_study, small_study

from lockprobe.errors import BadValue
from lockprobe.export import tidy_rows, trial_rows
from lockprobe.export.hub_dataset import split_names, write_hub_dataset

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
