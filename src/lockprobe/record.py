"""What is written down: truth and told side by side.

A :class:`Trial` is one closed loop of one agent on one box. Every step holds the true configuration, the true
outcome, what the agent was told, and what the agent said had happened. Clock readings are not part of a record:
the same seed gives the same bytes. How a record is written is :mod:`lockprobe.trial_json`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Literal, Protocol

from lockprobe.errors import Boundary
from lockprobe.model_call import Usage
from lockprobe.pictures.picture import Picture, PictureKind
from lockprobe.spec import PEOPLE, group_of

if TYPE_CHECKING:
    from lockprobe.pictures.frame import Frame

__all__ = [
    "SCHEMA_VERSION",
    "STATES",
    "UNNAMED",
    "Briefing",
    "Decision",
    "Ending",
    "Fact",
    "Look",
    "Moment",
    "Outcome",
    "Percept",
    "Situation",
    "Snapshot",
    "Step",
    "Task",
    "Trial",
    "TrialError",
    "Turn",
]

SCHEMA_VERSION = 2
"""The newest layout of a record. Version 1 knows flips alone; a record says 2 where it needs what came with it."""

STATES = "symbolic?tell=state"
"""The paper's symbolic observation (Sec. 2.2), as its spec: where the joints stand. Studies show it by default."""

UNNAMED = (STATES, "symbolic")
"""Modalities that nobody names where all trials have the same one."""

Outcome = Literal["moved", "blocked"]
"""What an attempt did to the attempted joint."""

Ending = Literal["solved", "budget", "error"]
"""Why a trial ended: the target moved, the steps ran out, or something broke."""

Fact = str | int | float | bool | None


@dataclass(frozen=True, slots=True, kw_only=True)
class Task:
    """What an agent knows before it begins.

    Attributes:
        joints: Labels in the order in which they are listed to the agent.
        target: Label of the joint that has to move.
        budget: Steps it has.
        places: Each joint's place on the panel, as in :class:`lockprobe.lockbox.box.Joint`, aligned with ``joints``;
            for agents that look at the panel. Empty where it is not shown.
        assessment: Whether it is asked what its last action did. Asking may change behaviour.
        kinds: Whether each joint slides (``prismatic``) or turns (``revolute``), as ``places``.
    """

    joints: tuple[str, ...]
    target: str
    budget: int
    places: tuple[tuple[float, float], ...] = ()
    assessment: bool = True
    kinds: tuple[str, ...] = ()


class Look(Protocol):
    """Takes a picture in the agent's terms: handles in the order of ``Task.joints``."""

    def __call__(self, positions: tuple[bool, ...] | None = None, /) -> Frame:
        """What a camera sees now, or would see if the joints stood as told.

        Args:
            positions: As told, aligned with ``Task.joints``; None for how they stand.

        Raises:
            BadValue: If they stand otherwise, and the plant can show what is only.
        """
        ...


@dataclass(frozen=True, slots=True, kw_only=True)
class Snapshot:
    """The truth at one moment, as a plant reports it.

    Attributes:
        configuration: One position per joint in panel order.
        joint: The joint just attempted, by index in panel order; None before the first attempt.
        outcome: What that attempt really did.
        sensed: What a robot measured of it, its own verdict among them; it may be wrong.
        look: Takes a picture now; it has to be called before the next attempt. None where there is no camera.
        render: Draws the picture that would be taken now in another configuration, and changes nothing. It has to be
            called before the next attempt, too. None where a camera sees only what is.
    """

    configuration: tuple[bool, ...]
    joint: int | None = None
    outcome: Outcome | None = None
    sensed: Mapping[str, Fact] = field(default_factory=dict)
    look: Callable[[], Frame] | None = field(default=None, compare=False, repr=False)
    render: Callable[[tuple[bool, ...]], Frame] | None = field(default=None, compare=False, repr=False)


@dataclass(frozen=True, slots=True, kw_only=True)
class Percept:
    """One observation, in the agent's own terms. Channels change it; the truth stays elsewhere.

    Attributes:
        joint: Label of the joint just attempted; None before the first attempt.
        outcome: The outcome as reported.
        positions: Positions as reported, aligned with ``Task.joints``; None where they are not told.
        text: The observation as sentences.
        pictures: The observation as pictures.
        handles: For each joint of ``Task.joints`` where in the pictures its handle is seen, (column, row), at position
            0 and at position 1; for scripted agents that look at pictures. It is in no text.
        states_only: Whether reports tell positions and never outcomes.
        corrects: The report that was given first, and is corrected by this one; None where there is no correction.
        look: Takes a picture of the truth, or of what is told; for channels, never for agents.
    """

    joint: str | None = None
    outcome: Outcome | None = None
    positions: tuple[bool, ...] | None = None
    text: str = ""
    pictures: tuple[Picture, ...] = ()
    handles: tuple[tuple[tuple[float, float], tuple[float, float]], ...] = ()
    states_only: bool = False
    corrects: Percept | None = None
    look: Look | None = field(default=None, compare=False, repr=False)


@dataclass(frozen=True, slots=True, kw_only=True)
class Decision:
    """What the agent answered.

    Attributes:
        joint: Label of the joint to attempt next.
        claimed: What it says its previous action did; None before the first attempt or if it was not asked.
        hypothesis: What it says about the box, in its own words; often empty.
        probabilities: Exact probability of each joint, aligned with ``Task.joints``, where the agent has one.
        claim_probability: Exact probability that it says ``moved``, where the agent has one.
        replies: Raw replies in the order in which they came; all but the last were malformed.
        usage: What the decision cost.
        served: The model that answered, as its provider names it.
        confidence: How sure it is of ``claimed``, 0 to 100; None where it was not asked.
        report_false: Whether it thinks that what it was last told is false; None where it was not asked.
    """

    joint: str
    claimed: Outcome | None = None
    hypothesis: str = ""
    probabilities: tuple[float, ...] | None = None
    claim_probability: float | None = None
    replies: tuple[str, ...] = ()
    usage: Usage | None = None
    served: str = ""
    confidence: int | None = None
    report_false: bool | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Briefing:
    """What an agent is asked in one step, in addition to the report. Agents that read no words pay no attention to it.

    Attributes:
        remark: What is said to it with the report of this step; often empty.
        warning: What the instruction says of the reports; often empty.
        instruction: The instruction as a template (:data:`lockprobe.agents.prompt.FIELDS`); empty for the usual one.
        hypothesis: Whether it says how the box works before its choice or after it, or is not asked.
        confidence: Whether it is asked how sure it is of what its last action did, and whether the report is false.
    """

    remark: str = ""
    warning: str = ""
    instruction: str = ""
    hypothesis: Literal["before", "after", "off"] = "before"
    confidence: bool = False

    def remarking(self, text: str) -> Briefing:
        """The same with one more remark."""
        return replace(self, remark=f"{self.remark} {text}".lstrip())

    def warning_of(self, text: str) -> Briefing:
        """The same with one more warning."""
        return replace(self, warning=f"{self.warning} {text}".lstrip())


@dataclass(frozen=True, slots=True, kw_only=True)
class Turn:
    """One finished exchange: what the agent was told, and what it then decided.

    Attributes:
        percept: What it was told.
        decision: What it decided.
        remark: What was said to it with the report.
    """

    percept: Percept
    decision: Decision
    remark: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Moment:
    """One moment of a trial as interventions see it, truth and report: the first look, or what came of an attempt.

    Attributes:
        was: The truth in the agent's terms: joint, outcome and positions.
        told: What the agent was finally told or shown.
        chosen: Label of the joint that it had chosen; None for the first look.
        attempted: Label of the joint that was attempted; None for the first look.
        facts: The report in facts, before it was put into words or pictures, which may leave some out; None where it
            was not, and ``told`` holds them.
    """

    was: Percept
    told: Percept
    chosen: str | None = None
    attempted: str | None = None
    facts: Percept | None = None

    @property
    def reported(self) -> Percept:
        """The report in facts: what the words or pictures were made of."""
        return self.told if self.facts is None else self.facts

    @property
    def shown(self) -> tuple[bool, ...] | None:
        """Positions that the agent was told, or that its pictures show; None if neither."""
        told = self.told.positions
        return self.reported.positions if told is None and self.told.pictures else told


@dataclass(frozen=True, slots=True, kw_only=True)
class Situation:
    """All that an agent may use to decide.

    Attributes:
        task: The task.
        past: Finished exchanges, oldest first.
        percept: What it has just been told.
        briefing: What it is asked.
    """

    task: Task
    past: tuple[Turn, ...]
    percept: Percept
    briefing: Briefing = Briefing()


@dataclass(frozen=True, slots=True, kw_only=True)
class Step:
    """One step, truth and report.

    Attributes:
        step: From 1.
        state: True configuration before the step, a bit string in panel order.
        joint: The joint attempted, by its name in the box.
        moved: Whether it really moved.
        told_moved: What the report afterwards said of the joint attempted last; None where it said nothing of it. Where
            positions are told or pictured and no outcome, it is what comparing them with those before says.
        told_state: The configuration as reported afterwards, a bit string in panel order; None if not told. Of pictures
            the configuration that they show, where it is not the true one; None if it is.
        told: The report afterwards as the agent saw it.
        decision: What the agent answered; ``decision.claimed`` is about the *previous* step.
        sensed: What a robot measured, its own verdict (moved, blocked, failed) among it; empty without a robot.
        pictures: File names of the pictures taken afterwards, by kind.
        chosen: The joint that the agent had chosen, by its name in the box, where another one was attempted; else None.
        remark: What was said to the agent with the report before this step.
    """

    step: int
    state: str
    joint: str
    moved: bool
    told_moved: bool | None
    told_state: str | None
    told: str
    decision: Decision
    sensed: Mapping[str, Fact] = field(default_factory=dict)
    pictures: Mapping[PictureKind, str] = field(default_factory=dict)
    chosen: str | None = None
    remark: str = ""

    @property
    def told_falsely(self) -> bool:
        """Whether the report afterwards said the opposite of what happened."""
        return self.told_moved is not None and self.told_moved != self.moved


@dataclass(frozen=True, slots=True, kw_only=True)
class TrialError:
    """Why a trial could not be finished.

    Attributes:
        boundary: Where it broke.
        message: What was said, without secrets.
        step: The step that could not be played, from 1.
        replies: Raw malformed replies, if that was the reason.
        usage: What they cost.
        again: Whether a user asked to have the trial played again, though its agent broke it.
    """

    boundary: Boundary
    message: str
    step: int
    replies: tuple[str, ...] = ()
    usage: Usage | None = None
    again: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Trial:
    """One finished trial.

    Attributes:
        key: Its readable name in the study, for example ``flips/random/p=0.4/rep=2/trial=7``.
        study: Name of the study.
        agent: Agent spec; of a person ``participant:ID``.
        facts: What the agent was: model name, file hash, runtime, sampling settings.
        box: Name of the box.
        modality: How the box was shown.
        p: Flip probability, [0, 1], where nothing but flips acted; None under any other condition.
        flip: Kind of outcome flip; empty where other things than flips acted.
        channels: What stood between the box and the agent's eyes, in order, each with its settings.
        repetition: From 1.
        trial: From 1.
        seed: Seed of the study.
        budget: Steps it had.
        joints: Joint names in panel order.
        labels: The labels the agent knew them by, in panel order.
        listing: The same labels in the order in which they were listed to the agent.
        target: Name of the target joint.
        opening: What the agent was told before its first step.
        steps: The steps.
        ending: ``solved``, ``budget`` or ``error``. An error is never a failure to solve.
        error: Why, if the ending is ``error``.
        plant: What the plant was: its settings, engine, renderer; empty for the symbolic plant.
        opening_pictures: File names of the pictures taken before the first step, by kind.
        assessment: Whether the agent was asked what its last action had done.
        interventions: What else acted, in order, each with its settings: on what was asked, remembered or done.
        condition: The name of its condition, where the study has others than flip rates; else empty.
        replays: How often it was played anew, on request, after an error of its agent's; the earlier records stay.
        schema: Version of this layout.
        placed: The dose at which an analysis counts it, where that is not its flip rate. It is on no record.
    """

    key: str
    study: str
    agent: str
    facts: Mapping[str, Fact]
    box: str
    modality: str
    p: float | None
    flip: str
    channels: tuple[Mapping[str, Fact], ...]
    repetition: int
    trial: int
    seed: int
    budget: int
    joints: tuple[str, ...]
    labels: tuple[str, ...]
    listing: tuple[str, ...]
    target: str
    opening: str
    steps: tuple[Step, ...]
    ending: Ending
    error: TrialError | None = None
    plant: Mapping[str, Fact] = field(default_factory=dict)
    opening_pictures: Mapping[PictureKind, str] = field(default_factory=dict)
    assessment: bool = True
    interventions: tuple[Mapping[str, Fact], ...] = ()
    condition: str = ""
    replays: int = 0
    schema: int = 1
    placed: float | None = None

    def __repr__(self) -> str:
        ending = f"error at {self.error.boundary}" if self.error else self.ending
        return f"<Trial {self.key}: {ending} after {len(self.steps)} of {self.budget} steps>"

    @property
    def solved(self) -> bool:
        """Whether the target moved."""
        return self.ending == "solved"

    @property
    def group(self) -> str:
        """The agent as whom it counts: itself, or for a person people as one, ``participant``."""
        return group_of(self.agent)

    @property
    def player(self) -> str:
        """The person who played it, as a spec: one cluster of trials. Empty for an agent, whose trials stand alone."""
        return self.agent if self.group == PEOPLE else ""

    @property
    def ordinary(self) -> bool:
        """Whether every joint chosen was attempted and every attempt was reported, as models of choices assume."""
        return all(step.chosen is None and step.told_moved is not None for step in self.steps)

    @property
    def states_only(self) -> bool:
        """Whether it was told or shown where joints stand and never what an attempt did."""
        return bool(self.opening_pictures) or any(channel.get("tell") == "state" for channel in self.channels)

    @property
    def actions(self) -> tuple[str, ...]:
        """The joints attempted, in order."""
        return tuple(step.joint for step in self.steps)

    @property
    def picture_names(self) -> frozenset[str]:
        """File names of all pictures that were taken."""
        return frozenset(
            [*self.opening_pictures.values(), *(name for step in self.steps for name in step.pictures.values())]
        )

    @property
    def dose(self) -> float:
        """Its place on the analysis axis: its flip rate unless ``placed``; not a number under other conditions."""
        return self.placed if self.placed is not None else math.nan if self.p is None else self.p

    @property
    def cell(self) -> str:
        """Its agent under its condition, as a readable name, for example ``flips/random/p=0.4``."""
        return self.key.rsplit("/rep=", 1)[0]

    @property
    def owed_again(self) -> bool:
        """Whether it has to be played again: something outside the agent broke it, or somebody asked for it."""
        return self.error is not None and (self.error.boundary != "reply" or self.error.again)
