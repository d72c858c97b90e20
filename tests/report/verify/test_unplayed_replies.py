"""A study on somebody's own plant is not played again, and its replies are held against its decisions all the same."""

import json
import shutil

import pytest
from provider_server import Manner, here
from saboteur import Evidence

from lockprobe import run_study, study
from lockprobe.agents.model_access import Access
from lockprobe.report.verify.verification import verify
from lockprobe.studies.running.runner import Limits

pytest.importorskip("inspect_ai")
MODEL = "llm:openai-api/fake/model"
PLANT = '''
from lockprobe.plants.symbolic import SymbolicPlant


class Bench(SymbolicPlant):
    """Somebody's own."""

    def __init__(self, *, box, labels, rng):
        super().__init__(box)
'''


@pytest.fixture(scope="module")
def played(tmp_path_factory):
    """A study of a model and a strategy on a plant of one's own, with replies that could not be used."""
    folder = tmp_path_factory.mktemp("played")
    (folder / "own_bench.py").write_text(PLANT, "utf-8")
    server = here(manner=Manner(faults={"wrong schema": 0.2, "refusal": 0.05}, seed=3))
    with pytest.MonkeyPatch.context() as patch, server as provider:
        patch.syspath_prepend(folder)
        patch.setenv("FAKE_BASE_URL", provider.url)
        patch.setenv("FAKE_API_KEY", "sk-private-0123456789")
        planned = study(
            "flips", agent=[MODEL, "random"], p=[0, 0.4], trials=3, repetitions=1, plant="python:own_bench:Bench"
        )
        run_study(planned, folder / "out", limits=Limits(access=Access(connections=1, pause=0.01)))
    return folder / "out"


@pytest.fixture
def directory(played, tmp_path):
    return shutil.copytree(played, tmp_path / "out")


def checks(directory):
    return {check.name: check for check in verify(directory)}


def test_it_holds_and_says_what_was_not_asked(directory):
    found = checks(directory)
    assert [check for check in found.values() if not check.holds] == []
    assert "6 of these trials are not played, and held by their words and joints alone" in found["replies"].said
    assert found["choices"].said.startswith("0 trials of strategies")
    assert "6 more of both are not asked, since they are not played" in found["choices"].said


def another_joint(record):
    step = record["steps"][1]
    step["decision"]["joint"] = next(one for one in record["labels"] if one != step["decision"]["joint"])


def another_claim(record):
    decision = record["steps"][1]["decision"]
    decision["claimed"] = "blocked" if decision["claimed"] == "moved" else "moved"


def other_words(record):
    decision = record["steps"][1]["decision"]
    decision["replies"][-1] = decision["replies"][-1].replace("in turn", "by luck")


def no_reply(record):
    record["steps"][1]["decision"].pop("replies")


@pytest.mark.parametrize("change", [another_joint, another_claim, other_words, no_reply])
def test_edited_decisions_are_found(directory, change):
    files = Evidence(directory)
    change(next(one for one in files.of(MODEL) if len(one["steps"]) > 2))
    files.save()
    assert [name for name, check in checks(directory).items() if not check.holds] == ["replies"]


def test_edited_replies_in_the_log_are_found(directory):
    files = Evidence(directory)
    call = next(one for one in files.calls if one["step"] == 2)
    call["reply"] = json.dumps(json.loads(call["reply"]) | {"hypothesis": "by luck"})
    files.save()
    assert [name for name, check in checks(directory).items() if not check.holds] == ["replies"]
