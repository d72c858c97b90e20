"""Scenes made of texts: consent, instructions, questions on them, checks, questions at the end, debriefing."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Literal

from lockprobe.boxes.families import box as named_box
from lockprobe.foundation.spec import PEOPLE
from lockprobe.people.deceptions import deceptions
from lockprobe.people.diary import Joined
from lockprobe.people.experiment import Experiment
from lockprobe.people.journey import Journey, Station, asks_comprehension
from lockprobe.people.practice import ExamplePanels, true_modality
from lockprobe.people.right_answers import ComprehensionQuestion, missed
from lockprobe.people.scenes import (
    Ask,
    Check,
    Closed,
    ComprehensionQuestions,
    Consent,
    Debrief,
    Example,
    InstructionPage,
    OpenQuestion,
    TrialOver,
)
from lockprobe.people.texts import Longer, Words, example_on, filled
from lockprobe.studies.study import Study

Why = Literal["declined", "withdrawn", "full", "taken", "late", "screened"]


class TextScenes:
    """Makes scenes of the texts, with the facts of the study and an example box in each modality filled in."""

    def __init__(
        self, words: Words, study: Study, experiment: Experiment, examples: Mapping[str, ExamplePanels] | None = None
    ) -> None:
        self._words = words
        self._experiment = experiment
        self._modalities = {one.label: true_modality(one.modality) for one in study.conditions}
        self._asks = study.assessment
        boxes = [*study.boxes, *([named_box(experiment.practice)] if experiment.practice else [])]
        self._at_zero = not any(any(one.initial) for one in boxes)
        self._examples = examples or {}
        self._changes = " ".join(getattr(words.changes, kind) for kind in deceptions(study.conditions_of(PEOPLE)))
        self._facts = {"joints": len(study.box.joints), "budget": study.max_steps, "changes": self._changes}

    def consent(self, boxes: int, *, ask_code: bool = False) -> Consent:
        """The first scene; ``boxes`` is how many a participant would play."""
        return Consent(**self._filled(self._words.consent, {"boxes": boxes}), ask_code=ask_code)

    def closed(self, why: Why) -> Closed:
        """The last scene of a participant who cannot go on. It admits false reports to those who leave early."""
        then = self._words.closed.false_reports if why in ("late", "withdrawn") else ()
        back = self._experiment
        way: dict[str, Any] = {"completion_url": back.left_url, "completion_code": back.left_code}
        way = {} if why == "taken" else way
        return Closed(why=why, **self._filled(getattr(self._words.closed, why), {}, then), **way)

    def elsewhere(self, journey: Journey) -> Closed:
        """The scene of a person who takes part, or took part, in another browser: nothing but the way back."""
        if journey.shut or not journey.finished:
            return self.closed(journey.shut or "taken")
        return Closed(why="finished", **self._filled(self._words.closed.finished, {}), **self._way_back)

    @property
    def _way_back(self) -> dict[str, Any]:
        done = self._experiment
        return {"completion_url": done.completion_url, "completion_code": done.completion_code}

    def at(self, journey: Journey) -> InstructionPage | ComprehensionQuestions | TrialOver | Check | Ask | Debrief:
        """The scene of a participant outside a box."""
        station, words = journey.station, self._words
        facts = {"boxes": len(journey.joined.slots)}
        if station.kind == "page":
            number, of = int(station.item), len(words.instructions)
            text, start = words.instructions[number - 1], self._start(journey.joined)
            more = (
                *(text.if_at_zero if start == "at zero" else ()),
                *(text.if_start_seen if start == "seen" else ()),
                *(text.if_false if self._experiment.say_false else ()),
                *((self._asks and text.if_asked) or ()),
            )
            return InstructionPage(
                **self._filled(text, facts, more=more),
                number=number,
                of=of,
                examples=self._shown(number, journey.joined),
                notice=self._notice(journey) if number == 1 else (),
                begins=number == of and not asks_comprehension(self._experiment, words),
            )
        if station.kind == "comprehension":
            asked = self.comprehension(journey.joined)
            return ComprehensionQuestions(
                **self._filled(words.comprehension, facts),
                questions=tuple(OpenQuestion(question=one.question, options=one.options) for one in asked),
                notice=() if words.instructions else self._notice(journey),
            )
        if station.kind == "over":
            return self._over(journey, station)
        if station.kind == "check":
            check = self._experiment.checks[int(station.item) - 1]
            return Check(question=check.question, options=check.options)
        if station.kind == "ask":
            question = next(one for one in self._experiment.questions if one.name == station.item)
            return Ask(**question.model_dump())
        return Debrief(**self._filled(words.debrief, facts, words.debrief.false_reports), **self._way_back)

    def comprehension(self, joined: Joined) -> tuple[ComprehensionQuestion, ...]:
        """The questions on the instructions that a participant gets."""
        here = {None, *(["false_reports"] if self._experiment.say_false else [])}
        if all(joint.position is not None for shown in self._examples_of(joined) for joint in shown.before.joints):
            here.add("positions")
        questions = self._experiment.comprehension.questions or self._words.comprehension.questions
        return tuple(one for one in questions if one.only in here)

    def _start(self, joined: Joined) -> Literal["at zero", "seen", "unknown"]:
        """How a participant gets to know where joints are at the start, as agents do: ``at zero``, or as it is seen."""
        panels = [shown.before for shown in self._examples_of(joined)]
        told = [all(joint.position is not None for joint in panel.joints) for panel in panels]
        if panels and all(told) and self._at_zero:
            return "at zero"
        seen = panels and all(tells or panel.pictures for tells, panel in zip(told, panels, strict=True))
        return "seen" if seen else "unknown"

    def _notice(self, journey: Journey) -> tuple[str, ...]:
        """Why somebody is back at the instructions; nothing where they are not."""
        if journey.misread is None:
            return ()
        wrong = missed(self.comprehension(journey.joined), journey.misread.answers)
        return (filled(self._words.comprehension.again, questions=" / ".join(wrong)),)

    def _examples_of(self, joined: Joined) -> tuple[ExamplePanels, ...]:
        theirs = {self._modalities[slot.condition] for slot in joined.slots}
        return tuple(shown for modality, shown in self._examples.items() if modality in theirs)

    def _shown(self, number: int, joined: Joined) -> tuple[Example, ...]:
        """The examples on a page of the instructions, in the modalities that the participant will see."""
        what = example_on(self._words, number)
        found = self._examples_of(joined)
        if what == "box":
            return tuple(Example(panel=shown.before) for shown in found)
        return tuple(Example(panel=shown.after, ask=self._asks) for shown in found) if what == "step" else ()

    def _over(self, journey: Journey, station: Station) -> TrialOver:
        """The scene after a box. It says whether the box was opened after practice, and where the study does."""
        number, of, over = station.box, len(journey.joined.slots), self._words.over
        ending = journey.endings.get(number) if number else journey.practised
        solved = ending == "solved" if (self._experiment.feedback or not number) and ending != "error" else None
        facts = {"number": number, "of": of, "boxes": of}
        own = self._words.practice_over
        said = () if solved is None else (over.solved if solved else over.unsolved,)
        text = Longer(
            title=over.title if number else own.title,
            paragraphs=(*said, *(() if number else own.paragraphs), *over.paragraphs),
        )
        return TrialOver(**self._filled(text, facts), practice=not number, number=number, of=of, solved=solved)

    def _filled(
        self,
        text: Longer,
        facts: Mapping[str, object],
        of_false_reports: tuple[str, ...] = (),
        more: tuple[str, ...] = (),
    ) -> dict[str, Any]:
        """A filled-in title and its paragraphs; ``of_false_reports`` only in studies with false reports."""
        known = {**self._facts, **facts}
        paragraphs = (*text.paragraphs, *more, *(of_false_reports if self._changes else ()))
        return {"title": filled(text.title, **known), "paragraphs": tuple(filled(part, **known) for part in paragraphs)}
