"""What participants see, in which order, and what answers it: texts, questions, and boxes as they were told.

A box is made of the situation that every agent gets and of the layout of the panel. Nothing here knows the truth:
positions and outcomes are the reported ones, joints have their labels. The interlock, how often reports are false, the
condition, the number of the trial, and which answer is right are nowhere in a scene. Only an end says what a study did.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any, Literal, NamedTuple, get_args

from lockprobe.foundation.errors import LockprobeError
from lockprobe.foundation.spec import PEOPLE
from lockprobe.interventions.modality import is_pictured, shown
from lockprobe.interventions.words import TextChannel
from lockprobe.people.diary import LONGEST_ANSWER, Act, Answers, Diary
from lockprobe.people.experiment import Experiment, Longer, OneRight, Question, Words, filled
from lockprobe.studies.study import Study
from lockprobe.trial.condition import Condition
from lockprobe.trial.plan import Plan
from lockprobe.trial.record import Percept, Situation, Task

Scene = dict[str, Any]
"""What the page shows, as it is sent; ``kind`` says which scene it is."""

Why = Literal["declined", "withdrawn", "full", "taken", "finished", "late"]
"""Why somebody cannot go on: ``full`` is no place left, ``taken`` and ``finished`` are the same platform ID in another
browser, ``late`` was away until somebody else needed the place."""

Deception = Literal["false", "late", "another", "warned", "changed"]
"""What is told or shown is false, or late; another joint than the chosen one is attempted; reports that are true are
said to be perhaps false; or something is changed, nobody knows how, by an intervention of another package."""

_KINDS: dict[str, Deception | None] = {
    "flip": "false",
    "phantom": "false",
    "correction": "false",
    "delay": "late",
    "tremble": "another",
    "warn": "warned",
    **dict.fromkeys(("drop", "nudge", "remark", "distract")),
}
"""What an intervention does. None leaves something out, or says something beside."""


class ActRefused(LockprobeError):
    """A request cannot be done, and changes nothing. The message is for the log and the page: it repeats nothing sent.

    ``code`` is one of :data:`~lockprobe.people.web.app.STATUS`.
    """

    def __init__(self, code: str, message: str) -> None:
        super().__init__(message)
        self.code = code


class Station(NamedTuple):
    """One scene in a participant's order of scenes.

    ``item`` is the number of a page or check, from 1, or the name of a question. ``box`` counts from 1; 0 is practice.
    """

    kind: Literal["page", "comprehension", "box", "over", "check", "ask", "debrief"]
    item: str = ""
    box: int = 0
    asked: tuple[Question, ...] = ()


def view_of(modality: str) -> Literal["panel", "pictures"]:
    """The view of a modality: pictures where it has them, else the drawn panel."""
    return "pictures" if is_pictured(modality) else "panel"


def is_asked(situation: Situation) -> bool:
    """Whether the participant has to say what the last action did; models cannot either where no action is named."""
    return situation.task.assessment and situation.percept.joint is not None


class Scenes:
    """The scenes of a study, in these texts and under these settings."""

    def __init__(self, words: Words, study: Study, experiment: Experiment) -> None:
        self.words, self.study, self.experiment = words, study, experiment
        changes = " ".join(words.changes[kind] for kind in deceptions(study.conditions_of(PEOPLE)))
        self._facts = {"joints": len(study.box.joints), "budget": study.max_steps, "changes": changes}
        self._asked = words.comprehension.questions if experiment.comprehension else ()

    def way(self, boxes: int) -> tuple[Station, ...]:
        """All scenes of a participant who has agreed to take part and plays this many boxes, in order."""
        done = self.experiment

        def through(box: int) -> Iterator[Station]:
            """A box, the scene after it, and the checks then."""
            if box or done.practice:
                yield Station("box", box=box)
                yield Station("over", box=box)
            for number, check in enumerate(done.checks, 1):
                if check.after == box:
                    yield Station("check", str(number), asked=(check,))

        return (
            *(Station("page", str(number)) for number in range(1, len(self.words.instructions) + 1)),
            *([Station("comprehension", asked=self._asked)] if self._asked else []),
            *(station for box in range(boxes + 1) for station in through(box)),
            *(Station("ask", question.name, asked=(question,)) for question in done.questions),
            Station("debrief"),
        )

    def consent(self, boxes: int) -> Scene:
        """The first scene; ``boxes`` is how many a participant would play. Nothing is stored before they agree."""
        return self._text("consent", self.words.consent, boxes=boxes)

    def closed(self, why: Why) -> Scene:
        """The last scene of a participant who cannot go on. It admits false reports to those who leave early."""
        done = self.experiment
        way = {"taken": ("", ""), "finished": (done.completion_url, done.completion_code)}
        url, code = way.get(why, (done.left_url, done.left_code))
        return self._text("closed", self.words.closed[why]) | {"why": why, "url": url, "code": code}

    def at(self, station: Station, diary: Diary) -> Scene:
        """The scene of a participant outside a box. ``notice`` says why somebody is back at the instructions."""
        words, done, of = self.words, self.experiment, len(diary.joined.slots)
        pages = words.instructions
        match station.kind:
            case "page":
                number = int(station.item)
                scene = self._text("page", pages[number - 1], boxes=of)
                notice, begins = self._notice(diary) if number == 1 else (), number == len(pages) and not self._asked
                return scene | {"number": number, "of": len(pages), "notice": notice, "begins": begins}
            case "over":
                # whether the box was opened is said after practice, and where the study does
                box, ending = station.box, diary.endings.get(station.box)
                solved = ending == "solved" if (done.feedback or not box) and ending != "error" else None
                said = () if solved is None else (words.page["solved" if solved else "unsolved"],)
                own, more = (words.over, ()) if box else (words.practice_over, words.over.paragraphs)
                text = Longer(title=own.title, paragraphs=(*said, *own.paragraphs, *more))
                scene = self._text("over", text, number=box, of=of, boxes=of)
                return scene | {"practice": not box, "number": box, "of": of, "solved": solved}
            case "debrief":
                scene = self._text("debrief", words.debrief, boxes=of)
                return scene | {"url": done.completion_url, "code": done.completion_code}
            case "comprehension":
                scene = self._text("comprehension", words.comprehension, boxes=of)
                scene["notice"] = () if pages else self._notice(diary)
            case kind:
                scene = {"kind": kind, "title": "", "paragraphs": ()}  # one question, which stands for itself
        asked = tuple(one.model_dump(include={"question", "options", "required"}) for one in station.asked)
        return scene | {"questions": asked, "longest": LONGEST_ANSWER}

    def right(self, station: Station, act: Act) -> bool | None:
        """Whether an act answers a scene outside a box right; None where nothing is right or wrong.

        Raises:
            ActRefused: As ``impossible``, if it does not answer it.
        """
        asked = station.asked
        if (
            isinstance(act, Answers)
            and station.kind != "debrief"
            and len(act.answers) == len(asked)
            and all(one.takes(answer) for one, answer in zip(asked, act.answers, strict=True))
        ):
            right = tuple(one.right for one in asked if isinstance(one, OneRight))
            return act.answers == right if right else None
        raise ActRefused("impossible", f"nothing that can be done in a scene of kind {station.kind}")

    def _notice(self, diary: Diary) -> tuple[str, ...]:
        """Which questions were answered wrong in the last round; nothing where none was."""
        act = diary.rounds[-1].act if diary.rounds else None
        given = act.answers if isinstance(act, Answers) else ()
        wrong = [one.question for one, answer in zip(self._asked, given, strict=False) if answer != one.right]
        return (filled(self.words.page["again"], questions=" / ".join(wrong)),) if wrong else ()

    def _text(self, kind: str, text: Longer, **facts: object) -> Scene:
        """A scene of a filled-in title and paragraphs."""
        known = {**self._facts, **facts}
        more = (*(text.if_false if known["changes"] else ()), *(text.if_asked if self.study.assessment else ()))
        paragraphs = tuple(filled(part, **known) for part in (*text.paragraphs, *more))
        return {"kind": kind, "title": filled(text.title, **known), "paragraphs": paragraphs}

    def box(self, plan: Plan, situation: Situation, number: int, of: int) -> Scene:
        """The scene of a step: box ``number`` of ``of``, from 1 and without the practice, which is 0.

        ``ask`` is whether the page asks what the last action did, ``spoken`` what a screen reader says, ``history``
        what was read after each step so far, oldest first. Places and kinds of joints are only in a drawn panel.
        """
        task, percept, asked, view = situation.task, situation.percept, situation.briefing, view_of(plan.modality)
        step, drawn = len(situation.past) + 1, view == "panel"
        report = self._report(plan, task, percept, situation.past[-1].decision.joint if situation.past else "")
        joints = tuple(
            {
                "label": label,
                "target": label == task.target,
                "kind": plan.box.joints[place].kind if drawn else None,
                "place": task.places[i] if drawn else None,
                "position": None if percept.positions is None else int(percept.positions[i]),
            }
            for i, (label, place) in enumerate(zip(task.joints, plan.names.order, strict=True))
        )
        counted = filled(self.words.page["step"], step=step, budget=task.budget) + "."
        spoken = (*report, asked.remark, asked.warning if step == 1 else "", counted)
        return {
            "kind": "box",
            "practice": number == 0,
            "number": number,
            "of": of,
            "step": step,
            "budget": task.budget,
            "ask": is_asked(situation),
            "panel": {
                "view": view,
                "joints": joints,
                "report": report,
                "last": percept.joint,
                "outcome": percept.outcome,
                "pictures": tuple(f"data:image/png;base64,{one.base64}" for one in percept.shown),
            },
            "remark": asked.remark,
            "warning": asked.warning,
            "spoken": " ".join(filter(None, spoken)),
            "history": self.read(plan, situation) if self.experiment.history else (),
            "device": self.experiment.device,
        }

    def read(self, plan: Plan, situation: Situation) -> tuple[str, ...]:
        """What was read after each step so far, oldest first: the report and a remark."""
        return tuple(
            " ".join(filter(None, (*self._report(plan, situation.task, percept, turn.decision.joint), remark)))
            for turn, (percept, remark) in zip(situation.past, situation.told[1:], strict=True)
        )

    def _report(self, plan: Plan, task: Task, percept: Percept, chosen: str) -> tuple[str, ...]:
        """What is told of an attempt, in the sentences of the page: the same to read, to hear and in the history.

        It is as it stands where an intervention corrects its words. ``chosen`` is the joint that was
        chosen; empty before the first step.
        """
        words, channel, joint = self.words.page, shown(plan.modality), percept.joint or chosen
        told = percept.joint, percept.outcome, percept.positions
        if isinstance(channel, TextChannel) and percept.text != channel.written(*told, task, first=not chosen):
            return (percept.text,)
        found = [filled(words[percept.outcome or ("attempted" if joint else "first")], label=joint)]
        if percept.positions is not None:
            ones = [label for label, position in zip(task.joints, percept.positions, strict=True) if position]
            if percept.joint is not None:
                found.append(filled(words["now"], label=joint, position=int(joint in ones)))
            found.append(filled(words["positions"], labels=", ".join(ones) or words["none"]))
        elif joint and percept.outcome is None and not percept.pictures:
            found.append(words["no_report"])
        return tuple(found)


def deceptions(conditions: Iterable[Condition]) -> tuple[Deception, ...]:
    """The deceptions of a study, in a fixed order; none if everything is true.

    >>> from lockprobe.interventions.conditions import read_condition
    >>> deceptions(map(read_condition, ("flip?p=0.4 + nudge", "flip?p=0", "tremble?p=0.1")))
    ('false', 'another')
    """
    found = set[Deception]()
    for condition in conditions:
        of = set[Deception]()
        for spec, doses in condition.acting:
            both = {spec.options.get("first"), spec.options.get("last", "truth")}
            true = spec.full_name == "correction" and both == {"truth"}
            kind = _KINDS.get(spec.full_name, "changed")
            if kind and not true and not (doses and float(spec.options.get(doses[0], "0")) == 0):
                of.add(kind)
        # a dose of 0 does nothing, and a warning of false reports is true with some
        found |= of - {"warned"} if of & {"false", "late", "changed"} else of
    return tuple(kind for kind in get_args(Deception) if kind in found)
