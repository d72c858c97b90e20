"""``lockprobe status``: how a study stands, by boundary, by agent and in money; while it runs and long afterwards."""

import asyncio
import json
import shutil
from dataclasses import replace

import pytest
from builders import SOLUTION, call_of, make_trial, write_study
from stored import written as opened

from lockprobe.agents.llm.model_facts import OWN_FACTS
from lockprobe.cli.status import status
from lockprobe.report.page import write_report
from lockprobe.studies.costs.call_log import Calls
from lockprobe.studies.options.study_options import StudyOptions
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.records.journal import Journal
from lockprobe.trial.model_call import BROKEN_OFF, Usage

DEAR, FREE = "llm:fake/dear", "llm:fake/unheard"
FACTS = """
[[model]]
match = ["fake/dear"]
price = { input = 3, cached = 1, output = 10, date = "2026-01-02", source = "made up" }
"""


@pytest.fixture
def told(tmp_path, monkeypatch, capsys):
    """From a directory to what ``status`` says of it: facts, and lines."""
    (tmp_path / "models.toml").write_text(FACTS)
    monkeypatch.setenv(OWN_FACTS, str(tmp_path / "models.toml"))

    def tell(directory):
        capsys.readouterr()
        status(directory, json=True)
        facts = json.loads(capsys.readouterr().out)
        status(directory)
        return facts, capsys.readouterr().out.splitlines()

    return tell


def planned(*agents, trials=3):
    return study(StudyOptions(box="chain-4", layout="fixed", agent=list(agents), trials=trials, p=[0], repetitions=1))


def replied(agent=DEAR, trial=1, step=1, **more):
    usage = Usage(calls=1, input_tokens=1000 * step, output_tokens=100, cached_tokens=500, reasoning_tokens=50)
    return call_of(make_trial([0], agent=agent, trial=trial), step, **({"usage": usage, "served": "dear-1"} | more))


def written(directory, *made):
    with opened(directory) as store:
        calls = Calls(store)
        for call in made:
            most = Usage(calls=1, input_tokens=2000, output_tokens=1000)
            asyncio.run(calls.reserve(replace(call, most=most)))
            asyncio.run(calls.write(call))


def test_calls_are_counted_by_agent_and_in_all(tmp_path, told):
    finished = [make_trial(SOLUTION, agent=DEAR), make_trial(SOLUTION)]
    write_study(tmp_path / "s", planned(DEAR, FREE, "random"), finished)
    nothing = {"reply": None, "usage": Usage(), "served": ""}
    written(
        tmp_path / "s",
        *(replied(step=step) for step in (1, 2, 3, 4)),
        replied(trial=2, retries=3),
        replied(trial=2, step=2, error="the provider answered 500: no", **nothing),
        replied(trial=3, error=BROKEN_OFF, **nothing),
        replied(FREE, served="free-1"),
    )
    facts, lines = told(tmp_path / "s")
    assert (facts["calls"], facts["failed"], facts["broken_off"], facts["retries"]) == (6, 1, 1, 3)
    assert (facts["input_tokens"], facts["cached_tokens"], facts["output_tokens"]) == (12_000, 3000, 600)
    assert (facts["in_progress"], facts["in_progress_calls"]) == (3, 2)
    assert facts["dollars"] is None  # one price is not known
    dear = facts["agents"][DEAR]
    assert dear["dollars"] == pytest.approx((8500 * 3 + 2500 * 1 + 500 * 10) / 1e6)
    assert dear["dollars_unknown"] == pytest.approx((2000 * 3 + 1000 * 10) / 1e6)
    assert (dear["price_date"], facts["price_date"]) == ("2026-01-02", None)
    assert facts["served"] == {"dear-1": 5, "free-1": 1}
    assert list(facts["agents"]) == [DEAR, FREE]
    assert (
        f"calls       {DEAR}: 5 replies, $0.033 spent, 3 retries, 1 call failed, 1 call broken off; at most"
        in "\n".join(lines)
    )
    assert f"            {FREE}: 1 reply, 1,000 tokens in, 100 out" in lines
    assert "open        3 trials unfinished, 2 replies kept for them" in lines
    assert "uncounted   1 attempt of unknown cost" in lines
    assert "steps       8 in 2.0 s of playing, summed over parallel trials" in lines
    with Journal.open(tmp_path / "s", planned(DEAR, FREE, "random")):  # it is still played
        facts, lines = told(tmp_path / "s")
    assert (facts["on_their_way"], facts["broken_off"], facts["unpriced"]) == (1, 0, 0)
    assert "open        3 trials unfinished, 2 replies kept for them, 1 call on their way" in lines


def test_errors_are_told_by_boundary_with_the_first_of_each(tmp_path, told):
    def failed(boundary, trial, message):
        trial = make_trial([0], agent="random", trial=trial, broken=boundary)
        return replace(trial, error=replace(trial.error, message=message))

    errors = [failed("reply", 1, "no usable\nreply"), failed("model", 2, "429: slow down"), failed("model", 3, "later")]
    write_study(tmp_path / "s", planned("random"), errors)
    facts, lines = told(tmp_path / "s")
    assert facts["errors"] == {"reply": 1, "model": 2}
    assert facts["first_errors"] == {"reply": "no usable\nreply", "model": "429: slow down"}
    assert (facts["done"], facts["owed"]) == (1, 2)
    assert "errors      3 errors: model 2, reply 1" in lines
    assert "            first at model: 429: slow down" in lines
    assert "            first at reply: no usable reply" in lines


def test_trials_of_people_are_owed_by_nobody(tmp_path, told):
    mixed = planned("participant", "random", trials=4)
    played = [make_trial(SOLUTION, trial=i) for i in (1, 2, 3)]
    played += [
        make_trial(SOLUTION, agent=f"participant:{who}", trial=i) for i, who in ((1, "aaaa"), (2, "aaaa"), (3, "bbbb"))
    ]
    facts, lines = told(write_study(tmp_path / "study", mixed, played))
    assert [facts[name] for name in ("trials", "done", "owed", "solved")] == [4, 3, 1, 3]
    assert [facts[name] for name in ("people_trials", "people_done", "people_solved", "people")] == [4, 3, 3, 2]
    assert [facts[name] for name in ("planned", "finished", "partial")] == [8, 6, True]
    assert f"people      3 of 4 played by 2, 3 solved (lockprobe serve {tmp_path / 'study'})" in lines
    facts, others = told(write_study(tmp_path / "other", planned("random")))
    assert [line.split()[0] for line in others] == ["study", "trials", "steps", "errors", "settings"]
    assert others[1] == f"trials      3 of 3 done, 0 owed, {facts['solved']} solved"


def test_it_says_when_it_looked_and_how_far_the_report_is_behind(tmp_path, told, monkeypatch):
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1795960920")
    trials = [make_trial(SOLUTION, agent="random", trial=i) for i in (1, 2, 3)]
    directory = write_study(tmp_path / "s", planned("random"), trials[:1])
    facts, lines = told(directory)
    assert facts["reported"] is None
    assert lines[0] == f"study       flips in {directory}, at 14:02 on 29 November 2026"
    assert not [line for line in lines if line.startswith("report")]
    write_report(directory)
    assert "report      of 1 of 3 trials" in told(directory)[1]
    shutil.copy(write_study(tmp_path / "more", planned("random"), trials) / "study.db", directory)
    facts, lines = told(directory)
    assert (facts["time"], facts["reported"]) == ("14:02 on 29 November 2026", 1)
    assert f"report      of 1 of 3 trials, 2 behind; lockprobe report {directory} makes it anew" in lines
