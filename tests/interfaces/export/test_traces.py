"""Traces follow OTLP, hold truth next to told, and are the same bytes each time."""

import base64
import json
from dataclasses import replace

import pytest
from builders import SOLUTION, make_trial, play_study, small_study

from lockprobe.interfaces.export.traces import requests
from lockprobe.trial.model_call import OWED_ANEW, Call, Usage

MODEL = "llm:openai/gpt-4o?temperature=0"


def spans_of(made):
    return [span for request in made for span in request["resourceSpans"][0]["scopeSpans"][0]["spans"]]


def facts(span):
    return {pair["key"]: next(iter(pair["value"].values())) for pair in span["attributes"]}


def a_call(key, step, **more):
    usage = Usage(calls=1, input_tokens=120, output_tokens=7)
    return replace(
        Call(key=key, step=step, turn=1, request="r", reply="A", served="gpt-4o-x", usage=usage, seconds=0.5), **more
    )


def test_truth_stands_next_to_told_by_hand():
    root, *steps = spans_of(requests([make_trial(SOLUTION, p=0.4, false_at=[2])], "study"))
    assert [facts(step)["lockprobe.truth.moved"] for step in steps] == [True] * 4
    assert [facts(step)["lockprobe.told.moved"] for step in steps] == [True, False, True, True]
    assert [facts(step)["lockprobe.truth.state_before"] for step in steps] == ["0000", "0001", "0011", "0111"]
    assert {step["parentSpanId"] for step in steps} == {root["spanId"]}
    assert (facts(root)["lockprobe.solved"], facts(root)["lockprobe.p"]) == (True, 0.4)


def test_model_calls_are_spans_of_their_step_with_tokens():
    trial = make_trial(SOLUTION, agent=MODEL)
    gone = a_call(trial.key, 1, served="earlier")
    anew = a_call(trial.key, 1, reply=None, error=OWED_ANEW)
    failed = a_call(trial.key, 2, reply=None, error="overloaded", usage=Usage())
    spans = spans_of(requests([trial], "study", [gone, anew, a_call(trial.key, 1), failed, a_call("other", 1)]))
    first, second = [span for span in spans if span["kind"] == 3]
    assert [span["parentSpanId"] for span in (first, second)] == [spans[1]["spanId"], spans[2]["spanId"]]
    found = facts(first)
    assert (found["gen_ai.provider.name"], found["gen_ai.request.model"]) == ("openai", "gpt-4o")
    assert (found["gen_ai.response.model"], found["gen_ai.usage.input_tokens"]) == ("gpt-4o-x", "120")
    assert second["status"] == {"code": 2, "message": "overloaded"}
    assert "gen_ai.usage.input_tokens" not in facts(second)


def test_ids_are_unique_and_the_same_each_time_and_of_this_study_alone():
    trials = play_study(small_study(trials=2))
    first, again, other = (spans_of(requests(trials, study)) for study in ("a", "a", "b"))
    assert json.dumps(first) == json.dumps(again)
    ids = [{span["spanId"] for span in spans} for spans in (first, other)]
    assert len(ids[0]) == len(first)
    assert not ids[0] & ids[1]
    assert len({span["traceId"] for span in first}) == len(trials)


def test_an_error_is_no_failure_to_solve():
    (root,) = spans_of(requests([make_trial([], broken="model")], "study"))
    assert root["status"]["code"] == 2
    assert "lockprobe.solved" not in facts(root)


def test_it_is_what_the_published_schema_describes():
    service = pytest.importorskip("opentelemetry.proto.collector.trace.v1.trace_service_pb2")
    json_format = pytest.importorskip("google.protobuf.json_format")
    trial = make_trial(SOLUTION, agent=MODEL, p=0.4, claims=[None, "moved"])
    (request,) = requests([trial], "study", [a_call(trial.key, 2)])
    for span in spans_of([request]):  # OTLP/JSON has ids in hexadecimal, protobuf's JSON in base64
        for name in {"traceId", "spanId", "parentSpanId"} & set(span):
            span[name] = base64.b64encode(bytes.fromhex(span[name])).decode()
    parsed = json_format.ParseDict(request, service.ExportTraceServiceRequest())
    spans = parsed.resource_spans[0].scope_spans[0].spans
    assert [(len(span.trace_id), len(span.span_id)) for span in spans] == [(16, 8)] * 6
    assert json_format.MessageToDict(parsed, use_integers_for_enums=True)["resourceSpans"] == request["resourceSpans"]
