"""``lockprobe import``, and ``lockprobe export`` of what was imported."""

import json

import pytest
from builders import small_study, write_study
from stored import records, sql
from taking_part import take_part

from lockprobe.studies.records.read_records import load

STUDY = small_study(trials=1, repetitions=1)


@pytest.fixture
def played(tmp_path):
    return write_study(tmp_path / "played", STUDY)


def test_replies_of_trials_that_are_not_finished_are_counted(lockprobe, tmp_path, played):
    (key,) = sql(played, "delete from trial where id = 1 returning key")
    call = {"key": key, "step": 1, "turn": 1, "request": "r", "reply": "{}"}
    sql(played, "insert into call values (1, ?1, ?2, checksum(?1, ?2))", key, json.dumps(call))
    said = lockprobe("import", tmp_path / "new", played)[1]
    assert " imported, 0 already there (0 differ from those of " in said
    assert "keeps its own), 1 unfinished (1 replies kept for them), 0 participants." in said


def test_people_are_taken_in_beside_strategies_with_their_times(lockprobe, tmp_path, played):
    study, people = small_study(["participant"], trials=1, repetitions=1), tmp_path / "people"
    take_part(people, study, "aaaa01", [(0.0, 1, 1)], platform={"PROLIFIC_PID": "5f00ab"})
    take_part(people, study, "bbbb02", [(0.3, 1, 1), (0.6, 1, 1)], left_after=1)
    status, said, _ = lockprobe("import", played, people)
    assert status == 0
    assert "2 trials imported, 0 already there (0 " in said
    assert ", 2 participants. New agents: participant." in said
    again = json.loads(lockprobe("import", played, people, "--json")[1])
    assert (again["taken"], again["there"], again["participants"]) == (0, 2, 0)
    rows = [json.loads(line) for line in lockprobe("export", played, "--format", "jsonl")[1].splitlines()]
    times = {(row["agent"], row["step"]): row["rt_ms"] for row in rows}
    assert (times["participant:aaaa01", 1], times["random", 1]) == (1001.5, "")


def a_record(played):
    sql(played, "update trial set record = substr(record, 1, 99) where id in (2, 5)")


def a_page(played):
    """A page that holds the first trials, as a bad sector leaves it."""
    content = bytearray((played / "study.db").read_bytes())
    leaf = min(
        at for at in range(4096, len(content), 4096) if content[at] == 13 and b"flips/random" in content[at : at + 4096]
    )
    content[leaf : leaf + 4096] = b"\xff" * 4096
    (played / "study.db").write_bytes(content)


@pytest.mark.parametrize("damage", [a_record, a_page])
def test_what_is_sound_of_a_damaged_study_is_saved_and_the_rest_is_played_again(lockprobe, tmp_path, damage):
    damaged = write_study(tmp_path / "damaged", small_study(trials=4, repetitions=1))
    whole, there = load(damaged), records(damaged)
    damage(damaged)
    before, new = (damaged / "study.db").read_bytes(), tmp_path / "new"
    status, _, said = lockprobe("export", damaged)
    assert (status, said.count("\n")) == (2, 1)
    assert f"save the rest: `lockprobe import NEW {damaged}`, where NEW does not exist yet" in said
    status, printed, said = lockprobe("import", new, damaged)
    saved = records(new)
    why, sound = said.splitlines()
    assert why.startswith(f"{damaged}/study.db: ")
    assert why.endswith(")")  # no advice to do what is being done
    assert sound == f"Sound in {damaged}: {len(saved)} trials."
    assert (status, printed.partition(",")[0]) == (0, f"{len(saved)} trials imported")
    assert saved == [one for one in there if one in saved]
    assert {a_record: 22, a_page: 12}[damage] <= len(saved) < 24
    assert (damaged / "study.db").read_bytes() == before
    agents = [word for agent in STUDY.agents for word in ("--agent", agent)]
    size = ("--p", "0,0.3,0.6", "--repetitions", "1", "--trials", "4")
    assert lockprobe("run", "flips", *agents, *size, "--no-report", "--out", new)[0] == 0
    assert {trial.key: trial for trial in load(new)} == {trial.key: trial for trial in whole}
