"""``lockprobe branch``: forks a study's trials, says what one report did, and goes on where it stopped."""

import json

import pytest
from typed import in_process as run

from lockprobe.cli.format_cost import money
from lockprobe.cli.run_study import BUDGET_REACHED
from lockprobe.studies.costs.call_log import read_calls
from lockprobe.studies.records.read_records import load

STUDY = ["--agent", "cognitive:insistent", "--p", "0,0.4", "--trials", "4", "--repetitions", "1", "--no-report"]


@pytest.fixture(scope="module")
def directory(tmp_path_factory):
    where = tmp_path_factory.mktemp("branch") / "study"
    assert run("run", "flips", *STUDY, "--out", where).exit_code == 0
    return where


def test_it_prints_a_row_for_every_place_and_arm_and_resumes(directory):
    command = ("branch", directory, "--at", "3,onset", "--told", "lie,lie-truth", "--times", "2")
    first = run(*command)
    assert "after 3, onset; arms truth, lie, lie-truth; 2 continuations each" in first.stdout
    rows = [line.split() for line in first.stdout.splitlines() if line.startswith("cognitive:insistent  ")]
    assert {(row[1], row[2], row[3]) for row in rows if "trials" not in row[1]} >= {
        ("truth", "3", "lie"),
        ("flip?p=0.4", "3", "lie"),
        ("truth", "onset", "lie-truth"),
    }
    assert "effects of one report on success detected" in first.stdout
    again = run(*command)
    assert "forks are done already" in again.stdout
    assert [line for line in again.stdout.splitlines() if "lie" in line and "%" in line] == [
        line for line in first.stdout.splitlines() if "lie" in line and "%" in line
    ]


def test_as_json_it_has_every_effect_with_its_interval(directory):
    done = run("branch", directory, "flips/cognitive:insistent/flip?p=0.4", "--at", "5", "--json")
    events = [json.loads(line) for line in done.stdout.splitlines()]
    assert events[0]["event"] == "begin"
    effects = events[-1]["effects"]
    changes = {one["of"].partition(", ")[0]: one for one in effects if one["quantity"] == "fork_change"}
    places = {(one["condition"], one["of"].partition(", ")[2]) for one in effects}
    assert places == {("flip?p=0.4", "lie, 5, later reports as in the condition")}
    assert changes.keys() >= {"success", "steps", "repeats"}
    assert all(one["clusters"] <= 4 for one in changes.values())


SPEC = "llm:openai-api/fake/model"
A_CALL = (11 * 100 + 5 * 1000) / 1e6
"""US dollars of each call, as the server counts tokens."""


def owed(asked):
    """Of six forks, those that are not on record."""
    return 6 - sum(trial.ending != "error" for trial in load(asked[1] / "forks"))


def test_a_budget_stops_forks_cleanly_a_larger_one_goes_on_and_status_shows_the_cost(
    lockprobe, provider, prices, tmp_path
):
    server, _ = provider
    prices(100, 1000)
    study = ("run", "flips", "--agent", SPEC, "--p", 1, "--trials", 3, "--repetitions", 1, "--max-steps", 6)
    assert lockprobe(*study, "--out", tmp_path / "study")[0] == 0
    asked = ("branch", tmp_path / "study", "--at", "1", "--connections", 1, "--retries", 0, "--then", "truth")
    before = server.account()["replied"]
    status, said, _ = lockprobe(*asked, "--budget", 0.4)
    assert status == BUDGET_REACHED
    left, spent = owed(asked), (server.account()["replied"] - before) * A_CALL
    assert 0 < left < 6
    assert 0 < spent <= 0.4
    ended = said.splitlines()[-1]
    assert f"{money(spent)} of $0.40 spent, too little is left for a call" in ended
    assert f"; {left} of 6 trials are owed" in ended
    begun = {call.key for call in read_calls(asked[1] / "forks")}
    assert begun >= {fork.key for fork in load(asked[1] / "forks")}
    status, said, _ = lockprobe(*asked, "--budget", 50)
    assert (status, owed(asked)) == (0, 0)
    assert f"{6 - left} of 6 forks are done already" in said
    replies = [call for call in read_calls(asked[1] / "forks") if call.reply is not None]
    assert len(replies) == server.account()["replied"] - before  # what was begun went on from its replies
    facts = json.loads(lockprobe("status", asked[1], "--json")[1])
    assert (facts["forks"], facts["calls"], facts["spent_on_forks"]["calls"]) == (6, before, len(replies))
