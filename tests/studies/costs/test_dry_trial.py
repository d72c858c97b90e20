"""How large requests are, held against the conversations themselves."""

import json
from pathlib import Path

import pytest
from prefixes import repeated_prefix

from lockprobe.agents.llm.model_facts import ModelFacts
from lockprobe.agents.llm.settings import Model, ModelSettings
from lockprobe.agents.llm.token_bounds import at_most, tokens
from lockprobe.agents.prompt import conversation, reply_schema
from lockprobe.studies.costs.dry_trial import HYPOTHESIS, DryTrial, made_up_steps, reply
from lockprobe.studies.options.study_options import StudyOptions
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.running.single import run_trial
from lockprobe.testing import ScriptedProvider, joints, replying, words
from lockprobe.trial.record import Situation

CURT = Path(__file__).parents[2] / "interventions" / "curt.txt"

SPEC = "llm:openai-api/fake/model"


def model(images=0, **facts):
    return Model(name="openai-api/fake/model", settings=ModelSettings(images=images), facts=ModelFacts(**facts))


def requests(whole, images):
    """The conversations of a trial of 20 steps, one a step, from the situation of the last."""
    begun = [Situation(task=whole.task, past=whole.past[:n], percept=whole.past[n].percept) for n in range(19)]
    return [conversation(situation, images=images) for situation in (*begun, whole)]


@pytest.mark.parametrize(("size", "share", "images"), [("width=320&height=240", 0.25, 0), ("width=2048", 1, 2)])
def test_pictures_count_by_size_as_long_as_they_stay_in_the_conversation(images, size, share):
    plan = study(
        StudyOptions(
            study="modalities",
            agent=["llm:openai-api/fake/model"],
            modality=["rgb", "rgbd"],
            trials=1,
            plant=f"fast-twin?{size}",
        )
    )
    first, both = plan.plans(plan.agents[0])
    for shown, pictures in ((first, 1), (both, 2)):
        prompt = DryTrial.of(shown, model(images, picture_tokens=500))
        text = DryTrial.of(shown, model(images, picture_tokens=1))
        kept = images or 5
        assert prompt.input[4] - text.input[4] == pytest.approx(pictures * kept * 499 * share)


@pytest.mark.parametrize(("modality", "images"), [("symbolic", 0), ("rgb", 0), ("rgb", 3)])
def test_the_share_sent_before_is_that_of_the_conversations_themselves(modality, images):
    plan = study(StudyOptions(study="modalities", agent=[SPEC], modality=["symbolic", "rgb"], trials=1))
    (shown,) = (one for one in plan.plans(SPEC) if one.modality == modality)
    course = made_up_steps(shown)
    form = tokens(json.dumps(reply_schema(course[-1])))
    prompt = DryTrial.of(shown, model(images, picture_tokens=1600))  # our pictures are half as large as that
    share = (prompt.repeated[1:] - form).sum() / (prompt.input - form).sum()
    talks = [conversation(one, images=images) for one in course]
    assert share == pytest.approx(repeated_prefix(talks, picture_tokens=800), abs=0.02)


@pytest.mark.parametrize(("modality", "images"), [("symbolic", 0), ("rgbd", 0), ("rgbd", 3)])
def test_the_most_that_trials_can_take_bounds_every_request_of_theirs(modality, images):
    asks = model(images, picture_tokens=1600)
    plan = study(StudyOptions(study="modalities", agent=[SPEC], modality=["symbolic", "rgbd"], trials=1))
    (shown,) = (one for one in plan.plans(SPEC) if one.modality == modality)
    asked = [at_most(talk, asks) for talk in requests(made_up_steps(shown, reply("x" * 4000))[-1], images)]
    most = DryTrial.of(shown, asks)
    for step, one in enumerate(asked):
        assert one.input_tokens <= most.most_input[step] <= 1.05 * one.input_tokens
        assert one.output_tokens == most.most_output[step]


CONDITIONS = (
    "truth", "hypothesis?ask=off", "hypothesis?ask=after", "distract?p=1", "history?last=3", f"prompt?file={CURT} + warn",
)  # fmt: skip


@pytest.mark.parametrize("spec", CONDITIONS)
def test_requests_are_taken_to_be_as_large_as_those_that_are_sent(spec):
    """At every step, held against a provider that answers as the made-up trial does; labels are of equal length."""
    with ScriptedProvider(lambda request: replying(request, joints(request)[0], HYPOTHESIS)) as provider:
        trial = run_trial(agent=provider.agent, condition=spec, max_steps=12)
    assert trial.error is None
    planned = study("flips", agent=provider.agent, condition=spec, max_steps=12)
    prompt = DryTrial.of(planned.plan(provider.agent, planned.conditions[-1], 1, 1), model())
    sent = [sum(tokens(words(message)) + 4 for message in request["messages"]) for request in provider.requests]
    form = tokens(json.dumps(provider.requests[-1]["response_format"]["json_schema"]["schema"]))
    taken = (prompt.input - form)[: len(sent)]
    assert taken[0] == pytest.approx(sent[0], rel=0.05)
    assert sum(taken) == pytest.approx(sum(sent), rel=0.08)
    assert all(prompt.most_input[: len(sent)] > sent)


def test_the_most_counts_a_remark_at_every_step_however_rare_remarks_are():
    plan = study("flips", agent=SPEC, condition=["distract?p=0.001", "distract?p=1"])
    _, rare, always = (plan.plan(SPEC, condition, 1, 1) for condition in plan.conditions)
    most, all_steps = (DryTrial.of(one, model()) for one in (rare, always))
    assert most.most_input.tolist() == all_steps.most_input.tolist()


@pytest.mark.parametrize("condition", ["tremble?p=1", "force?at=3", "drop?p=0.5", "correction?p=0.4", "history?last=2"])
def test_the_made_up_trial_lasts_as_long_as_the_budget(condition):
    asked = StudyOptions(agent=[SPEC], condition=[condition], trials=1, repetitions=1, max_steps=50)
    assert {len(made_up_steps(plan)) for plan in study(asked).plans(SPEC)} == {50}


@pytest.mark.parametrize("spec", ["truth", "distract?p=1", "history?last=5"])
def test_of_a_long_trial_requests_lie_between_those_that_are_counted_and_below_their_bound(spec):
    plan = study("flips", agent=SPEC, condition=spec, max_steps=130).plan
    condition = study("flips", agent=SPEC, condition=spec, max_steps=130).conditions[-1]
    dry = DryTrial.of(plan(SPEC, condition, 1, 1), model())
    course = [conversation(one) for one in made_up_steps(plan(SPEC, condition, 1, 1))]
    sent = [sum(tokens(message.text) + 4 for message in talk) for talk in course]
    form = dry.input[0] - sent[0]
    assert list(dry.input - form) == pytest.approx(sent, rel=0.02)
    most = [at_most(talk, model()).input_tokens for talk in course]
    assert all(dry.most_input >= most)
    assert all(dry.most_input[1:] >= dry.most_input[:-1])
