"""Trials of people and of clients with tools are held against what their servers wrote step by step."""

import asyncio
import json
import shutil

import pytest
from builders import small_study, with_right_checksums
from saboteur import Evidence, lines, relabelled, write
from taking_part import take_part
from tool_player import AGENT, Player, calls

from lockprobe import study
from lockprobe.interfaces.mcp.session import ToolSession
from lockprobe.report.verify.verification import verify
from lockprobe.studies.records.merge import gather, source_of_directory


async def played_by_a_client(directory):
    planned = study("flips", agent=[AGENT], p=[0.0, 0.3], trials=2, repetitions=1, max_steps=6)
    async with ToolSession.open(directory, planned, AGENT, together=0.0) as session:
        await Player(calls(session)).play()


@pytest.fixture(scope="module")
def served(tmp_path_factory):
    directory = tmp_path_factory.mktemp("client") / "out"
    asyncio.run(played_by_a_client(directory))
    return directory


@pytest.fixture
def of_a_client(served, tmp_path):
    return shutil.copytree(served, tmp_path / "out")


@pytest.fixture
def of_people(tmp_path):
    planned = small_study(["participant"], p=[0.0], trials=2)
    take_part(tmp_path / "people", planned, "aaaa01", [(0.0, 1, 1), (0.0, 1, 2)])
    return tmp_path / "people"


def failing(directory):
    return {check.name: check.failed for check in verify(directory) if not check.holds}


def test_what_clients_and_people_did_holds(of_a_client, of_people):
    for directory, number in ((of_a_client, 4), (of_people, 2)):
        assert failing(directory) == {}
        (said,) = [check.said for check in verify(directory) if check.name == "attempts"]
        assert said == f"{number} trials of clients and people are as their servers wrote them step by step"


def test_trials_of_a_client_keep_their_attempts_where_they_are_imported(of_a_client, tmp_path):
    for _ in range(2):
        gather(tmp_path / "merged", [source_of_directory(of_a_client)])
    assert failing(tmp_path / "merged") == {}
    assert len(lines(tmp_path / "merged" / "attempts.jsonl")) == len(lines(of_a_client / "attempts.jsonl"))


def another_hypothesis(files):
    files.records[0]["steps"][1]["decision"]["hypothesis"] = "I see the plan"


def flipped_claims(files):
    for record in files.records:
        for step in record["steps"][1:]:
            step["decision"]["claimed"] = {"moved": "blocked", "blocked": "moved"}[step["decision"]["claimed"]]


def failures_as_errors(files):
    for record in files.records:
        relabelled(record, steps=1)


def dropped(files):
    files.settings["trials"] = 1
    files.drop(lambda key: key.endswith("=1"), "records", "timings")


@pytest.mark.parametrize("edit", [another_hypothesis, flipped_claims, failures_as_errors, dropped])
def test_an_edited_trial_of_a_client_is_found(of_a_client, edit):
    files = Evidence(of_a_client)
    edit(files)
    files.save()
    assert "attempts" in failing(of_a_client)


def test_a_client_without_its_log_is_found(of_a_client):
    (of_a_client / "attempts.jsonl").unlink()
    assert len(failing(of_a_client)["attempts"]) == 4


def test_a_trial_of_a_person_that_is_not_on_record_is_found(of_people):
    files = Evidence(of_people)
    key = files.records[0]["key"]
    files.drop(lambda one: one != key, "records", "timings")
    files.save()
    assert failing(of_people)["attempts"] == (
        f"{key}: it ended in the diary of participant:aaaa01 and is not on record",
    )


def test_a_failure_of_a_person_relabelled_as_an_error_is_found(of_people):
    files = Evidence(of_people)
    relabelled(files.records[0], steps=1)
    files.save()
    assert failing(of_people).keys() >= {"attempts", "choices"}


def test_another_report_in_a_diary_is_found(of_people):
    path = of_people / "people" / "aaaa01.jsonl"
    entries = [json.loads(line) for line in path.read_bytes().splitlines()]
    next(entry for entry in entries if entry.get("box") == 1)["told"] = "Nothing."
    write(path, [{name: value for name, value in entry.items() if name != "crc"} for entry in entries])
    with_right_checksums(path)
    assert "attempts" in failing(of_people)
