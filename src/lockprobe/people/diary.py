"""Diaries on disk: who joined, with the record of consent, and every act of each participant as the page sends it.

The server flushes an act to disk before the page sees the outcome. Steps of an unfinished trial are only here. A
finished trial is recorded like any other; its response times stay in the diary.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from sqlite3 import Connection
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, TypeAdapter, ValidationError

from lockprobe.agents.outside import check_outside, participant_spec
from lockprobe.foundation.errors import BadFile, BadValue
from lockprobe.foundation.inputs import is_there
from lockprobe.foundation.spec import PEOPLE
from lockprobe.foundation.storage.atomic_file import writing
from lockprobe.foundation.storage.database import Damaged, Database
from lockprobe.studies.records.store import STORE, check_row, read, write_acts
from lockprobe.studies.running.paused_trial import RecordedAttempt
from lockprobe.studies.study import Study
from lockprobe.trial.plan import Plan
from lockprobe.trial.record import Ending

LONGEST_ANSWER = 2000
"""Characters of an answer in words."""

Seconds = Annotated[float, Field(ge=0, allow_inf_nan=False)]
"""Since 1970 (UTC), of the server's clock."""

Milliseconds = Annotated[float, Field(ge=0, le=1e9, allow_inf_nan=False)]
"""From painting the scene, on the page's monotonic clock (``performance.now``)."""

Pixels = Annotated[int, Field(ge=0, le=100_000)]


class StrictModel(BaseModel):
    """Base of everything that is stored or sent: immutable, no extra fields, no type conversion."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)


class Agree(StrictModel):
    """To take part, or not."""

    kind: Literal["agree"] = "agree"
    agreed: bool


class Next(StrictModel):
    """To go on from something to read."""

    kind: Literal["next"] = "next"


class Attempt(StrictModel):
    """To choose a joint.

    Attributes:
        claimed: What the participant says the last action did, where asked.
        rt: Until the choice of the joint; without the time for ``claimed``.
        claimed_rt: Until the choice of ``claimed``; None where not asked.
        pointer: The device of the choice; None where it is not kept.
        viewport: Width and height of the window, CSS pixels; None where they are not kept.
    """

    kind: Literal["attempt"] = "attempt"
    joint: Annotated[str, Field(min_length=1, max_length=8)]
    claimed: Literal["moved", "blocked"] | None = None
    rt: Milliseconds
    claimed_rt: Milliseconds | None = None
    pointer: Literal["mouse", "touch", "pen", "keyboard"] | None = None
    viewport: tuple[Pixels, Pixels] | None = None


class Answer(StrictModel):
    """To a question: an option in its words, or a written answer; empty to skip an optional question."""

    kind: Literal["answer"] = "answer"
    answer: Annotated[str, Field(max_length=LONGEST_ANSWER)]
    rt: Milliseconds


class Answers(StrictModel):
    """To the questions on the instructions: an option for each, in their order."""

    kind: Literal["answers"] = "answers"
    answers: Annotated[tuple[Annotated[str, Field(max_length=200)], ...], Field(max_length=20)]
    rt: Milliseconds


Act = Annotated[Agree | Next | Attempt | Answer | Answers, Field(discriminator="kind")]


class Slot(StrictModel):
    """A trial of the study that a participant plays. Each trial of ``participant`` is played by one person."""

    condition: str
    repetition: int
    trial: int

    def plan(self, study: Study, identity: str) -> Plan:
        """The trial as a participant plays it."""
        return study.plan(participant_spec(identity), study.labelled(self.condition), self.repetition, self.trial)


class Joined(StrictModel):
    """The first entry: the record of consent.

    Attributes:
        identity: A random ID, independent of the person.
        token: SHA-256 of the browser's token; empty in what is exported.
        at: When the participant agreed.
        platform: The parameters of the recruitment platform that the experimenter keeps.
        slots: The trials in the order in which they are played.
        words: Language and fingerprint of the texts.
    """

    kind: Literal["joined"] = "joined"
    identity: str
    token: str
    at: Seconds
    platform: dict[str, str]
    slots: tuple[Slot, ...]
    words: str


class Did(StrictModel):
    """One act.

    Attributes:
        at: When the server received it.
        turn: The number of the scene, from 2; joining was 1.
        scene: The kind of scene.
        box: The box of a step or of the scene after a box, from 1; 0 is the practice box.
        step: The step, from 1.
        told: The report that the step produced; empty with pictures.
        shown: What the participant read of the step, in their language; empty where it ended the box.
        item: The number of a page, a check or a round of comprehension questions, from 1; the name of a question.
        right: Whether the answer to an attention check was right, or all answers of a round.
        ended: How the trial ended with this step; None where it goes on.
        page: Version of the page, with the first step of a box; empty for the practice box.
    """

    kind: Literal["did"] = "did"
    at: Seconds
    turn: int
    scene: str
    act: Act
    box: int | None = None
    step: int | None = None
    told: str = ""
    shown: str = ""
    item: str = ""
    right: bool | None = None
    ended: Ending | None = None
    page: str = ""


class Broken(StrictModel):
    """A box broke before a choice."""

    kind: Literal["broken"] = "broken"
    at: Seconds
    turn: int
    box: int


class Released(StrictModel):
    """The last line of a participant who cannot go on: others may play the unfinished trials.

    ``why``: ``late`` (was away too long, and somebody else needed the place) or ``screened`` (too many rounds of wrong
    answers about the instructions).
    """

    kind: Literal["released"] = "released"
    at: Seconds
    why: Literal["late", "screened"] = "late"


Entry = Joined | Did | Broken | Released

_adapter: TypeAdapter[Entry] = TypeAdapter(Annotated[Entry, Field(discriminator="kind")])


@dataclass(slots=True)
class Diary:
    """The diary of one participant, and how far they have come by its end.

    Attributes:
        joined: The first entry.
        lines: The other entries, oldest first.
    """

    joined: Joined
    lines: list[Did | Broken | Released]

    @property
    def identity(self) -> str:
        """The ID of the participant."""
        return self.joined.identity

    @property
    def spec(self) -> str:
        """The agent of the trials."""
        return participant_spec(self.identity)

    @property
    def acts(self) -> list[Did]:
        """What the participant did, oldest first."""
        return [line for line in self.lines if isinstance(line, Did)]

    @property
    def _turns(self) -> list[Joined | Did | Broken]:
        return [self.joined, *(line for line in self.lines if not isinstance(line, Released))]

    @property
    def turn(self) -> int:
        """The number of the scene shown, from 2."""
        return 1 + len(self._turns)

    @property
    def at(self) -> float:
        """When the last act was written, seconds since 1970."""
        return self._turns[-1].at

    @property
    def last(self) -> Act | None:
        """The last act, which may be sent again if its reply was lost; None where a box broke after it."""
        last = self._turns[-1]
        return Agree(agreed=True) if isinstance(last, Joined) else last.act if isinstance(last, Did) else None

    @property
    def shut(self) -> Literal["", "late", "screened"]:
        """Why the participant cannot go on and others may play the unfinished trials; empty otherwise."""
        return next((line.why for line in self.lines if isinstance(line, Released)), "")

    @property
    def steps(self) -> dict[int, list[Did]]:
        """The steps of each box, by its number; 0 is practice."""
        found: dict[int, list[Did]] = {}
        for did in self.acts:
            if did.scene == "box":
                found.setdefault(did.box or 0, []).append(did)
        return found

    @property
    def endings(self) -> dict[int, Ending]:
        """How each finished box ended; 0 is practice."""
        found: dict[int, Ending] = {}
        for line in self.lines:
            if isinstance(line, Broken):
                found[line.box] = "error"
            elif isinstance(line, Did) and line.ended is not None:
                found[line.box or 0] = line.ended
        return found

    @property
    def boxes_done(self) -> bool:
        """Whether all boxes are over."""
        return len(self.endings.keys() - {0}) == len(self.joined.slots)

    @property
    def closed_boxes(self) -> set[int]:
        """The boxes in which nothing more can happen, from 1: finished ones, and all after a release."""
        return set(range(1, len(self.joined.slots) + 1)) if self.shut else self.endings.keys() - {0}

    @property
    def slots_kept(self) -> list[Slot]:
        """The trials that nobody else can play: finished or still planned here, without broken ones."""
        endings, shut = self.endings, self.shut
        return [
            slot
            for box, slot in enumerate(self.joined.slots, 1)
            if (endings[box] != "error" if box in endings else not shut)
        ]

    @property
    def rounds(self) -> list[Did]:
        """The answers to the questions on the instructions, round by round."""
        return [did for did in self.acts if isinstance(did.act, Answers)]

    @property
    def misread(self) -> Answers | None:
        """The answers of the last round if one was wrong; None otherwise."""
        last = self.rounds[-1:]
        return last[0].act if last and not last[0].right and isinstance(last[0].act, Answers) else None

    @property
    def checks(self) -> list[bool]:
        """For each answered attention check, whether the answer was right."""
        return [bool(did.right) for did in self.acts if did.scene == "check"]

    @property
    def place(self) -> int:
        """How many scenes lie behind the participant; wrong answers lead back to the first."""
        place = 0
        for line in self.lines:
            if isinstance(line, Did) and isinstance(line.act, Answers) and not line.right:
                place = 0
            elif not isinstance(line, Released):
                place += isinstance(line, Broken) or line.scene != "box" or line.ended is not None
        return place

    def attempts(self, box: int) -> list[RecordedAttempt]:
        """The steps of a box, to be played again."""
        acts = ((did.act, did.told) for did in self.steps.get(box, ()))
        return [RecordedAttempt(act.joint, act.claimed, told) for act, told in acts if isinstance(act, Attempt)]

    def seconds(self, box: int) -> float:
        """How long a box took, from when it was shown to its last step; 0 without one."""
        steps, turns = self.steps.get(box), self._turns
        return steps[-1].at - turns[turns.index(steps[0]) - 1].at if steps else 0.0

    def key(self, study: Study, box: int | None) -> str:
        """The key of trial number ``box``, from 1; empty for the practice box."""
        if not box or box > len(self.joined.slots):
            return ""
        return self.joined.slots[box - 1].plan(study, self.identity).key

    def check_slots(self, study: Study, directory: Path) -> None:
        """Raise BadFile if the participant plays a trial that the study does not have."""
        for slot in self.joined.slots:
            there = 1 <= slot.repetition <= study.repetitions and 1 <= slot.trial <= study.trials
            if not (there and slot.condition in [one.label for one in study.conditions_of(PEOPLE)]):
                raise bad_diary(directory / STORE, self.identity, "trials of another study")

    def without_identity(self, *, platform: bool = False) -> Diary:
        """A copy to share: no token, no platform parameters unless ``platform``, no time of day.

        Times are seconds since this participant joined, to the millisecond.
        """
        start, known = self.joined.at, self.joined.platform if platform else {}
        joined = self.joined.model_copy(update={"token": "", "at": 0.0, "platform": known})
        lines = [line.model_copy(update={"at": round(max(0.0, line.at - start), 3)}) for line in self.lines]
        return Diary(joined, lines)


def bad_diary(store: Path, identity: str, why: str) -> BadFile:
    """The error of a diary in a store."""
    return BadFile(store, f"participant {identity}: {why}")


def read_diaries(directory: Path | str) -> list[Diary]:
    """The diaries of a study in the order in which the participants joined; raises BadFile if one is damaged."""
    if not is_there(Path(directory) / STORE):
        return []
    entries: dict[str, list[str]] = {}
    with read(directory) as store:
        for identity, number, entry, crc in store.rows(
            "select participant, number, entry, crc from act order by participant, number"
        ):
            check_row(store, f"participant {identity}: entry {number}", crc, identity, number, entry)
            entries.setdefault(identity, []).append(entry)
    found = [_diary(store.path, identity, of) for identity, of in entries.items()]
    return sorted(found, key=lambda diary: (diary.joined.at, diary.identity))


def sound_entries(store: Path, identity: str, entries: Sequence[str]) -> int:
    """How many of the first entries of a diary are sound."""
    for many in range(len(entries), 0, -1):
        with suppress(Damaged):
            _diary(store, identity, entries[:many])
            return many
    return 0


def _diary(store: Path, identity: str, entries: Sequence[str]) -> Diary:
    """The diary that entries are, of which there is at least one; raises Damaged if they are none."""
    lines = list[Entry]()
    try:
        check_outside(participant_spec(identity))
        for entry in entries:
            lines.append(_adapter.validate_json(entry, strict=True, extra="forbid"))
    except BadValue as mistake:
        raise Damaged(store, f"participant {identity}: {mistake}") from None
    except ValidationError as error:
        why = f"entry {len(lines) + 1}: {error.errors()[0]['msg']}"
        raise Damaged(store, f"participant {identity}: {why}") from None
    joined, *rest = lines
    then = [line for line in rest if not isinstance(line, Joined)]
    turns = [line.turn for line in then if not isinstance(line, Released)]
    if not isinstance(joined, Joined) or joined.identity != identity or len(then) < len(rest):
        raise Damaged(store, f"participant {identity}: the first entry has to say, alone, that this participant joined")
    if turns != list(range(2, 2 + len(turns))):
        raise Damaged(store, f"participant {identity}: an act is missing or duplicated")
    return Diary(joined, then)


def write_entry(store: Database, identity: str, number: int, entry: Entry) -> None:
    """Append an entry, number ``number`` from 1, to a diary and flush it to disk; a deleted one stays deleted."""
    with store.transaction(sync=True) as writing:
        if store.one("select count(*) from act where participant = ?", identity) != (number - 1,):
            raise bad_diary(store.path, identity, "the diary was deleted")
        _write_entries(writing, identity, number, [entry])


def take_diaries(store: Database, sources: Iterable[Path]) -> list[str]:
    """Copy the diaries of other directories that are new in a store, or longer than there; of whom they are.

    Raises:
        BadFile: If a diary is damaged, or two people have one ID.
    """
    known = {diary.identity: diary for diary in read_diaries(store.path.parent)}
    coming = dict[str, Diary]()
    for source in sources:
        for diary in read_diaries(source):
            here = known.get(diary.identity, Diary(diary.joined, []))
            common = min(len(here.lines), len(diary.lines))
            if (here.joined, here.lines[:common]) != (diary.joined, diary.lines[:common]):
                raise bad_diary(source / STORE, diary.identity, "somebody else has this ID")
            if diary.identity not in known or len(here.lines) < len(diary.lines):
                known[diary.identity] = coming[diary.identity] = diary
    with store.transaction(sync=True) as writing:
        for identity, diary in coming.items():
            writing.execute("delete from act where participant = ?", (identity,))
            _write_entries(writing, identity, 1, (diary.joined, *diary.lines))
    return list(coming)


def _write_entries(writing: Connection, identity: str, first: int, entries: Iterable[Entry]) -> None:
    write_acts(writing, identity, first, (_adapter.dump_json(one).decode() for one in entries))


def make_private(directory: Path) -> None:
    """Let nobody but this user read the directory of a study in which people take part, nor what is in it."""
    with writing(directory):
        directory.chmod(0o700)
