"""Scenes that are made of texts: what stands before, between and after the boxes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal

from lockprobe.people.experiment import Experiment
from lockprobe.people.journey import Journey, Station
from lockprobe.people.scenes import Ask, Check, Closed, Consent, Debrief, Page, TrialOver
from lockprobe.people.words import Longer, Words, filled
from lockprobe.studies.study import Study

__all__ = ["Texts"]

Why = Literal["declined", "withdrawn", "full", "taken", "late"]


class Texts:
    """What is read, with the facts of the study filled in.

    Args:
        words: The texts.
        study: The study.
        experiment: How people take part.
    """

    def __init__(self, words: Words, study: Study, experiment: Experiment) -> None:
        self._words = words
        self._experiment = experiment
        self._are_false = any(study.p)
        self._facts = {"joints": len(study.box.joints), "budget": study.max_steps}

    def consent(self, boxes: int) -> Consent:
        """The first scene.

        Args:
            boxes: How many there would be.
        """
        title, paragraphs = self._filled(self._words.consent, {"boxes": boxes})
        return Consent(title=title, paragraphs=paragraphs)

    def closed(self, why: Why) -> Closed:
        """Nothing can be done. Who leaves early learns too that reports were false, where they were."""
        text: Longer = getattr(self._words.closed, why)
        then = self._words.closed.false_reports if why in ("late", "withdrawn") else ()
        title, paragraphs = self._filled(text, {}, then)
        return Closed(why=why, title=title, paragraphs=paragraphs)

    def at(self, journey: Journey) -> Page | TrialOver | Check | Ask | Debrief:
        """The scene in which somebody stands, if it is no box."""
        station, boxes = journey.station, len(journey.joined.slots)
        if station.kind == "page":
            number = int(station.item)
            title, paragraphs = self._filled(self._words.instructions[number - 1], {"boxes": boxes})
            return Page(title=title, paragraphs=paragraphs, number=number, of=len(self._words.instructions))
        if station.kind == "over":
            return self._over(journey, station)
        if station.kind == "check":
            check = self._experiment.checks[int(station.item) - 1]
            return Check(question=check.question, options=check.options)
        if station.kind == "ask":
            question = next(one for one in self._experiment.questions if one.name == station.item)
            return Ask(**question.model_dump())
        debrief = self._words.debrief
        title, paragraphs = self._filled(debrief, {"boxes": boxes}, debrief.false_reports)
        completion = self._experiment
        return Debrief(
            title=title,
            paragraphs=paragraphs,
            completion_url=completion.completion_url,
            completion_code=completion.completion_code,
        )

    def _over(self, journey: Journey, station: Station) -> TrialOver:
        """After a box; whether it was opened is said of the practice, else where the experimenter says so."""
        number, of, over = station.box, len(journey.joined.slots), self._words.over
        ending = journey.endings.get(number) if number else journey.practised
        said = not number or self._experiment.feedback
        solved = ending == "solved" if said and ending != "error" else None
        facts = {"number": number, "of": of, "boxes": of}
        title, paragraphs = self._filled(over if number else self._words.practice_over, facts)
        if solved is not None:
            paragraphs = (filled(over.solved if solved else over.unsolved, **self._facts, **facts), *paragraphs)
        return TrialOver(practice=not number, number=number, of=of, solved=solved, title=title, paragraphs=paragraphs)

    def _filled(
        self, text: Longer, facts: Mapping[str, object], of_false_reports: tuple[str, ...] = ()
    ) -> tuple[str, tuple[str, ...]]:
        """A title and what stands under it, with what is said only where reports are false at times."""
        known = {**self._facts, **facts}
        paragraphs = (*text.paragraphs, *(of_false_reports if self._are_false else ()))
        return filled(text.title, **known), tuple(filled(part, **known) for part in paragraphs)
