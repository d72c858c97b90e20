"""Scenes made of texts, and how they are answered: consent, instructions, questions, the end of a box, debriefing."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import Literal

from lockprobe.boxes.families import box as named_box
from lockprobe.foundation.errors import LockprobeError
from lockprobe.foundation.spec import PEOPLE
from lockprobe.people.box_view import Scene
from lockprobe.people.deceptions import deceptions
from lockprobe.people.diary import LONGEST_ANSWER, Act, Answer, Answers, Next
from lockprobe.people.experiment import ComprehensionQuestion, Experiment, Question
from lockprobe.people.journey import Journey, asks_comprehension
from lockprobe.people.practice import Panels, true_modality
from lockprobe.people.texts import Longer, Words, filled
from lockprobe.studies.study import Study

Why = Literal["declined", "withdrawn", "full", "taken", "finished", "late", "screened"]
"""Why somebody cannot go on: ``full`` is no place left, ``taken`` and ``finished`` are the same platform ID in another
browser, ``late`` was away until somebody else needed the place, ``screened`` had too many rounds of wrong answers."""

_WRITTEN = {"number": re.compile(r"[+-]?[0-9]{1,15}([.,][0-9]{1,15})?"), "integer": re.compile(r"[+-]?[0-9]{1,15}")}


class ActRefused(LockprobeError):
    """A request cannot be done, and changes nothing. The message is for the log and the page: it repeats nothing sent.

    ``code`` is one of :data:`~lockprobe.people.web.app.STATUS`.
    """

    def __init__(self, code: str, message: str) -> None:
        super().__init__(message)
        self.code = code


class Scenes:
    """Makes scenes of the texts, with the facts of the study and an example box in each modality filled in."""

    def __init__(
        self, words: Words, study: Study, experiment: Experiment, examples: Mapping[str, Panels] | None = None
    ) -> None:
        self._words, self._experiment, self._examples = words, experiment, examples or {}
        self._modalities = {one.label: true_modality(one.modality) for one in study.conditions}
        self._asks = study.assessment
        boxes = [*study.boxes, *([named_box(experiment.practice)] if experiment.practice else [])]
        self._at_zero = not any(any(one.initial) for one in boxes)
        changes = " ".join(words.changes[kind] for kind in deceptions(study.conditions_of(PEOPLE)))
        self._facts = {"joints": len(study.box.joints), "budget": study.max_steps, "changes": changes}

    def consent(self, boxes: int, *, ask_code: bool = False) -> Scene:
        """The first scene; ``boxes`` is how many a participant would play. Nothing is stored before they agree."""
        return self._filled("consent", self._words.consent, boxes=boxes) | {"ask_code": ask_code}

    def closed(self, why: Why) -> Scene:
        """The last scene of a participant who cannot go on. It admits false reports to those who leave early."""
        then = self._words.closed.false_reports if why in ("late", "withdrawn") and self._facts["changes"] else ()
        done = self._experiment
        way = {"taken": ("", ""), "finished": (done.completion_url, done.completion_code)}
        url, code = way.get(why, (done.left_url, done.left_code))
        scene = self._filled("closed", getattr(self._words.closed, why), *then)
        return scene | {"why": why, "completion_url": url, "completion_code": code}

    def elsewhere(self, journey: Journey) -> Scene:
        """The scene of a person who takes part, or took part, in another browser: nothing but the way back."""
        return self.closed(journey.shut or ("finished" if journey.finished else "taken"))

    def at(self, journey: Journey) -> Scene:
        """The scene of a participant outside a box. It never says which answer is right."""
        station, words, done = journey.station, self._words, self._experiment
        boxes = len(journey.joined.slots)
        match station.kind:
            case "page":
                return self._page(int(station.item), journey)
            case "comprehension":
                asked = tuple({"question": one.question, "options": one.options} for one in self._asked(journey))
                notice = () if words.instructions else self._notice(journey)
                more = {"questions": asked, "notice": notice}
                return self._filled("comprehension", words.comprehension, boxes=boxes) | more
            case "over":
                return self._over(station.box, journey)
            case "check":
                check = done.checks[int(station.item) - 1]
                return {"kind": "check", "question": check.question, "options": check.options}
            case "ask":
                return {"kind": "ask", "longest": LONGEST_ANSWER, **self._question(station.item).model_dump()}
        admitted = words.debrief.false_reports if self._facts["changes"] else ()
        scene = self._filled("debrief", words.debrief, *admitted, boxes=boxes)
        return scene | {"completion_url": done.completion_url, "completion_code": done.completion_code}

    def answered(self, journey: Journey, act: Act) -> bool | None:
        """Whether an act answers the scene outside a box right; None where nothing is right or wrong.

        Raises:
            ActRefused: As ``impossible``, if it does not answer it.
        """
        kind, item = ("closed" if journey.shut else journey.station.kind), journey.station.item
        if kind in ("page", "over") and isinstance(act, Next):
            return None
        if kind == "comprehension" and isinstance(act, Answers):
            asked = self._asked(journey)
            if len(asked) == len(act.answers) and all(
                answer in one.options for one, answer in zip(asked, act.answers, strict=True)
            ):
                return not any(_missed(asked, act))
        if kind == "check" and isinstance(act, Answer):
            check = self._experiment.checks[int(item) - 1]
            if act.answer in check.options:
                return act.answer == check.right
        if kind == "ask" and isinstance(act, Answer) and fits(self._question(item), act.answer):
            return None
        raise ActRefused("impossible", f"nothing that can be done in a scene of kind {kind}")

    def _page(self, number: int, journey: Journey) -> Scene:
        """A page of the instructions. ``notice`` says why somebody is back; ``begins`` is whether a box comes next."""
        pages, say_false = self._words.instructions, self._experiment.say_false
        text, panels = pages[number - 1], self._panels(journey)
        told = [all(joint["position"] is not None for joint in before["joints"]) for before, _ in panels]
        at_zero = bool(told) and all(told) and self._at_zero  # how agents get to know it, too
        seen = bool(panels) and all(said or before["pictures"] for said, (before, _) in zip(told, panels, strict=True))
        more = (
            *(text.if_at_zero if at_zero else text.if_start_seen if seen else ()),
            *(text.if_false if say_false else ()),
            *((self._asks and text.if_asked) or ()),
        )
        example = text.example or ("box" if number == 1 and len(pages) > 1 else "step" if number <= 2 else "none")
        examples = {
            "box": tuple({"panel": before, "ask": False} for before, _ in panels),
            "step": tuple({"panel": after, "ask": self._asks} for _, after in panels),
            "none": (),
        }
        return self._filled("page", text, *more, boxes=len(journey.joined.slots)) | {
            "number": number,
            "of": len(pages),
            "examples": examples[example],
            "notice": self._notice(journey) if number == 1 else (),
            "begins": number == len(pages) and not asks_comprehension(self._experiment, self._words),
        }

    def _over(self, number: int, journey: Journey) -> Scene:
        """The scene after a box. It says whether the box was opened after practice, and where the study does."""
        of, over, ending = len(journey.joined.slots), self._words.over, journey.endings.get(number)
        solved = ending == "solved" if (self._experiment.feedback or not number) and ending != "error" else None
        own = over if number else self._words.practice_over
        said = () if solved is None else (over.solved if solved else over.unsolved,)
        then = () if number else own.paragraphs
        text = Longer(title=own.title, paragraphs=(*said, *then, *over.paragraphs))
        scene = self._filled("over", text, number=number, of=of, boxes=of)
        return scene | {"practice": not number, "number": number, "of": of, "solved": solved}

    def _question(self, name: str) -> Question:
        return next(one for one in self._experiment.questions if one.name == name)

    def _asked(self, journey: Journey) -> tuple[ComprehensionQuestion, ...]:
        """The questions on the instructions that a participant gets."""
        here = {None, *(["false_reports"] if self._experiment.say_false else [])}
        if all(joint["position"] is not None for before, _ in self._panels(journey) for joint in before["joints"]):
            here.add("positions")
        questions = self._experiment.comprehension.questions or self._words.comprehension.questions
        return tuple(one for one in questions if one.only in here)

    def _notice(self, journey: Journey) -> tuple[str, ...]:
        """Why somebody is back at the instructions; nothing where they are not."""
        if journey.misread is None:
            return ()
        wrong = " / ".join(_missed(self._asked(journey), journey.misread))
        return (filled(self._words.comprehension.again, questions=wrong),)

    def _panels(self, journey: Journey) -> tuple[Panels, ...]:
        """The examples in the modalities that the participant will see."""
        theirs = {self._modalities[slot.condition] for slot in journey.joined.slots}
        return tuple(panels for modality, panels in self._examples.items() if modality in theirs)

    def _filled(self, kind: str, text: Longer, *more: str, **facts: object) -> Scene:
        """A scene of a filled-in title and paragraphs."""
        known = {**self._facts, **facts}
        paragraphs = tuple(filled(part, **known) for part in (*text.paragraphs, *more))
        return {"kind": kind, "title": filled(text.title, **known), "paragraphs": paragraphs}


def fits(question: Question, given: str) -> bool:
    """Whether an answer is acceptable.

    >>> age = Question(name="age", question="How old are you?", type="integer", low=18, high=120)
    >>> [fits(age, answer) for answer in ("34", "banana", "7", "")]
    [True, False, False, True]
    """
    answer = given.strip()
    if not answer:
        return not question.required
    if question.options:
        return given in question.options
    if question.type == "text":
        return True
    if not _WRITTEN[question.type].fullmatch(answer):
        return False
    number, low, high = float(answer.replace(",", ".")), question.low, question.high
    return (low is None or low <= number) and (high is None or number <= high)


def _missed(asked: tuple[ComprehensionQuestion, ...], act: Answers) -> Iterator[str]:
    """The questions that were answered wrong."""
    return (one.question for one, answer in zip(asked, act.answers, strict=True) if answer != one.right)
