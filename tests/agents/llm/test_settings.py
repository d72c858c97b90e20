"""What is asked of a model is what it takes, bounded, and in the record, whether it is sent or left to the provider."""

import json

import pytest
from provider_server import here, truthful

from lockprobe.agents.catalogue import resolve
from lockprobe.agents.llm.model_facts import OWN_FACTS, ModelFacts, facts_of
from lockprobe.agents.llm.settings import MOST_PLAIN, MOST_REASONED, ModelSettings, read_settings
from lockprobe.foundation.errors import BadValue, UnknownName
from lockprobe.plants.catalogue import known_plants
from lockprobe.studies.options.study_options import StudyOptions
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.records.read_records import load
from lockprobe.studies.running.runner import run_study

UNKNOWN = ModelFacts()
PLAIN = ModelFacts(efforts=(), reasons=False, most_output=16_384)
REASONING = ModelFacts(sampling="fixed", efforts=("low", "high"), reasons=True, most_output=100_000)


@pytest.fixture(autouse=True)
def nothing_of_ones_own(monkeypatch):
    monkeypatch.delenv(OWN_FACTS, raising=False)


def test_nothing_is_sent_to_an_unknown_model_but_the_form_of_the_reply():
    assert ModelSettings().parameters(UNKNOWN) == {}
    assert ModelSettings().form(UNKNOWN) == "strict"
    assert ModelSettings().sent(UNKNOWN) == {
        "temperature": "provider default",
        "top_p": "provider default",
        "effort": "provider default",
        "max_tokens": "provider default",
        "schema": "strict",
        "repairs": 4,
    }


def test_what_is_set_is_sent_under_the_names_of_chat_completions():
    settings = ModelSettings(temperature=0.0, top_p=0.5, effort="low", max_tokens=77)
    sent = {"temperature": 0.0, "top_p": 0.5, "reasoning_effort": "low", "max_tokens": 77}
    assert settings.parameters(UNKNOWN) == sent
    assert (
        settings.sent(UNKNOWN).items() >= {"temperature": 0.0, "top_p": 0.5, "effort": "low", "max_tokens": 77}.items()
    )


def test_a_reply_of_a_known_model_is_bounded_by_what_it_writes():
    assert ModelSettings().parameters(PLAIN) == {"max_tokens": MOST_PLAIN}
    assert ModelSettings(effort="high").most_tokens(PLAIN) == 16_384
    assert ModelSettings().most_tokens(REASONING) == MOST_REASONED
    assert ModelSettings(effort="none").most_tokens(REASONING) == MOST_PLAIN
    assert ModelSettings(max_tokens=5).most_tokens(REASONING) == 5
    assert ModelSettings().most_tokens(UNKNOWN) is None


def test_the_record_says_what_a_model_fixes_and_does_not_take():
    assert ModelSettings().sent(REASONING) == {
        "temperature": "fixed by the model",
        "top_p": "fixed by the model",
        "effort": "provider default",
        "max_tokens": MOST_REASONED,
        "schema": "strict",
        "repairs": 4,
    }
    assert ModelSettings().sent(PLAIN)["effort"] == "not taken"
    assert ModelSettings().sent(ModelFacts(schema="loose"))["schema"] == "loose"
    assert ModelSettings(images=2, detail="low").sent(PLAIN).items() >= {"images": 2, "detail": "low"}.items()
    assert ModelSettings().sent(ModelFacts(images=True, largest_image=768))["largest_image"] == 768


@pytest.mark.parametrize(
    ("spec", "message"),
    [
        ("openai/o1?temperature=0", "temperature: got 0.0, expected no temperature with llm:openai/o1, which fixes it"),
        ("openai/o3?top_p=0.9", "top_p: got 0.9, expected no top_p with llm:openai/o3, which fixes it"),
        ("anthropic/claude-sonnet-4-5?temperature=1", "temperature: got 1.0, expected no temperature with"),
        (
            "openai/gpt-5.1?temperature=0&effort=low",
            "temperature: got 0.0, expected no temperature with llm:openai/gpt-5.1",
        ),
        (
            "openai/gpt-5.5?temperature=0",
            "temperature: got 0.0, expected no temperature with llm:openai/gpt-5.5 unless",
        ),
        ("openai/o3?effort=minimal", "effort: got 'minimal', expected one of low, medium, high with llm:openai/o3"),
        ("openai/gpt-4o?effort=low", "effort: got 'low', expected no effort with llm:openai/gpt-4o"),
        ("openai/gpt-4o?max_tokens=20000", "max_tokens: got 20000, expected at most 16384 with llm:openai/gpt-4o"),
        ("deepseek/deepseek-chat?schema=strict", "schema: got 'strict', expected loose or none with"),
        ("openai/o3-mini?images=4", "images or detail cannot be combined with llm:openai/o3-mini"),
    ],
)
def test_what_a_model_is_known_to_refuse_is_one_line_before_anything_is_played(spec, message):
    with pytest.raises(BadValue) as wrong:
        resolve(f"llm:{spec}")
    assert str(wrong.value).startswith(message)


@pytest.mark.parametrize(
    "spec",
    [
        "openai-api/mine/model?temperature=0&top_p=1&effort=max&max_tokens=999999&schema=strict&images=3&detail=low",
        "openai/gpt-4o?temperature=0.7&top_p=0.9&schema=loose&images=4",
        "openai/o1?effort=high&max_tokens=100000",
        "openai/gpt-5.1?temperature=0",
        "openai/gpt-5.5?temperature=0&effort=none",
        "openai/gpt-4o?schema=none",
    ],
)
def test_whatever_else_is_let_through(spec):
    assert resolve(f"llm:{spec}").engine == "network"


@pytest.mark.parametrize(
    ("options", "mistake", "message"),
    [
        ("heat=1", UnknownName, "no option of llm:a/b is called 'heat'"),
        ("temperature=warm", BadValue, "temperature: got 'warm', expected a number"),
        ("temperature=nan", BadValue, "temperature: got nan, expected a number from 0 to 2"),
        ("temperature=2.1", BadValue, "temperature: got 2.1, expected a number from 0 to 2"),
        ("top_p=0", BadValue, "top_p: got 0.0, expected a number above 0, at most 1"),
        ("max_tokens=0", BadValue, "max_tokens: got 0, expected a whole number from 1 to 10000000"),
        ("max_tokens=1.5", BadValue, "max_tokens: got '1.5', expected a whole number"),
        ("effort=huge", BadValue, "effort: got 'huge', expected one of none, minimal, low, medium, high, xhigh, max"),
        ("schema=hard", BadValue, "schema: got 'hard', expected one of strict, loose, none"),
        ("repairs=21", BadValue, "repairs: got 21, expected a whole number from 0 to 20"),
    ],
)
def test_a_value_that_cannot_be_is_one_line(options, mistake, message):
    with pytest.raises(mistake) as wrong:
        read_settings(f"a/b?{options}")
    assert str(wrong.value).startswith(message)


def test_a_model_known_to_be_blind_is_refused_where_there_are_only_pictures():
    assert "fast-twin" in known_plants()
    pictured = StudyOptions(study="modalities", plant="fast-twin", modality=["rgb"], agent=["llm:openai/o3-mini"])
    with pytest.raises(BadValue, match="symbolic too for llm:openai/o3-mini, which reads reports and looks at no pict"):
        study(pictured)
    assert study(pictured.model_copy(update={"agent": ["llm:openai/gpt-4o"]})).has_pictures
    assert study(pictured.model_copy(update={"agent": ["llm:ollama/llava"]})).has_pictures


def played(tmp_path, monkeypatch, spec, answer=truthful):
    """What was sent to a server, and the trial."""
    with here(answer, keep=True) as server:
        for provider in ("FAKE", "OPENAI"):
            monkeypatch.setenv(f"{provider}_BASE_URL", server.url)
            monkeypatch.setenv(f"{provider}_API_KEY", "sk-private-0123456789")
        run_study(study(StudyOptions(agent=[spec], p=[0], trials=1, repetitions=1)), tmp_path)
    (trial,) = load(tmp_path)
    assert trial.error is None
    return server.requests, trial


@pytest.mark.parametrize(("schema", "strict"), [("strict", True), ("loose", False)])
def test_what_is_set_arrives_and_is_in_the_record(tmp_path, monkeypatch, schema, strict):
    spec = f"llm:openai-api/fake/model?temperature=0.25&top_p=0.5&max_tokens=321&effort=low&schema={schema}"
    requests, trial = played(tmp_path, monkeypatch, spec)
    for request in requests:
        assert (request["temperature"], request["top_p"]) == (0.25, 0.5)
        assert (request["max_tokens"], request["reasoning_effort"]) == (321, "low")
        assert request["response_format"]["json_schema"]["strict"] is strict
    set_ = {"temperature": 0.25, "top_p": 0.5, "max_tokens": 321, "effort": "low", "schema": schema}
    assert trial.facts.items() >= set_.items()


def test_without_a_schema_the_form_is_asked_for_in_words_only(tmp_path, monkeypatch):
    requests, trial = played(tmp_path, monkeypatch, "llm:openai-api/fake/model?schema=none")
    for request in requests:
        assert "response_format" not in request
        assert not {"temperature", "top_p", "reasoning_effort"} & {*request}
    assert "Reply with one JSON object" in json.dumps(requests[0]["messages"])
    assert trial.facts["schema"] == "none"


def test_the_bound_of_a_known_model_arrives(tmp_path, monkeypatch):
    requests, trial = played(tmp_path, monkeypatch, "llm:openai/gpt-4o")
    assert {request.get("max_completion_tokens", request.get("max_tokens")) for request in requests} == {MOST_PLAIN}
    assert trial.facts["max_tokens"] == ModelSettings().most_tokens(facts_of("openai/gpt-4o")) == MOST_PLAIN


def responded(request):
    """A well-formed reply of a model that reasons."""
    status, body = truthful(request)
    usage = {
        "prompt_tokens": 100,
        "prompt_tokens_details": {"cached_tokens": 64},
        "completion_tokens": 30,
        "completion_tokens_details": {"reasoning_tokens": 20},
        "total_tokens": 130,
    }
    return status, body | {"usage": usage}


def test_a_model_that_reasons_gets_an_effort_and_room_and_no_temperature(tmp_path, monkeypatch):
    spec = "llm:openai/o1?effort=low"
    requests, trial = played(tmp_path, monkeypatch, spec, responded)
    for request in requests:
        assert not {"temperature", "top_p"} & {*request}
        assert (request["reasoning_effort"], request["max_completion_tokens"]) == ("low", MOST_REASONED)
        assert request["response_format"]["json_schema"]["strict"] is True
    fixed = {"temperature": "fixed by the model", "top_p": "fixed by the model"}
    assert trial.facts.items() >= (fixed | {"effort": "low", "max_tokens": MOST_REASONED}).items()
    for step in trial.steps:
        usage = step.decision.usage
        assert (usage.input_tokens, usage.cached_tokens) == (100, 64)
        assert (usage.output_tokens, usage.reasoning_tokens) == (30, 20)
