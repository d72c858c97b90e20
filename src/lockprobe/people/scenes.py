"""Scenes made of texts, and how they are answered: consent, instructions, questions, the end of a box, debriefing."""

from __future__ import annotations

import re
from typing import Literal

from lockprobe.foundation.errors import LockprobeError
from lockprobe.foundation.spec import PEOPLE
from lockprobe.people.box_view import Scene
from lockprobe.people.deceptions import deceptions
from lockprobe.people.diary import LONGEST_ANSWER, Act, Answer, Answers, Diary, Next
from lockprobe.people.experiment import ComprehensionQuestion, Experiment, Question
from lockprobe.people.journey import Station, asks_comprehension
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
    """Makes scenes of the texts, with the facts of the study filled in."""

    def __init__(self, words: Words, study: Study, experiment: Experiment) -> None:
        self._words, self._experiment, self._asks = words, experiment, study.assessment
        changes = " ".join(words.changes[kind] for kind in deceptions(study.conditions_of(PEOPLE)))
        self._facts = {"joints": len(study.box.joints), "budget": study.max_steps, "changes": changes}

    def consent(self, boxes: int) -> Scene:
        """The first scene; ``boxes`` is how many a participant would play. Nothing is stored before they agree."""
        return self._filled("consent", self._words.consent, boxes=boxes)

    def closed(self, why: Why) -> Scene:
        """The last scene of a participant who cannot go on. It admits false reports to those who leave early."""
        then = self._words.closed.false_reports if why in ("late", "withdrawn") and self._facts["changes"] else ()
        done = self._experiment
        way = {"taken": ("", ""), "finished": (done.completion_url, done.completion_code)}
        url, code = way.get(why, (done.left_url, done.left_code))
        scene = self._filled("closed", getattr(self._words.closed, why), *then)
        return scene | {"why": why, "completion_url": url, "completion_code": code}

    def at(self, station: Station, diary: Diary) -> Scene:
        """The scene of a participant outside a box. It never says which answer is right."""
        words, done, boxes = self._words, self._experiment, len(diary.joined.slots)
        match station.kind:
            case "page":
                return self._page(int(station.item), diary)
            case "comprehension":
                asked = tuple({"question": one.question, "options": one.options} for one in self._asked)
                notice = () if words.instructions else self._notice(diary)
                more = {"questions": asked, "notice": notice}
                return self._filled("comprehension", words.comprehension, boxes=boxes) | more
            case "over":
                return self._over(station.box, diary)
            case "check":
                check = done.checks[int(station.item) - 1]
                return {"kind": "check", "question": check.question, "options": check.options}
            case "ask":
                return {"kind": "ask", "longest": LONGEST_ANSWER, **self._question(station.item).model_dump()}
        admitted = words.debrief.false_reports if self._facts["changes"] else ()
        scene = self._filled("debrief", words.debrief, *admitted, boxes=boxes)
        return scene | {"completion_url": done.completion_url, "completion_code": done.completion_code}

    def answered(self, station: Station, act: Act) -> bool | None:
        """Whether an act answers a scene outside a box right; None where nothing is right or wrong.

        Raises:
            ActRefused: As ``impossible``, if it does not answer it.
        """
        kind, item = station.kind, station.item
        if kind in ("page", "over") and isinstance(act, Next):
            return None
        if kind == "comprehension" and isinstance(act, Answers):
            asked = self._asked
            if len(asked) == len(act.answers) and all(
                answer in one.options for one, answer in zip(asked, act.answers, strict=True)
            ):
                return not self._missed(act)
        if kind == "check" and isinstance(act, Answer):
            check = self._experiment.checks[int(item) - 1]
            if act.answer in check.options:
                return act.answer == check.right
        if kind == "ask" and isinstance(act, Answer) and fits(self._question(item), act.answer):
            return None
        raise ActRefused("impossible", f"nothing that can be done in a scene of kind {kind}")

    def _page(self, number: int, diary: Diary) -> Scene:
        """A page of the instructions. ``notice`` says why somebody is back; ``begins`` is whether a box comes next."""
        pages, text = self._words.instructions, self._words.instructions[number - 1]
        more = (*(text.if_false if self._experiment.say_false else ()), *(text.if_asked if self._asks else ()))
        return self._filled("page", text, *more, boxes=len(diary.joined.slots)) | {
            "number": number,
            "of": len(pages),
            "notice": self._notice(diary) if number == 1 else (),
            "begins": number == len(pages) and not asks_comprehension(self._experiment, self._words),
        }

    def _over(self, number: int, diary: Diary) -> Scene:
        """The scene after a box. It says whether the box was opened after practice, and where the study does."""
        of, over, ending = len(diary.joined.slots), self._words.over, diary.endings.get(number)
        solved = ending == "solved" if (self._experiment.feedback or not number) and ending != "error" else None
        own = over if number else self._words.practice_over
        said = () if solved is None else (over.solved if solved else over.unsolved,)
        then = () if number else own.paragraphs
        text = Longer(title=own.title, paragraphs=(*said, *then, *over.paragraphs))
        scene = self._filled("over", text, number=number, of=of, boxes=of)
        return scene | {"practice": not number, "number": number, "of": of, "solved": solved}

    def _question(self, name: str) -> Question:
        return next(one for one in self._experiment.questions if one.name == name)

    @property
    def _asked(self) -> tuple[ComprehensionQuestion, ...]:
        """The questions on the instructions."""
        questions = self._experiment.comprehension.questions or self._words.comprehension.questions
        return tuple(one for one in questions if one.only is None or self._experiment.say_false)

    def _missed(self, act: Answers) -> list[str]:
        """The questions that were answered wrong."""
        return [one.question for one, answer in zip(self._asked, act.answers, strict=True) if answer != one.right]

    def _notice(self, diary: Diary) -> tuple[str, ...]:
        """Why somebody is back at the instructions; nothing where they are not."""
        if diary.misread is None:
            return ()
        return (filled(self._words.comprehension.again, questions=" / ".join(self._missed(diary.misread))),)

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
