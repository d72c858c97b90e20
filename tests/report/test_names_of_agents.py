"""Pages call an agent by its name: its spec, which may hold a path, is nowhere, and no number is another one."""

import json
from dataclasses import replace

import pytest
from builders import play_study, write_study

from lockprobe.foundation.errors import ModelFault
from lockprobe.report.results import results
from lockprobe.studies.options.studyfile import study
from lockprobe.trial.loop import broken

SPEC = "human-inspired?lapse=0.125"


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    asked = {"p": [0, 0.4], "condition": "nudge", "trials": 3}
    studies = [
        study("flips", agent=[agent, "random", "cognitive:careful"], **asked) for agent in (f"zeta={SPEC}", SPEC)
    ]
    return [results(write_study(tmp_path_factory.mktemp("names"), one)) for one in studies]


def test_results_hold_the_name_and_not_the_spec_and_it_changes_no_number_and_no_sentence(found):
    named, plain = found
    assert named.study["agents"] == ["zeta", "random", "cognitive:careful"]
    assert [one.agent for one in named.design.players if one.subject] == ["cognitive:careful"]  # zeta is a baseline
    told, expected = (one.model_dump(mode="json") | {"settings_hash": "", "results_hash": ""} for one in (named, plain))
    assert SPEC not in json.dumps(told)
    assert json.loads(json.dumps(told).replace("zeta", SPEC)) == expected


def test_what_broke_an_agent_with_a_name_is_said_without_its_spec(tmp_path):
    own = study("flips", agent=["mine=python:secret.place:Own?key=k", "random"], p=[0], trials=1, repetitions=1)
    plans = [plan for agent in own.agents for plan in own.plans(agent)]
    trial = broken(plans[0], ModelFault(f"agent '{own.agents[0]}' does not work"))
    found = results(write_study(tmp_path, own, [trial, *play_study(replace(own, agents=("random",)))]))
    assert "secret" not in found.model_dump_json()
    assert "agent 'mine' does not work" in found.model_dump_json()
