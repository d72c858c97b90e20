"""Trials as OpenTelemetry traces (OTLP/JSON): a trial is a trace, a step a span, a model call a span in its step."""

from __future__ import annotations

import hashlib
import json
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path

from lockprobe.foundation.spec import spec_name
from lockprobe.foundation.storage.atomic_file import atomic_file
from lockprobe.foundation.terminal_text import readable
from lockprobe.interfaces.export.span_times import Interval, TrialTimes, trial_times
from lockprobe.trial.model_call import Call
from lockprobe.trial.record import Step, Trial

__all__ = ["EPOCH", "Attribute", "requests", "write_traces"]

EPOCH = 946_684_800_000_000_000
"""The default start of the first trace: 2000-01-01T00:00:00Z, in nanoseconds since 1970."""

TRIALS_A_REQUEST = 50
"""The number of trials in one request, small enough for any receiver."""

_INTERNAL, _CLIENT, _ERROR = 1, 3, 2

Attribute = str | bool | int | float | None

_Json = dict[str, object]


def write_traces(
    trials: Sequence[Trial], path: Path, study: str, calls: Iterable[Call], seconds: Mapping[str, float], start: int
) -> list[Path]:
    """Write the traces as a file of OTLP/JSON lines, one ``ExportTraceServiceRequest`` a line, and return its path.

    The arguments are those of :func:`requests`.

    Raises:
        BadFile: If the file cannot be written, or is no regular file.
    """
    with atomic_file(path) as draft, draft.open("w", encoding="utf-8", newline="") as file:
        for request in requests(trials, study, calls, seconds, start):
            file.write(json.dumps(request, ensure_ascii=False, separators=(",", ":"), allow_nan=False) + "\n")
    return [path]


def requests(
    trials: Sequence[Trial],
    study: str,
    calls: Iterable[Call] = (),
    seconds: Mapping[str, float] | None = None,
    start: int = EPOCH,
) -> Iterator[_Json]:
    """The traces as OTLP/JSON requests (opentelemetry.proto.collector.trace.v1.ExportTraceServiceRequest).

    Ids are hashes of the study and of the trial's key, so that the same records give the same bytes.

    Args:
        trials: The trials, in order; each trace starts where the trace before it ends.
        study: What identifies the study, for example its task identity.
        calls: Calls to models; those of other trials are left out.
        seconds: Wall time of trials in seconds, by key, where it was read.
        start: When the first trace starts, in nanoseconds since 1970-01-01 UTC.
    """
    by_trial: defaultdict[str, list[Call]] = defaultdict(list)
    for call in calls:
        if call.owed_anew:
            by_trial.pop(call.key, None)
        else:
            by_trial[call.key].append(call)
    spans: list[_Json] = []
    for number, trial in enumerate(trials, start=1):
        its_calls = by_trial.get(trial.key, [])
        times = trial_times(trial, its_calls, (seconds or {}).get(trial.key), start)
        spans += _spans(trial, its_calls, times, study)
        start = times.trial.end
        if number % TRIALS_A_REQUEST == 0 or number == len(trials):
            resource = {"attributes": _pairs({"service.name": "lockprobe"})}
            scope = {"scope": {"name": "lockprobe"}, "spans": spans}
            yield {"resourceSpans": [{"resource": resource, "scopeSpans": [scope]}]}
            spans = []


def _spans(trial: Trial, calls: Sequence[Call], times: TrialTimes, study: str) -> Iterator[_Json]:
    trace = _identity(32, study, trial.key)
    root = _identity(16, study, trial.key, "trial")
    status: _Json = {"code": _ERROR, "message": readable(trial.error.message)} if trial.error else {}
    yield _span(
        trace,
        root,
        "",
        f"invoke_agent {trial.called or trial.agent}",
        times.trial,
        _of_trial(trial, times, study),
        status,
    )
    ids = {}
    for step, interval in zip(trial.steps, times.steps, strict=True):
        ids[step.step] = _identity(16, study, trial.key, "step", str(step.step))
        yield _span(trace, ids[step.step], root, f"execute_tool attempt {step.joint}", interval, _of_step(trial, step))
    for number, (call, interval) in enumerate(zip(calls, times.calls, strict=True), start=1):
        name = _identity(16, study, trial.key, "call", str(number))
        failed: _Json = {"code": _ERROR, "message": readable(call.error)} if call.reply is None else {}
        model = _model(trial.agent)[1]
        parent = ids.get(call.step, root)
        yield _span(trace, name, parent, f"chat {model}", interval, _of_call(trial, call), failed, kind=_CLIENT)


def _span(
    trace: str,
    name: str,
    parent: str,
    title: str,
    interval: Interval,
    attributes: Mapping[str, Attribute],
    status: _Json | None = None,
    kind: int = _INTERNAL,
) -> _Json:
    return {
        "traceId": trace,
        "spanId": name,
        **({"parentSpanId": parent} if parent else {}),
        "name": readable(title),
        "kind": kind,
        "startTimeUnixNano": str(interval.start),
        "endTimeUnixNano": str(interval.end),
        "attributes": _pairs(attributes),
        "status": status or {},
    }


def _of_trial(trial: Trial, times: TrialTimes, study: str) -> dict[str, Attribute]:
    return {
        "gen_ai.operation.name": "invoke_agent",
        "gen_ai.agent.name": trial.called or trial.agent,
        "gen_ai.conversation.id": trial.key,
        "error.type": trial.error.boundary if trial.error else None,
        "lockprobe.study": study,
        "lockprobe.key": trial.key,
        "lockprobe.box": trial.box,
        "lockprobe.modality": trial.modality,
        "lockprobe.condition": trial.condition,
        "lockprobe.p": trial.p,
        "lockprobe.repetition": trial.repetition,
        "lockprobe.trial": trial.trial,
        "lockprobe.budget": trial.budget,
        "lockprobe.steps": len(trial.steps),
        "lockprobe.target": trial.target,
        "lockprobe.ending": trial.ending,
        "lockprobe.solved": None if trial.error else trial.solved,
        "lockprobe.clock": times.clock,
    }


def _of_step(trial: Trial, step: Step) -> dict[str, Attribute]:
    return {
        "gen_ai.operation.name": "execute_tool",
        "gen_ai.tool.name": "attempt",
        "gen_ai.tool.type": "function",
        "gen_ai.tool.call.arguments": json.dumps({"joint": step.joint}, ensure_ascii=False),
        "gen_ai.tool.call.result": step.told or None,
        "lockprobe.step": step.step,
        "lockprobe.joint": step.joint,
        "lockprobe.chosen": step.chosen,
        "lockprobe.truth.state_before": step.state,
        "lockprobe.truth.moved": step.moved,
        "lockprobe.told.moved": step.told_moved,
        "lockprobe.told.state_after": step.told_state,
        "lockprobe.told.false": None if step.told_moved is None else step.told_moved != step.moved,
        "lockprobe.claimed": step.decision.claimed,
        "lockprobe.confidence": step.decision.confidence,
        "lockprobe.report_false": step.decision.report_false,
        "lockprobe.hypothesis": step.decision.hypothesis or None,
        "lockprobe.target": step.moved and step.joint == trial.target,
    }


def _of_call(trial: Trial, call: Call) -> dict[str, Attribute]:
    provider, model = _model(trial.agent)
    counted = call.usage.input_tokens or call.usage.output_tokens
    return {
        "gen_ai.operation.name": "chat",
        "gen_ai.provider.name": provider,
        "gen_ai.request.model": model,
        "gen_ai.response.model": call.served or None,
        "gen_ai.usage.input_tokens": call.usage.input_tokens if counted else None,
        "gen_ai.usage.output_tokens": call.usage.output_tokens if counted else None,
        "gen_ai.usage.cache_read.input_tokens": call.usage.cached_tokens or None,
        "gen_ai.conversation.id": trial.key,
        "error.type": "model" if call.reply is None else None,
        "lockprobe.step": call.step,
        "lockprobe.turn": call.turn,
        "lockprobe.retries": call.retries,
        "lockprobe.stop": call.stop or None,
        "lockprobe.reply": call.reply,
    }


def _model(agent: str) -> tuple[str, str]:
    full = spec_name(agent).removeprefix("llm:")
    provider, slash, model = full.partition("/")
    return (provider, model) if slash else ("lockprobe", full)


def _pairs(attributes: Mapping[str, Attribute]) -> list[_Json]:
    return [{"key": name, "value": _value(value)} for name, value in attributes.items() if value is not None]


def _value(value: str | bool | float) -> _Json:
    if isinstance(value, bool):
        return {"boolValue": value}
    if isinstance(value, int):
        return {"intValue": str(value)}
    if isinstance(value, float):
        return {"doubleValue": value}
    return {"stringValue": readable(value)}


def _identity(digits: int, *parts: str) -> str:
    return hashlib.sha256(json.dumps(parts).encode()).hexdigest()[:digits]
