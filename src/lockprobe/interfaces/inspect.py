"""A study as a task of Inspect AI: ``inspect eval lockprobe/study --model openai/gpt-4o -T p=0,0.4 -T trials=5``.

A sample is a trial, played by the usual loop with the model of the eval as its agent. Epochs are further repetitions.
Inspect AI imports this module whenever a model is opened, so what plays a study is imported with the first task.
"""

from __future__ import annotations

import io
import time
import zipfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lockprobe.foundation.errors import FINAL, BadFile, BadValue, kind_and_words, needing
from lockprobe.foundation.inputs import LARGEST_INPUT, read_input

with needing("Inspect tasks", "inspect"):
    from inspect_ai import Task, task
    from inspect_ai import model as models
    from inspect_ai.dataset import MemoryDataset, Sample
    from inspect_ai.scorer import Score, Scorer, Target, mean, scorer, stderr
    from inspect_ai.solver import Generate, Solver, TaskState, solver

if TYPE_CHECKING:
    import numpy as np

    from lockprobe.agents.prompt import Message
    from lockprobe.studies.study import Study
    from lockprobe.trial.model_call import Call
    from lockprobe.trial.record import Decision, Fact, Situation

_AGENT = "llm:inspect/model"  # stands for the model of the eval, which is unknown while a task is made

_RECORD = "trial"
"""The key of a trial's record in the store of its sample and in the metadata of its score."""


@task
def study(**options: Any) -> Task:
    """A study of an agent that solves a lockbox: flips, or that of ``-T study=NAME|FILE.toml``."""
    asked = {key: value for key, value in options.items() if value is not None}
    planned = _planned(asked)
    samples = [
        Sample(
            id=plan.key.split("/", 2)[2],
            input=f"The lockbox {plan.box.name} under {plan.label}.",
            metadata={"condition": plan.label, "repetition": plan.repetition, "trial": plan.trial},
        )
        for plan in planned.plans(_AGENT)
    ]
    return Task(
        dataset=MemoryDataset(samples, name=planned.name),
        solver=play_trial(asked),
        scorer=played(),
        continue_on_fail=True,  # one trial that a provider broke ends no other; eval-retry plays it again
    )


def _planned(asked: Mapping[str, Any]) -> Study:
    from lockprobe.studies.options.studyfile import study as study_of

    given = dict(asked)
    if isinstance(swept := given.get("sweep"), list):
        given["sweep"] = ",".join(map(str, swept))  # Inspect takes what has commas for a list
    planned = study_of(str(given.pop("study", "flips")), **given, agent=[_AGENT])
    if planned.until is not None:
        raise BadValue("until", str(planned.until), "none with Inspect, which plays all samples; `lockprobe run` stops")
    return planned


@solver
def play_trial(asked: dict[str, Any]) -> Solver:
    """Play the trial that a sample's metadata names, of the study with these options."""

    async def solve(state: TaskState, generate: Generate) -> TaskState:
        from lockprobe.studies.running.trial_setup import play_timed
        from lockprobe.trial.trial_json import trial_to_json

        planned, place = _planned(asked), state.metadata
        repetition = place["repetition"] + (state.epoch - 1) * planned.repetitions
        plan = planned.plan(_AGENT, planned.labelled(place["condition"]), repetition, place["trial"])
        player = _ModelOfTheEval(models.get_model(), state)
        trial, _ = await play_timed(plan, player)
        if trial.error is not None and trial.error.boundary not in FINAL:
            raise player.broke or RuntimeError(trial.error.message)
        state.store.set(_RECORD, trial_to_json(trial).decode())
        state.completed = True
        return state

    return solve


class _ModelOfTheEval:
    """The model of an eval as the agent of one trial; the conversation becomes the messages of its sample."""

    unseeded = True

    def __init__(self, model: models.Model, state: TaskState) -> None:
        self.broke: Exception | None = None
        self.facts: Mapping[str, Fact] = {"model": str(model)}
        self._model, self._state = model, state

    async def decide(self, situation: Situation, rng: np.random.Generator) -> Decision:
        from lockprobe.agents.llm.asking_again import decided
        from lockprobe.agents.llm.settings import Model
        from lockprobe.trial.model_call import Usage

        async def ask(new: Call, messages: Sequence[Message], schema: dict[str, object]) -> Call:
            asked, began = [_sent(message) for message in messages], time.perf_counter()
            output = await self._model.generate(asked)
            self._state.messages, self._state.output = [*asked, output.message], output
            read, written = (0, 0) if output.usage is None else (output.usage.input_tokens, output.usage.output_tokens)
            return replace(
                new,
                reply=output.completion,
                stop=output.stop_reason,
                served=output.model,
                usage=Usage(calls=1, input_tokens=read, output_tokens=written),
                seconds=time.perf_counter() - began,
            )

        try:
            return await decided(situation, Model(name=str(self._model)), ask)
        except Exception as error:
            self.broke = error  # so that the limits and retries of Inspect apply
            raise


def _sent(message: Message) -> models.ChatMessage:
    if message.role == "assistant":
        return models.ChatMessageAssistant(content=message.text)
    images: list[models.Content] = [
        models.ContentImage(image=f"data:image/png;base64,{one.base64}") for one in message.pictures
    ]
    return models.ChatMessageUser(content=[models.ContentText(text=message.text), *images] if images else message.text)


@scorer(metrics={value: [mean(), stderr()] for value in ("solved", "steps", "loops")})
def played() -> Scorer:
    """Whether the box opened, in how many steps (the whole budget if it did not), and whether the actions loop.

    A trial without a usable reply to its end is unscored: an error is no failure to solve.
    """

    async def score(state: TaskState, target: Target) -> Score:
        from lockprobe.statistics.loops import onset
        from lockprobe.trial.trial_json import trial_from_json

        if (line := state.store.get(_RECORD)) is None:
            return Score.unscored(reason="scoring_failed", explanation="the trial did not come to its end")
        trial, metadata = trial_from_json(str(line)), {_RECORD: str(line)}
        if trial.error is not None:
            return Score.unscored(reason=str(trial.error.boundary), explanation=trial.error.message, metadata=metadata)
        steps = len(trial.steps) if trial.solved else trial.budget
        value = {"solved": int(trial.solved), "steps": steps, "loops": int(onset(trial.actions) > 0)}
        answer = f"{'opened' if trial.solved else 'not opened'} in {len(trial.steps)} steps"
        return Score(value=value, answer=answer, metadata=metadata)

    return score


def logged_samples(path: Path) -> Iterator[dict[str, Any]]:
    """The samples of a log, as rows of episodes: model, task, arguments of the task, sample, epoch, score, actions.

    A sample that ended in an error has no score.

    Raises:
        BadFile: If it is no log, or is too large when it is unpacked.
    """
    from inspect_ai.log import read_eval_log
    from inspect_ai.scorer import value_to_float

    try:
        _refuse_large(path)
        log = read_eval_log(str(path), resolve_attachments=False)
    except Exception as error:  # noqa: BLE001  whatever a reader that is not ours makes of a file that is no log
        raise BadFile(path, f"not a log of Inspect ({kind_and_words(error)})") from None
    number, said = value_to_float(), " ".join(f"{name}={value}" for name, value in sorted(log.eval.task_args.items()))
    for sample in log.samples or ():
        messages = [message for message in sample.messages if message.role == "assistant"]
        score = next(iter((sample.scores or {}).values()), None)
        value = None if score is None else score.value
        value = next(iter(value.values()), None) if isinstance(value, Mapping) else value
        yield {
            "agent": log.eval.model,
            "condition": said or log.eval.task,
            "task": str(sample.id),
            "seed": str(sample.epoch),
            "score": None if value is None or sample.error else number(value),
            "steps": len(messages),
            "actions": [call.function for message in messages for call in message.tool_calls or ()],
        }


def _refuse_large(path: Path) -> None:
    """Refuse an archive by the bytes of all its files, which are counted, because what it declares may be a lie."""
    size = 0
    with zipfile.ZipFile(io.BytesIO(read_input(path))) as archive:
        for entry in archive.infolist():
            entry.file_size = 1 << 62
            with archive.open(entry) as file:
                while read := len(file.read(1 << 20)):
                    if (size := size + read) > LARGEST_INPUT:
                        raise ValueError(f"larger than {LARGEST_INPUT} bytes when it is unpacked")
