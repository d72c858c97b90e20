"""Diaries on disk: who joined, with the record of consent, and every act of each participant; and what they say of all.

The server flushes an act to disk before the page sees the outcome. Steps of an unfinished trial are only here. A
finished trial is recorded like any other; its response times stay in the diary.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, ClassVar, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from lockprobe.agents.catalogue import check_outside
from lockprobe.foundation.errors import BadFile, BadValue
from lockprobe.foundation.inputs import is_there
from lockprobe.foundation.spec import PEOPLE
from lockprobe.foundation.storage.atomic_file import writing
from lockprobe.foundation.storage.database import Damaged, Database
from lockprobe.studies.records.store import STORE, check_row, read, write_acts
from lockprobe.studies.running.paused_trial import RecordedAttempt
from lockprobe.studies.study import Study
from lockprobe.trial.plan import Plan
from lockprobe.trial.record import Ending, Trial

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


class Answers(StrictModel):
    """To the questions of a scene, in their order: an option in its words, or a written answer; empty for none.

    It is also how to go on from something to read, where nothing is asked.
    """

    kind: Literal["answers"] = "answers"
    answers: Annotated[tuple[Annotated[str, Field(max_length=LONGEST_ANSWER)], ...], Field(max_length=20)]
    rt: Milliseconds


Act = Annotated[Agree | Attempt | Answers, Field(discriminator="kind")]


class Slot(StrictModel):
    """A trial of the study that a participant plays. Each trial of ``participant`` is played by one person."""

    condition: str
    repetition: int
    trial: int


class Joined(StrictModel):
    """The first entry: the record of consent.

    Attributes:
        identity: A random ID, independent of the person.
        token: SHA-256 of the browser's token; empty in what is exported.
        at: When the participant agreed.
        platform: The parameters of the recruitment platform that the experimenter keeps.
        slots: The trials in the order in which they are played.
        words: Language and fingerprint of the texts.
        page: Version of the page.
    """

    identity: str
    token: str
    at: Seconds
    platform: dict[str, str]
    slots: tuple[Slot, ...]
    words: str
    page: str = ""

    act: ClassVar[Agree] = Agree(agreed=True)


class Did(StrictModel):
    """One act, or what ended a box or the session without one.

    Attributes:
        at: When it arrived.
        turn: The number of the scene, from 2; joining was 1.
        scene: The kind of scene; ``late`` where the place was given away, after which there is nothing more.
        act: What the participant did; None where the box broke before a choice, or the place was given away.
        box: The box of a step or of the scene after a box, from 1; 0 is the practice box.
        step: The step, from 1.
        told: The report that the step produced; empty with pictures.
        shown: What the participant read of the step, in their language; empty where it ended the box.
        item: The number of a page, a check or a round of comprehension questions, from 1; the name of a question.
        right: Whether all answers were right; None where nothing is right or wrong.
        ended: How the trial ended with this; None where it goes on.
    """

    at: Seconds
    turn: int
    scene: str
    act: Act | None
    box: int | None = None
    step: int | None = None
    told: str = ""
    shown: str = ""
    item: str = ""
    right: bool | None = None
    ended: Ending | None = None


@dataclass(slots=True)
class Diary:
    """The diary of one participant, and how far they have come by its end.

    Attributes:
        joined: The first entry.
        lines: The other entries, oldest first.
    """

    joined: Joined
    lines: list[Did]

    @property
    def identity(self) -> str:
        """The ID of the participant."""
        return self.joined.identity

    @property
    def turn(self) -> int:
        """The number of the scene shown, from 2."""
        return 2 + len(self.lines)

    @property
    def last(self) -> Joined | Did:
        """The last entry; its act may be sent again if its reply was lost."""
        return self.lines[-1] if self.lines else self.joined

    @property
    def late(self) -> bool:
        """Whether the participant was away until somebody else needed the place, and cannot go on."""
        return isinstance(self.last, Did) and self.last.scene == "late"

    @property
    def steps(self) -> dict[int, list[Did]]:
        """The steps of each box, by its number; 0 is practice."""
        found: dict[int, list[Did]] = {}
        for did in self.lines:
            if isinstance(did.act, Attempt):
                found.setdefault(did.box or 0, []).append(did)
        return found

    @property
    def endings(self) -> dict[int, Ending]:
        """How each finished box ended; 0 is practice."""
        return {did.box or 0: did.ended for did in self.lines if did.ended is not None}

    @property
    def boxes_done(self) -> bool:
        """Whether all boxes are over."""
        return len(self.endings.keys() - {0}) == len(self.joined.slots)

    @property
    def slots_kept(self) -> list[Slot]:
        """The trials that nobody else can play: finished or still planned here, without broken ones."""
        open_ones = "error" if self.late else ""
        return [slot for box, slot in enumerate(self.joined.slots, 1) if self.endings.get(box, open_ones) != "error"]

    @property
    def rounds(self) -> list[Did]:
        """The answers to the questions on the instructions, round by round."""
        return [did for did in self.lines if did.scene == "comprehension"]

    @property
    def checks(self) -> list[bool]:
        """For each answered attention check, whether the answer was right."""
        return [bool(did.right) for did in self.lines if did.scene == "check"]

    @property
    def place(self) -> int:
        """How many scenes lie behind the participant; wrong answers on the instructions lead back to the first."""
        place = 0
        for did in self.lines:
            place += did.scene != "box" or did.ended is not None
            if did.scene == "comprehension" and not did.right:
                place = 0
        return place

    def attempts(self, box: int) -> list[RecordedAttempt]:
        """The steps of a box, to be played again."""
        acts = ((did.act, did.told) for did in self.steps.get(box, ()))
        return [RecordedAttempt(act.joint, act.claimed, told) for act, told in acts if isinstance(act, Attempt)]

    def seconds(self, box: int) -> float:
        """How long a box took, from when it was shown to its last step; 0 without one."""
        if not (steps := self.steps.get(box)):
            return 0.0
        before = Diary(self.joined, self.lines[: steps[0].turn - 2])
        return steps[-1].at - before.last.at

    def plan(self, study: Study, box: int) -> Plan:
        """Trial number ``box``, from 1, as the participant plays it."""
        slot = self.joined.slots[box - 1]
        return study.plan(f"{PEOPLE}:{self.identity}", study.labelled(slot.condition), slot.repetition, slot.trial)

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
    store, found = Path(directory) / STORE, list[Diary]()
    for identity, entries in _entries(directory).items():
        try:
            check_outside(f"{PEOPLE}:{identity}", PEOPLE)
            joined, *lines = entries
            diary = Diary(Joined.model_validate_json(joined), [Did.model_validate_json(line) for line in lines])
        except BadValue as mistake:
            raise Damaged(store, f"participant {identity}: {mistake}") from None
        except ValidationError as error:
            raise Damaged(store, f"participant {identity}: an entry is none: {error.errors()[0]['msg']}") from None
        if diary.identity != identity or [did.turn for did in diary.lines] != [*range(2, diary.turn)]:
            raise Damaged(store, f"participant {identity}: an entry is missing, doubled or somebody else's")
        found.append(diary)
    return sorted(found, key=lambda diary: (diary.joined.at, diary.identity))


def _entries(directory: Path | str) -> dict[str, list[str]]:
    """The entries of each participant as they are stored."""
    entries: dict[str, list[str]] = {}
    with read(directory) as store:
        for identity, number, entry, crc in store.rows(
            "select participant, number, entry, crc from act order by participant, number"
        ):
            check_row(store, f"participant {identity}: entry {number}", crc, identity, number, entry)
            entries.setdefault(identity, []).append(entry)
    return entries


def write_entry(store: Database, identity: str, number: int, entry: Joined | Did) -> None:
    """Append an entry, number ``number`` from 1, to a diary and flush it to disk; a deleted one stays deleted."""
    with store.transaction(sync=True) as writing:
        if store.one("select count(*) from act where participant = ?", identity) != (number - 1,):
            raise bad_diary(store.path, identity, "the diary was deleted")
        write_acts(writing, identity, number, [entry.model_dump_json()])


def take_diaries(store: Database, sources: Iterable[Path]) -> list[str]:
    """Copy the diaries of other directories that are new in a store, or longer than there; of whom they are.

    Raises:
        BadFile: If a diary is damaged, or two people have one ID.
    """
    known, coming = _entries(store.path.parent), dict[str, list[str]]()
    for source in sources:
        for diary in read_diaries(source):
            entries = [entry.model_dump_json() for entry in (diary.joined, *diary.lines)]
            here = known.get(diary.identity, [])
            if any(one != other for one, other in zip(here, entries, strict=False)):
                raise bad_diary(source / STORE, diary.identity, "somebody else has this ID")
            if len(here) < len(entries):
                known[diary.identity] = coming[diary.identity] = entries
    with store.transaction(sync=True) as writing:
        for identity, entries in coming.items():
            writing.execute("delete from act where participant = ?", (identity,))
            write_acts(writing, identity, 1, entries)
    return list(coming)


def make_private(directory: Path) -> None:
    """Let nobody but this user read the directory of a study in which people take part, nor what is in it."""
    with writing(directory):
        directory.chmod(0o700)


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
            trial = trials.get(key := diary.plan(study, box).key) if box else None
            if trial is None or trial.agent != f"{PEOPLE}:{diary.identity}":
                continue
            chosen = [(one.joint, one.claimed) for did in acts if isinstance(one := did.act, Attempt)]
            played = [(step.decision.joint, step.decision.claimed) for step in trial.steps]
            if chosen[: len(played)] != played:  # the attempt that broke a box is in the diary alone
                raise bad_diary(directory / STORE, diary.identity, f"the steps of {key} are not those on record")
            found.update(((key, step.step), did) for step, did in zip(trial.steps, acts, strict=False))
    return found


def flow_of(diaries: Sequence[Diary], gone: int) -> dict[str, int]:
    """How far participants came, for a report: dropout can bias every other number. Empty where nobody took part.

    Everybody who ``consented`` has ``withdrawn`` (``gone``; no more is known of them), has ``left_open`` boxes (and
    may still take part), or ``finished`` all. ``questioned`` are those who answered the questions on the instructions,
    ``second_round`` those who had to again. ``checks`` are answers to attention checks, ``right`` the right ones.
    """
    if not diaries and not gone:
        return {}
    finished = sum(one.boxes_done for one in diaries)
    checks = [right for one in diaries for right in one.checks]
    return {
        "consented": len(diaries) + gone,
        "withdrawn": gone,
        "left_open": len(diaries) - finished,
        "finished": finished,
        "questioned": sum(len(one.rounds) > 0 for one in diaries),
        "second_round": sum(len(one.rounds) > 1 for one in diaries),
        "checks": len(checks),
        "right": sum(checks),
    }


def boxes_of(study: Study, diaries: Sequence[Diary]) -> dict[str, tuple[int, int]]:
    """Condition -> boxes that people were given, and those that are not over, in the order of the study."""
    boxes = [(slot.condition, box in one.endings) for one in diaries for box, slot in enumerate(one.joined.slots, 1)]
    given, left = Counter(condition for condition, _ in boxes), Counter(one for one, over in boxes if not over)
    labels = [one.label for one in study.conditions_of(PEOPLE)]
    return {label: (given[label], left[label]) for label in labels if given[label]}
