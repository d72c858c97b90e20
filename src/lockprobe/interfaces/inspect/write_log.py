"""Writes trials of any agent as an Inspect log, without running an eval."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Mapping, Sequence
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path

from lockprobe.agents.llm.client import sent
from lockprobe.agents.llm.settings import ModelSettings
from lockprobe.agents.prompt import Message
from lockprobe.foundation.errors import BadValue, needing
from lockprobe.foundation.storage.atomic_file import atomic_files, writing
from lockprobe.foundation.storage.links import refuse_links
from lockprobe.interfaces.inspect.conversation import Exchange, exchanges_of, instruction, last_report
from lockprobe.interfaces.inspect.sample_pictures import beside
from lockprobe.interfaces.inspect.samples import SETTINGS, VERSION, VIEW, metadata_of, sample_id
from lockprobe.interfaces.inspect.scoring import SCORER, metrics_header, score_of, step_as_markdown, step_metadata
from lockprobe.studies.study import Study
from lockprobe.trial.model_call import Usage
from lockprobe.trial.record import Trial

with needing("Inspect logs", "providers"):
    from inspect_ai.event import Event, InfoEvent, ModelEvent
    from inspect_ai.log import (
        EvalConfig,
        EvalDataset,
        EvalLog,
        EvalPlan,
        EvalSample,
        EvalSpec,
        EvalStats,
        condense_sample,
        recompute_metrics,
        write_eval_log,
    )
    from inspect_ai.model import ChatCompletionChoice, ChatMessage, ChatMessageAssistant, ModelOutput, ModelUsage

__all__ = ["SUFFIXES", "log_of", "write_logs"]

SUFFIXES = (".eval", ".json")
"""Endings of log files; a JSON log is at least ten times as large."""


def write_logs(
    trials: Iterable[Trial],
    study: Study,
    out: Path,
    *,
    pictures: Path | None = None,
    seconds: Mapping[str, float] | None = None,
) -> list[Path]:
    """Write trials as Inspect logs, all of them or none, and return the files.

    Args:
        trials: The trials.
        study: The study of the trials.
        out: A file that ends in ``.eval`` or ``.json``, for one log of all agents; else a directory, created if
            missing, for one log per agent.
        pictures: Directory of the pictures that the records name; without it the logs have none.
        seconds: The duration of each trial, by key, if known.

    Raises:
        BadValue: If there is no trial.
        BadFile: If a file cannot be written, or is no regular file.
    """
    trials = list(trials)
    if not trials:
        raise BadValue("trials", 0, "at least one finished trial")
    groups = {out: trials}
    if out.suffix not in SUFFIXES:
        agents = list(dict.fromkeys(trial.group for trial in trials))
        groups = {
            out / f"{study.name}_{name}.eval": [trial for trial in trials if trial.group == agent]
            for agent, name in zip(agents, _file_names(agents), strict=True)
        }
    refuse_links(next(iter(groups)))
    with writing(out):
        next(iter(groups)).parent.mkdir(parents=True, exist_ok=True)
    with atomic_files(*groups) as drafts:
        for draft, group in zip(drafts, groups.values(), strict=True):
            log = log_of(group, study, pictures=pictures, seconds=seconds)
            if draft.suffix == ".json":  # Inspect does so by itself in the other kind only
                log.samples = [condense_sample(sample) for sample in log.samples or []]
            write_eval_log(log, draft)
    return list(groups)


def _file_names(agents: Sequence[str]) -> list[str]:
    """Unique file names for specs."""
    plain = ["".join(c if c.isalnum() or c in "-." else "-" for c in agent).strip("-.")[:80] for agent in agents]
    return [name if plain.count(name) == 1 else f"{name}-{plain[:i].count(name) + 1}" for i, name in enumerate(plain)]


def log_of(
    trials: Sequence[Trial],
    study: Study,
    *,
    pictures: Path | None = None,
    seconds: Mapping[str, float] | None = None,
) -> EvalLog:
    """Trials as a log: one sample each, with the scores and metrics of an eval of the same task.

    The arguments are those of :func:`write_logs`; at least one trial is needed.
    """
    agents = list(dict.fromkeys(trial.group for trial in trials))
    samples = [_sample(trial, pictures, (seconds or {}).get(trial.key)) for trial in trials]
    if len(agents) > 1:
        for sample, trial in zip(samples, trials, strict=True):
            sample.id = f"{trial.group}/{sample.id}"
            sample.metadata["condition"] = f"{trial.group}/{sample.metadata['condition']}"
    now = datetime.now(UTC).isoformat(timespec="seconds")
    identity = hashlib.sha256("\0".join([study.identity, *agents]).encode()).hexdigest()
    log = EvalLog(
        status="success",
        eval=EvalSpec.model_validate(
            {
                "eval_id": identity[:22],
                "run_id": identity[22:44],
                "task_id": identity[42:64],
                "created": now,
                "task": f"lockprobe/{study.name}",
                "task_display_name": study.name,
                "task_version": VERSION,
                "model": _model(trials[0]) if len(agents) == 1 else f"{len(agents)} agents",
                "dataset": EvalDataset(name=study.name, samples=len(samples), sample_ids=[s.id for s in samples]),
                "config": EvalConfig(epochs=1),
                "packages": {"lockprobe": version("lockprobe"), "inspect_ai": version("inspect_ai")},
                "metadata": {SETTINGS: study.settings(), "exported": True},
                "viewer": VIEW,
                "scorers": [{"name": SCORER, "metrics": metrics_header(study)}],
                "metrics": metrics_header(study),
            }
        ),
        plan=EvalPlan(),
        stats=EvalStats(started_at=now, completed_at=now, model_usage=_sum(samples)),
        samples=samples,
    )
    recompute_metrics(log)
    return log


def _sum(samples: Iterable[EvalSample]) -> dict[str, ModelUsage]:
    found: dict[str, ModelUsage] = {}
    for sample in samples:
        for name, usage in sample.model_usage.items():
            found[name] = found.get(name, ModelUsage()) + usage
    return found


def _sample(trial: Trial, pictures: Path | None, seconds: float | None) -> EvalSample:
    model = _model(trial)
    messages: list[ChatMessage] = []
    events: list[Event] = []
    output = ModelOutput(model=model)
    told = _Messages(trial)
    for exchange in exchanges_of(trial, pictures):
        asked, reply = told.asked(exchange), told.reply(exchange)
        messages += [asked[-1], reply]
        output = ModelOutput(model=model, choices=[ChatCompletionChoice(message=reply)])
        called = {"model": model, "input": asked, "tools": [], "tool_choice": "none", "config": {}, "output": output}
        events.append(ModelEvent.model_validate({**called, "working_start": 0}))
        if exchange.last and exchange.step <= len(trial.steps):
            step = trial.steps[exchange.step - 1]
            reply.metadata = step_metadata(step)
            events.append(InfoEvent(source="lockprobe", data=step_as_markdown(step), working_start=0))
    if trial.error is None:
        messages.append(told.message(last_report(trial, pictures), len(trial.steps) + 1, 1))
    return EvalSample(
        id=sample_id(trial),
        epoch=1,
        input=instruction(trial),
        target=dict(zip(trial.joints, trial.labels, strict=True))[trial.target],
        messages=messages,
        output=output,
        scores={SCORER: score_of(trial)},
        metadata=metadata_of(trial),
        store={} if pictures is None else dict(beside(trial, messages, pictures)),
        events=events,
        model_usage=_usage(trial),
        total_time=seconds,
        working_time=seconds,
    )


def _model(trial: Trial) -> str:
    return str(trial.facts.get("model") or trial.group)


class _Messages:
    """The messages of a trial: one object per message in all calls, with distinct metadata."""

    def __init__(self, trial: Trial) -> None:
        self._trial = trial
        self._made: dict[tuple[int, int, str, str, int], ChatMessage] = {}
        self._replies: dict[tuple[int, int], ChatMessageAssistant] = {}
        self._turns: dict[int, int] = {}

    def asked(self, exchange: Exchange) -> list[ChatMessage]:
        before = 2 * exchange.step - 1
        found: list[ChatMessage] = []
        for place, message in enumerate(exchange.asked):  # of the steps before it, one message each way
            step, turn = (place // 2 + 1, 1) if place < before else (exchange.step, (place - before + 1) // 2 + 1)
            if message.role == "assistant":
                found.append(self._replies[step, self._turns[step] if place < before else turn])
            else:
                found.append(self.message(message, step, turn))
        return found

    def reply(self, exchange: Exchange) -> ChatMessageAssistant:
        reply = ChatMessageAssistant(content=exchange.reply)
        self._mark(reply, exchange.step, exchange.turn)
        self._replies[exchange.step, exchange.turn] = reply
        self._turns[exchange.step] = exchange.turn
        return reply

    def message(self, message: Message, step: int, turn: int) -> ChatMessage:
        """A report as a message; without its pictures it is a different message."""
        name = (step, turn, message.role, message.text, len(message.pictures))
        if name not in self._made:
            made = self._made[name] = sent(message, ModelSettings())
            self._mark(made, step, turn)
            if any(known[:2] == name[:2] for known in self._made if known != name):
                made.id = f"{made.id}/without-pictures"
        return self._made[name]

    def _mark(self, message: ChatMessage, step: int, turn: int) -> None:
        message.id = f"{self._trial.key}/step={step}/turn={turn}/{message.role}"
        message.metadata = {"step": step} if turn == 1 else {"step": step, "turn": turn}


def _usage(trial: Trial) -> dict[str, ModelUsage]:
    spent = [step.decision.usage for step in trial.steps] + [trial.error.usage if trial.error else None]
    usage = sum((usage for usage in spent if usage), Usage())
    if not usage.calls:
        return {}
    cached = usage.cached_tokens + usage.stored_tokens
    counted = ModelUsage(
        input_tokens=usage.input_tokens - cached,
        output_tokens=usage.output_tokens,
        total_tokens=usage.input_tokens + usage.output_tokens,
        input_tokens_cache_read=usage.cached_tokens,
        input_tokens_cache_write=usage.stored_tokens,
        reasoning_tokens=usage.reasoning_tokens,
    )
    return {_model(trial): counted}
