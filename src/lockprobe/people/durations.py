"""How long the people who finished a study took, for the consent scene of the next one."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from math import ceil, floor
from statistics import median

from lockprobe.people.diary import Diary
from lockprobe.people.experiment import Experiment
from lockprobe.people.journey import Journey
from lockprobe.people.responses import Answer

__all__ = ["Durations", "durations_of", "has_finished", "seconds_of"]

_MINUTE = 60.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Durations:
    """Durations of ``people`` from consent to their last act, in minutes: the median, the shortest, the longest.

    The median is rounded to the nearest minute, the shortest down and the longest up; none is below 1.
    """

    people: int
    median: int
    low: int
    high: int

    @property
    def setting(self) -> str:
        """The line for ``people.toml``."""
        return f"minutes = {{ median = {self.median}, low = {self.low}, high = {self.high} }}"


def durations_of(diaries: Iterable[Diary], experiment: Experiment | None) -> Durations | None:
    """How long it took those who finished; None where nobody has.

    Whoever paused is counted with the pause. ``experiment`` is None where the settings are not stored.
    """
    minutes = [seconds_of(diary) / _MINUTE for diary in diaries if has_finished(diary, experiment)]
    if not minutes:
        return None
    return Durations(
        people=len(minutes),
        median=max(1, round(median(minutes))),
        low=max(1, floor(min(minutes))),
        high=max(1, ceil(max(minutes))),
    )


def seconds_of(diary: Diary) -> float:
    """The time from consent to the participant's last act, by the clock of the server."""
    return max((act.at for act in diary.acts), default=diary.joined.at) - diary.joined.at


def has_finished(diary: Diary, experiment: Experiment | None) -> bool:
    """Whether a participant has reached the end: every box is over and every question was asked."""
    answered = {(did.scene, did.item) for did in diary.acts if isinstance(did.act, Answer)}
    journey = Journey.of(diary)
    return journey.boxes_done and not journey.released and _asked(diary, experiment) <= answered


def _asked(diary: Diary, experiment: Experiment | None) -> set[tuple[str, str]]:
    """The checks and questions for a participant, if the settings are stored."""
    if experiment is None:
        return set()
    boxes = len(diary.joined.slots)
    checks = {("check", str(number)) for number, check in enumerate(experiment.checks, 1) if check.after <= boxes}
    return checks | {("ask", question.name) for question in experiment.questions}
