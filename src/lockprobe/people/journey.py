"""What diaries say of all participants, for records, reports and exports."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from lockprobe.foundation.spec import PEOPLE
from lockprobe.people.diary import Attempt, Diary, Did, bad_diary
from lockprobe.studies.records.store import STORE
from lockprobe.studies.study import Study
from lockprobe.trial.record import Trial


def acts_of_steps(
    study: Study, trials: Mapping[str, Trial], diaries: Iterable[Diary], directory: Path
) -> dict[tuple[str, int], Did]:
    """The act behind each step of people's trials, by key of the trial and step from 1: records have no clock.

    ``directory`` is named in messages.

    Raises:
        BadFile: If a diary and a record disagree, or a diary belongs to another study.
    """
    found: dict[tuple[str, int], Did] = {}
    for diary in diaries:
        diary.check_slots(study, directory)
        for box, acts in diary.steps.items():
            trial = trials.get(key := diary.key(study, box))
            if trial is None or trial.agent != diary.spec:
                continue
            chosen = [(one.joint, one.claimed) for did in acts if isinstance(one := did.act, Attempt)]
            played = [(step.decision.joint, step.decision.claimed) for step in trial.steps]
            if chosen[: len(played)] != played:  # the attempt that broke a box is in the diary alone
                raise bad_diary(directory / STORE, diary.identity, f"the steps of {key} are not those on record")
            found.update(((key, step.step), did) for step, did in zip(trial.steps, acts, strict=False))
    return found


def seconds_of_trials(study: Study, diaries: Iterable[Diary]) -> dict[str, float]:
    """How long each finished box took its participant, from when it was shown to its last step, by its key."""
    return {
        diary.key(study, box): round(diary.seconds(box), 3)
        for diary in diaries
        for box, steps in diary.steps.items()
        if box and steps[-1].ended
    }


def flow_of(diaries: Sequence[Diary], gone: int) -> dict[str, int]:
    """How far participants came, for a report: dropout can bias every other number. Empty where nobody took part.

    Everybody who ``consented`` has ``withdrawn`` (``gone``; nothing else is known of them), was ``screened`` out by the
    limit of rounds of questions on the instructions, has ``left_open`` boxes (and may still take part), or
    ``finished`` all. ``questioned`` are those who answered these questions, ``second_round`` those who had to again.
    ``checks`` are answers to attention checks, ``right`` those of them that are right.
    """
    if not diaries and not gone:
        return {}
    screened, finished = (sum(one.shut == "screened" for one in diaries), sum(one.boxes_done for one in diaries))
    checks = [right for one in diaries for right in one.checks]
    return {
        "consented": len(diaries) + gone,
        "withdrawn": gone,
        "screened": screened,
        "left_open": len(diaries) - screened - finished,
        "finished": finished,
        "questioned": sum(len(one.rounds) > 0 for one in diaries),
        "second_round": sum(len(one.rounds) > 1 for one in diaries),
        "checks": len(checks),
        "right": sum(checks),
    }


def boxes_of(study: Study, diaries: Sequence[Diary]) -> dict[str, tuple[int, int]]:
    """Condition -> boxes that people were given, and those of them that are not over, in the order of the study.

    Without those of people who were screened out before the first box.
    """
    playing = [one for one in diaries if one.shut != "screened"]
    boxes = [(slot.condition, box in one.endings) for one in playing for box, slot in enumerate(one.joined.slots, 1)]
    given, left = Counter(condition for condition, _ in boxes), Counter(one for one, over in boxes if not over)
    labels = [one.label for one in study.conditions_of(PEOPLE)]
    return {label: (given[label], left[label]) for label in labels if given[label]}
