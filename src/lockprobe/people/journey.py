"""The way of a participant through a study, and what diaries say of all of them, for records, reports and exports.

A participant sees the consent scene, instructions, questions on them, practice, checks, each box and the scene after
it, questions, and the debriefing.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, NamedTuple

from lockprobe.foundation.spec import PEOPLE
from lockprobe.people.diary import Attempt, Diary, Did, bad_diary
from lockprobe.people.experiment import Experiment
from lockprobe.people.texts import Words
from lockprobe.studies.records.store import STORE
from lockprobe.studies.study import Study
from lockprobe.trial.record import Trial


class Station(NamedTuple):
    """One scene in a participant's order of scenes.

    ``item`` is the number of a page or check, from 1, or the name of a question. ``box`` counts from 1; 0 is practice.
    """

    kind: Literal["page", "comprehension", "box", "over", "check", "ask", "debrief"]
    item: str = ""
    box: int = 0


def stations(experiment: Experiment, words: Words, boxes: int) -> tuple[Station, ...]:
    """All scenes of a participant who has agreed to take part and plays this many boxes, in order."""

    def through(box: int) -> Iterator[Station]:
        """A box, the scene after it, and the checks then."""
        if box or experiment.practice:
            yield Station("box", box=box)
            yield Station("over", box=box)
        for number, check in enumerate(experiment.checks, 1):
            if check.after == box:
                yield Station("check", str(number))

    return (
        *(Station("page", str(number)) for number in range(1, len(words.instructions) + 1)),
        *([Station("comprehension")] if asks_comprehension(experiment, words) else []),
        *(station for box in range(boxes + 1) for station in through(box)),
        *(Station("ask", question.name) for question in experiment.questions),
        Station("debrief"),
    )


def asks_comprehension(experiment: Experiment, words: Words) -> bool:
    """Whether questions follow the instructions."""
    asked = experiment.comprehension
    return asked.ask and bool(asked.questions or words.comprehension.questions)


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


@dataclass(frozen=True, slots=True, kw_only=True)
class Flow:
    """Everybody who agreed to take part in a study, for its report: dropout can bias every other number.

    Attributes:
        consented: Everybody who agreed: the sum of the next four.
        withdrawn: Participants who withdrew; nothing else is known of them.
        screened: Those whose session the limit of rounds of questions on the instructions ended, before any box.
        left_open: Those with open boxes: they left, or still take part.
        finished: Those with no open box.
        questioned: Those who answered questions on the instructions, screened-out ones among them.
        second_round: Those of them who needed a second round.
        checks: Attention checks answered.
        right: Those of them answered right.
        boxes: Condition -> boxes assigned when people joined, and those of them that are not over, in the order of the
            study; without those of people who were screened out before the first box.
    """

    consented: int
    withdrawn: int
    screened: int
    left_open: int
    finished: int
    questioned: int
    second_round: int
    checks: int
    right: int
    boxes: Mapping[str, tuple[int, int]]


def flow_of(study: Study, diaries: Iterable[Diary], gone: int) -> Flow | None:
    """How many participants reached the end; None where nobody has taken part. ``gone``: number of withdrawals."""
    people = list(diaries)
    if not people and not gone:
        return None
    playing = [one for one in people if one.shut != "screened"]
    boxes = [(slot.condition, box in one.endings) for one in playing for box, slot in enumerate(one.joined.slots, 1)]
    given, left = Counter(condition for condition, _ in boxes), Counter(one for one, over in boxes if not over)
    finished = sum(one.boxes_done for one in people)
    checks = [right for one in people for right in one.checks]
    return Flow(
        consented=len(people) + gone,
        withdrawn=gone,
        screened=len(people) - len(playing),
        left_open=len(playing) - finished,
        finished=finished,
        questioned=sum(len(one.rounds) > 0 for one in people),
        second_round=sum(len(one.rounds) > 1 for one in people),
        checks=len(checks),
        right=sum(checks),
        boxes={
            one.label: (given[one.label], left[one.label]) for one in study.conditions_of(PEOPLE) if given[one.label]
        },
    )
