"""run says a hash before the first trial and one after the last; status, report and verify know them again."""

import json
import re
from subprocess import CompletedProcess

import pytest
from provider_server import ENDS, Manner, here, truthful

from lockprobe import run_study, study
from lockprobe.agents.model_access import Access
from lockprobe.foundation.storage.jsonl import whole_lines, with_checksum, without_checksum
from lockprobe.report.verify.verification import verify
from lockprobe.studies.branch import FORKS, branching, play_forks
from lockprobe.studies.records.journal import Journal
from lockprobe.studies.records.read_records import load
from lockprobe.studies.running.runner import Limits

RUN = ("run", "flips", "--agent", "random", "--p", "0,0.4", "--trials", "2", "--repetitions", "1")


def hashes(text):
    return dict(re.findall(r"^(Settings|Results): ([0-9a-f]{32}) ", text, re.MULTILINE))


def test_hashes_are_said_around_the_trials_and_known_again(tmp_path, lockprobe):
    def typed_here(*arguments):
        return CompletedProcess(arguments, *lockprobe(*arguments))

    out = tmp_path / "out"
    lines = typed_here(*RUN, "--out", out).stdout.splitlines()
    said = hashes("\n".join(lines))
    first, trials, last = (
        next(i for i, line in enumerate(lines) if line.startswith(start))
        for start in ("Settings: ", "random: 4 trials", "Results: ")
    )
    assert first < trials < last
    status = json.loads(typed_here("status", out, "--json").stdout)
    assert (status["settings_hash"], status["results_hash"]) == (said["Settings"], said["Results"])
    shown = typed_here("status", out).stdout
    assert all(found in shown for found in said.values())
    assert all(found in (out / "report.html").read_text("utf-8") for found in said.values())
    done = typed_here("verify", out, "--settings", said["Settings"], "--results", said["Results"])
    assert done.returncode == 0
    assert f"these results have the hash {said['Results']}" in done.stdout
    done = typed_here("verify", out, "--settings", said["Results"])
    assert done.returncode == 1
    assert (
        f"FAILS  settings hash  these settings have the hash {said['Settings']}, not {said['Results']}" in done.stdout
    )
    assert hashes(typed_here(*RUN, "--estimate").stderr) == {"Settings": said["Settings"]}
    done = typed_here("verify", out, "--settings", "")
    assert (done.returncode, done.stderr.count("\n")) == (2, 1)


@pytest.fixture
def hosted(tmp_path, monkeypatch):
    """Plays a study of a hosted model under some conditions."""
    pytest.importorskip("inspect_ai")
    monkeypatch.setenv("FAKE_API_KEY", "sk-private-0123456789")

    def play(agent="llm:openai-api/fake/model", faults=None, out="out", limits=None, **given):
        planned = study("flips", agent=[agent], trials=2, repetitions=1, max_steps=6, **given)
        with here(truthful, Manner(faults=faults or {})) as server:
            monkeypatch.setenv("FAKE_BASE_URL", server.url)
            run_study(planned, tmp_path / out, limits=limits or Limits(access=Access(connections=2, pause=0.01)))
            yield planned, tmp_path / out

    return lambda **given: next(iter([*play(**given)]))


@pytest.mark.parametrize(
    "given",
    [
        {"condition": ["history?last=2", "flip?p=0.4"]},
        {"condition": ["nudge?after=2", "hypothesis?ask=after", "tremble?p=0.5"]},
        {
            "p": [0],
            "modality": ["rgb"],
            "plant": "fast-twin?width=160&height=120",
            "agent": "llm:openai-api/fake/model?images=1",
        },
        {
            "p": [0, 0.4],
            "assessment": False,
            "layout": "shuffled",
            "faults": {"wrong schema": 0.2, "429": 0.1, "dropped": 0.1, "500": 0.1},
        },
        {
            "p": [0, 0.4],
            "agent": "llm:openai-api/fake/model?max_tokens=50&schema=none&top_p=0.5",
            "faults": dict.fromkeys(ENDS, 0.15),
        },
    ],
    ids=["forgetful", "asked", "pictures", "faults", "endings"],
)
def test_a_study_of_a_hosted_model_holds_as_it_was_played(hosted, given):
    _, directory = hosted(**given)
    assert [check for check in verify(directory) if not check.holds] == []


def test_a_study_holds_whose_calls_broke_and_were_made_again_later(hosted):
    broken, again = {"dropped": 1.0}, {"dropped": 0.2}
    limits = Limits(access=Access(connections=2, pause=0.01, retries=2))
    for faults in (broken, again, {}):
        _, directory = hosted(p=[0], faults=faults, limits=limits)
    assert [check for check in verify(directory) if not check.holds] == []
    calls = directory / "calls.jsonl"
    fewer = [without_checksum(line).replace(b'"unanswered":3', b'"unanswered":1') for _, line in whole_lines(calls)]
    calls.write_bytes(b"".join(with_checksum(line) + b"\n" for line in fewer))
    failed = {check.name: check.failed for check in verify(directory) if not check.holds}
    assert all("step 1 had 2 attempts without an answer, not 1" in one for one in failed.pop("replies"))
    assert failed == {}


def test_forks_of_a_hosted_model_hold_and_edits_of_them_are_found(hosted, tmp_path, monkeypatch):
    planned, directory = hosted(p=[0, 0.4])
    with here(truthful) as server:
        monkeypatch.setenv("FAKE_BASE_URL", server.url)
        asked = branching(planned, load(directory), at=["2"], told=["truth", "lie"])
        with Journal.open(directory / FORKS, planned) as journal:
            play_forks(asked, journal, limits=Limits(access=Access(connections=2)))
    checks = {check.name: check for check in verify(directory)}
    assert all(check.holds for check in checks.values())
    assert "fork replies" in checks
    path = directory / FORKS / "calls.jsonl"
    path.write_bytes(b"".join(path.read_bytes().splitlines(keepends=True)[:-1]))
    assert [check.name for check in verify(directory) if not check.holds] == ["fork replies"]
