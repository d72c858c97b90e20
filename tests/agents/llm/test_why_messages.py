"""The seven arms of the study of controls differ on the wire in the reports at the selected steps, and in nothing else."""

import json
import re

import pytest
from provider_server import here, words

import lockprobe
from lockprobe.interventions.asked_and_done import ASIDES
from lockprobe.statistics.arms import ARMS
from lockprobe.studies.options.studyfile import study

AGENT = "llm:openai-api/fake/model"

NAMING = re.compile(r"\b(truth|true|lies?|false|flips?|distract|condition|arms?|retract)|[?&]\w+=")
"""What would tell a model which arm it is in: a word, or an option of a spec."""


@pytest.fixture(scope="module")
def asked():
    """Arm -> the last request of one trial, which holds all messages of it; the model acts alike in every arm."""
    found = {}
    with here(keep=True) as provider, pytest.MonkeyPatch.context() as patch:
        patch.setenv("FAKE_BASE_URL", provider.url)
        patch.setenv("FAKE_API_KEY", "nobody-asks-for-one")
        for condition in study("why", agent=AGENT).conditions:
            trial = lockprobe.run_trial(agent=AGENT, condition=condition, trial=2, seed=2)
            assert trial.ending in ("solved", "max_steps")
            found[condition.label] = provider.requests[-1]
    return found


def differing(asked, arm):
    """Messages that an arm changes: what is said in it, and what is said in the arm of true reports."""
    pairs = zip(asked[arm]["messages"], asked["truth"]["messages"], strict=True)
    return {at: (words(mine), words(true)) for at, (mine, true) in enumerate(pairs) if mine != true}


def test_every_arm_changes_the_reports_of_the_same_steps_and_nothing_else(asked):
    assert list(asked) == list(ARMS)
    hit = list(differing(asked, "lie"))
    assert len(hit) > 1
    for arm, request in asked.items():
        assert {**request, "messages": ()} == {**asked["truth"], "messages": ()}
        assert list(differing(asked, arm)) == ([] if arm == "truth" else hit)
        assert all(request["messages"][at]["role"] == "user" for at in hit)


def test_a_report_in_two_statements_is_both_with_one_word_between(asked):
    for at, (lie, truth) in differing(asked, "lie").items():
        for arm, said in {
            "truth-truth": f"{truth} Correction: {truth}",
            "lie-truth": f"{lie} Correction: {truth}",
            "truth-lie": f"{truth} Correction: {lie}",
            "lie-lie": f"{lie} Correction: {lie}",
        }.items():
            assert differing(asked, arm)[at] == (said, truth)
        remarked, _ = differing(asked, "remark")[at]
        assert remarked in [f"{truth} {aside}" for aside in ASIDES]


def test_no_message_names_the_arm(asked):
    for request in asked.values():
        assert NAMING.findall(json.dumps({**request, "response_format": ""}).lower()) == []
