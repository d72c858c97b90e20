"""Reads trials from Inspect logs: logs of Lockprobe's tasks and exported logs.

A log is data from anyone: it is parsed with limits, every record is checked as a line of a journal is, and no code
runs from it.
"""

from __future__ import annotations

import json
import zipfile
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

from pydantic import ValidationError

from lockprobe.foundation.errors import BadFile, BadValue, needing
from lockprobe.foundation.inputs import check_regular
from lockprobe.interfaces.inspect.sample_pictures import pictures_of
from lockprobe.interfaces.inspect.samples import OPTIONS, SETTINGS
from lockprobe.interfaces.inspect.scoring import TRIAL
from lockprobe.interfaces.inspect.solver import agent_spec
from lockprobe.studies.options.settings import study_from
from lockprobe.studies.records.merge import MergeSource
from lockprobe.studies.study import Study
from lockprobe.trial.record import Trial
from lockprobe.trial.trial_json import trial_from_json
from lockprobe.trial.trial_name import TrialName

with needing("Inspect logs", "providers"):
    from inspect_ai.log import EvalLog, EvalSample, read_eval_log, read_eval_log_samples

__all__ = ["LARGEST", "LARGEST_MEMBER", "log_files", "read_log", "trials_in"]

LARGEST = 4 * 2**30
"""The most bytes of an unpacked log."""

LARGEST_MEMBER = 2**28
"""The most bytes of one unpacked sample."""

_MOST_SAMPLES = 100_000
"""The most samples that a header may list, over all epochs."""


def log_files(path: Path | str) -> list[Path]:
    """The logs in a directory and below it, in the order of their names; or the log at this path."""
    path = Path(path)
    return sorted(file for file in path.rglob("*.eval") if not file.name.startswith(".")) if path.is_dir() else [path]


def trials_in(path: Path | str) -> list[Trial]:
    """The finished trials of a log, or of all logs in a directory, each key once: the last one counts.

    Raises:
        BadFile: If a log cannot be read, holds no trials of ours, or a record that is damaged or impossible.
    """
    found: dict[str, Trial] = {}
    for file in log_files(path):
        found |= {trial.key: trial for trial in read_log(file).trials}
    return list(found.values())


def read_log(path: Path | str) -> MergeSource:
    """Read a log. Its epochs count as further repetitions of its study.

    Raises:
        BadFile: As :func:`trials_in`.
    """
    path = Path(path)
    check_regular(path)
    _check_size(path)
    trials: dict[str, Trial] = {}
    samples: dict[str, EvalSample] = {}
    seconds: dict[str, float] = {}
    pictures: dict[str, bytes] = {}
    broken: list[EvalSample] = []
    try:
        _check_json(path)
        header = read_eval_log(str(path), header_only=True)
        _settings(header, path)
        _check_number(header)
        samples_read = read_eval_log_samples(
            str(path), all_samples_required=False, resolve_attachments=True, exclude_fields={"events", "events_data"}
        )
        for sample in samples_read:
            if (line := _line(sample)) is None:
                broken.append(sample)
                continue
            trial = trial_from_json(line)
            trials[trial.key] = trial
            large: dict[str, object] = {"messages": [], "store": {}, "scores": None, "attachments": {}}
            samples[trial.key] = sample.model_copy(update=large)  # which saves memory
            if sample.total_time is not None:
                seconds[trial.key] = sample.total_time
            if wanted := trial.picture_names - pictures.keys():
                pictures |= {name: png for name, png in pictures_of(sample.messages, sample.store) if name in wanted}
        _check_held(header, len(samples) + len(broken))
    except BadFile:
        raise
    except BadValue as fault:
        raise BadFile(path, str(fault)) from None
    except Exception as fault:  # noqa: BLE001 - Inspect's readers of logs of all versions raise almost anything
        said = fault.errors()[0]["msg"] if isinstance(fault, ValidationError) else str(fault)
        raise BadFile(path, f"not a readable Inspect log ({said or type(fault).__name__})") from None
    study = _study(header, trials.values(), path)
    for key, sample in samples.items():
        if key != _key(sample, trials[key].group, study, header):
            raise BadFile(path, f"its sample {sample.id}, epoch {sample.epoch}, holds the record of {key}")
    return MergeSource(
        path=path,
        study=study,
        trials=tuple(trials.values()),
        unfinished=frozenset(_key(sample, study.labels[0], study, header) for sample in broken),
        seconds=seconds,
        from_log=frozenset(trials),
        picture=pictures.get,
    )


def _check_size(path: Path) -> None:
    """Refuse a file that unpacks to far more than the few megabytes of a log."""
    check_regular(path)
    try:
        size = path.stat().st_size
        if zipfile.is_zipfile(path):
            with zipfile.ZipFile(path) as packed:
                size = sum(member.file_size for member in packed.infolist())
    except Exception as fault:  # noqa: BLE001 - as in :func:`read_log`
        why = fault.strerror if isinstance(fault, OSError) and fault.strerror else str(fault)
        raise BadFile(path, f"cannot be read ({why})") from None
    if size > LARGEST:
        raise BadFile(path, f"{size} bytes unpacked; at most {LARGEST} are read")


def _check_json(path: Path) -> None:
    """Refuse invalid or deeply nested JSON and false sizes, on which Inspect's reader would hang."""
    if path.suffix == ".json":
        json.loads(path.read_bytes())
    elif zipfile.is_zipfile(path):
        with zipfile.ZipFile(path) as packed:
            for member in packed.infolist():
                if member.file_size > LARGEST_MEMBER:
                    raise BadValue(member.filename, member.file_size, f"at most {LARGEST_MEMBER} bytes unpacked")
                if member.filename.endswith(".json"):
                    json.loads(packed.read(member))


def _check_number(header: EvalLog) -> None:
    number = len(header.eval.dataset.sample_ids or ()) * (header.eval.config.epochs or 1)
    if number > _MOST_SAMPLES:
        raise BadValue("samples listed", number, f"at most {_MOST_SAMPLES}")


def _check_held(header: EvalLog, held: int) -> None:
    """Refuse a log without samples, unless its eval was interrupted."""
    if not held and header.status == "success":
        raise BadValue("samples", 0, f"the {len(header.eval.dataset.sample_ids or ())} that its header lists")


def _line(sample: EvalSample) -> str | None:
    """The record of a trial from the score that has one; an eval may have other scorers too."""
    for score in (sample.scores or {}).values():
        line = (score.metadata or {}).get(TRIAL)
        if isinstance(line, str):
            return line
    return None


def _study(log: EvalLog, trials: Iterable[Trial], path: Path) -> Study:
    settings = _settings(log, path)
    if not settings.get("agents"):  # a task does not know its model
        called = {trial.spec: trial.called for trial in trials}
        names = {spec: name for spec, name in called.items() if name}
        settings = {**settings, "agents": list(called) or [_agent(log)], **({"names": names} if names else {})}
    study = study_from(settings, path)
    return replace(study, repetitions=study.repetitions * (log.eval.config.epochs or 1))


def _settings(log: EvalLog, path: Path) -> dict[str, object]:
    """The study's settings in a log."""
    settings = (log.eval.metadata or {}).get(SETTINGS)
    if not isinstance(settings, dict):
        raise BadFile(path, "an Inspect log without trials of Lockprobe")
    return settings


def _agent(log: EvalLog) -> str:
    given = {name: log.eval.task_args.get(name) for name in OPTIONS}
    return agent_spec(log.eval.model, given, log.eval.model_generate_config)


def _key(sample: EvalSample, agent: str, study: Study, log: EvalLog) -> str:
    """The key of a sample's trial; empty if its metadata name none."""
    match sample.metadata:
        case {"label": str(label), "repetition": int(repetition), "trial": int(trial)}:
            each = study.repetitions // (log.eval.config.epochs or 1)
            repetition += (sample.epoch - 1) * each
            return str(TrialName(study=study.name, agent=agent, condition=label, repetition=repetition, trial=trial))
        case _:
            return ""
