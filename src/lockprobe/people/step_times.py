"""Response times: the diary entry behind each recorded step. Records have no clock, diaries do."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path

from lockprobe.people.diary import Diary, Did, bad_diary
from lockprobe.people.responses import Attempt
from lockprobe.studies.records.store import STORE
from lockprobe.studies.study import Study
from lockprobe.trial.record import Trial


def key_of(study: Study, diary: Diary, box: int | None) -> str:
    """The key of a participant's trial number ``box``, from 1; empty for the practice box."""
    if not box or box > len(diary.joined.slots):
        return ""
    return diary.joined.slots[box - 1].plan(study, diary.identity).key


def acts_of_steps(
    study: Study, trials: Mapping[str, Trial], diaries: Iterable[Diary], directory: Path
) -> dict[tuple[str, int], Did]:
    """The act behind each step of people's trials, by key of the trial and step from 1.

    ``directory`` is named in messages.

    Raises:
        BadFile: If a diary and a record disagree, or a diary belongs to another study.
    """
    found: dict[tuple[str, int], Did] = {}
    for diary in diaries:
        diary.check_slots(study, directory)
        for box in range(1, len(diary.joined.slots) + 1):
            trial = trials.get(key := key_of(study, diary, box))
            if trial is None or trial.agent != diary.spec:
                continue
            acts = {act.step: act for act in diary.attempts(box)}
            for step in trial.steps:
                act = acts.get(step.step)
                said = step.decision
                if act is None or not isinstance(act.act, Attempt):
                    why = f"step {step.step} of {key} is not in the diary"
                elif (act.act.joint, act.act.claimed) != (said.joint, said.claimed):
                    why = f"step {step.step} of {key} is {act.act.joint} in the diary, and {said.joint} on record"
                else:
                    found[key, step.step] = act
                    continue
                raise bad_diary(directory / STORE, diary.identity, why)
    return found


def seconds_of_trials(study: Study, diaries: Iterable[Diary]) -> dict[str, float]:
    """How long each finished box took its participant, from when it was shown to its last step, by its key."""
    found = {}
    for diary in diaries:
        for box in range(1, len(diary.joined.slots) + 1):
            steps = diary.attempts(box)
            if steps and steps[-1].ended:
                shown, last = diary.times(box)
                found[key_of(study, diary, box)] = round(last - shown, 3)
    return found
