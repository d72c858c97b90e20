"""Records of trials: the truth and the reports of every step.

A :class:`Trial` is one closed loop of one agent on one box. Every step holds the truth, what the agent was told, and
what it said had happened. Clock readings are not part of a record: the same seed gives the same bytes.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import isfinite
from typing import TYPE_CHECKING, Any, Literal

from lockprobe.foundation.errors import FINAL, Boundary
from lockprobe.foundation.spec import PEOPLE, group_of
from lockprobe.trial.doses import flip_rate
from lockprobe.trial.model_call import WHOLE, Count, Finite, Share, Usage, Whole
from lockprobe.trial.pictures.picture import Picture, PictureKind, PictureName

if TYPE_CHECKING:
    from lockprobe.trial.pictures.frame import Frame

STATES = "symbolic?tell=state"
"""The paper's symbolic observation (Sec. 2.2), as its spec: where the joints stand. Studies show it by default."""

PLAIN_WORDS = (STATES, f"{STATES}&form=json", "symbolic")
"""The modalities in words that studies have by default; pages do not name them where all trials have one of them."""

LONGEST_TRIAL = 10_000
"""The most steps of a trial."""

Outcome = Literal["moved", "blocked"]
"""The outcome of an attempt for the attempted joint."""

Ask = Literal["before", "after", "off"]
"""When an agent is asked how the box works: before it chooses, after it has chosen, or never."""

Ending = Literal["solved", "budget", "error"]
"""How a trial ended: the target moved, the steps ran out, or something broke."""

Fact = str | Whole | Finite | bool | None


def facts_of(said: Mapping[str, object]) -> dict[str, Fact]:
    """Facts as a record holds them: what is neither text, number nor truth value is written as text.

    What UTF-8 does not know becomes a question mark.
    """
    facts: dict[str, Fact] = {}
    for name, value in said.items():
        whole = isinstance(value, int) and abs(value) <= WHOLE
        plain = value is None or whole or (isinstance(value, float) and isfinite(value))
        known = value if plain else str(value).encode(errors="replace").decode()
        facts[str(name).encode(errors="replace").decode()] = known  # type: ignore[assignment]
    return facts


def in_words(outcome: Outcome | bool | None, nothing: str = "nothing") -> str:
    """An outcome in words, given as such or as whether the joint moved; ``nothing`` where there is none.

    >>> in_words("moved"), in_words(False), in_words(None)
    ('moved', 'did not move', 'nothing')
    """
    return nothing if outcome is None else "moved" if outcome in (True, "moved") else "did not move"


@dataclass(frozen=True, slots=True, kw_only=True)
class Task:
    """The task: an agent's knowledge before it begins.

    ``joints`` are labels in the order in which they are listed; ``target`` is one of them. ``places`` and ``kinds`` of
    the joints (:class:`lockprobe.boxes.box.Joint`) are aligned with them, and empty if they are not shown. With
    ``assessment`` the agent is asked what its last action did, which may change behaviour.
    """

    joints: tuple[str, ...]
    target: str
    budget: int
    places: tuple[tuple[float, float], ...] = ()
    assessment: bool = True
    kinds: tuple[str, ...] = ()


@dataclass(slots=True, kw_only=True)
class Snapshot:
    """The truth at one moment, as a plant reports it.

    Attributes:
        configuration: One position per joint in panel order.
        joint: The joint just attempted, by index in panel order, with its true ``outcome``; None before the first.
        sensed: A robot's measurements of it, including its own verdict and a camera's reading; they may be wrong.
        look: Takes a picture now; must be called before the next attempt. None without a camera.
        render: Draws the picture of another configuration, also before the next attempt; None if that cannot be shown.
    """

    configuration: tuple[bool, ...]
    joint: int | None = None
    outcome: Outcome | None = None
    sensed: Mapping[str, Fact] = field(default_factory=dict)
    look: Callable[[], Frame] | None = field(default=None, compare=False, repr=False)
    render: Callable[[tuple[bool, ...]], Frame] | None = field(default=None, compare=False, repr=False)


@dataclass(frozen=True, kw_only=True)
class Percept:
    """One observation, in the agent's terms. Channels change it; the truth is kept separately.

    Attributes:
        joint: Label of the joint just attempted; None before the first attempt.
        outcome, positions: As reported, positions aligned with ``Task.joints``; None if not told. By default positions
            alone are told; :attr:`Situation.outcome` compares them.
        text, pictures: The observation as sentences, and as pictures.
        handles: For each of ``Task.joints``, where pictures show its handle, (column, row), at positions 0 and 1.
        states_only: Whether reports tell positions and never outcomes.
        in_full: Whether the text tells the position of every joint, and not only which are at 1.
        unlabelled: Whether its pictures show no labels of joints.
        corrects: The first report, which this one corrects; None without a correction.
        look: Takes a picture of the truth, or of told positions, with handles in the order of ``Task.joints``; for
            channels, never for agents.
    """

    joint: str | None = None
    outcome: Outcome | None = None
    positions: tuple[bool, ...] | None = None
    text: str = ""
    pictures: tuple[Picture, ...] = ()
    handles: tuple[tuple[tuple[float, float], tuple[float, float]], ...] = ()
    states_only: bool = False
    in_full: bool = False
    unlabelled: bool = False
    corrects: Percept | None = None
    look: Callable[..., Frame] | None = field(default=None, compare=False, repr=False)

    @property
    def shown(self) -> tuple[Picture, ...]:
        """The pictures that the agent sees."""
        return tuple(picture for picture in self.pictures if picture.shown)

    def but(self, **changes: Any) -> Percept:
        """As ``replace``, in a tenth of the time: for what changes the reports of most studies."""
        one = object.__new__(Percept)
        object.__setattr__(one, "__dict__", self.__dict__ | changes)
        return one


@dataclass(frozen=True, slots=True, kw_only=True)
class Decision:
    """The agent's answer.

    Attributes:
        joint: Label of the joint to attempt next.
        claimed: Its claim about its previous action; None before the first attempt or if it was not asked.
        hypothesis: Its words about the box; often empty.
        probabilities: Exact probability of each joint, aligned with ``Task.joints``, if the agent has one.
        claim_probability: Exact probability that it says ``moved``, if the agent has one.
        replies: Raw replies in the order in which they came; all but the last were malformed.
        served: The model that answered, as its provider names it.
        tidied: What was tidied to read the last reply, by :data:`lockprobe.agents.reply.TIDIED`.
    """

    joint: str
    claimed: Outcome | None = None
    hypothesis: str = ""
    probabilities: tuple[Share, ...] | None = None
    claim_probability: Share | None = None
    replies: tuple[str, ...] = ()
    usage: Usage | None = None
    served: str = ""
    tidied: tuple[str, ...] = ()


@dataclass(slots=True, kw_only=True)
class Turn:
    """One finished exchange: a report, the remark with it, and the agent's decision after it."""

    percept: Percept
    decision: Decision
    remark: str = ""


@dataclass(slots=True, kw_only=True)
class Moment:
    """One moment of a trial for interventions, truth and report: the first look, or the result of an attempt.

    Attributes:
        was: What interventions act on, in the agent's terms: joint, outcome and positions, in truth, or as the source
            of the reports says them (:mod:`lockprobe.trial.source`).
        told: The final report or picture for the agent.
        chosen, attempted: Labels of the joint that the agent chose and of the one attempted; None for the first look.
        facts: The facts of the report before they became words or pictures; None if ``told`` holds them.
    """

    was: Percept
    told: Percept
    chosen: str | None = None
    attempted: str | None = None
    facts: Percept | None = None

    @property
    def reported(self) -> Percept:
        """The facts of the report, from which words or pictures were made."""
        return self.told if self.facts is None else self.facts

    @property
    def shown(self) -> tuple[bool, ...] | None:
        """The positions that the agent was told or that its pictures show; None if neither."""
        told = self.told.positions
        return self.reported.positions if told is None and self.told.pictures else told


@dataclass(frozen=True, slots=True, kw_only=True)
class Briefing:
    """The requests and remarks of one step, in addition to the report. Agents that read no words ignore them.

    ``remark`` comes with the report of this step, ``warning`` stands in the instruction. ``instruction`` is a template
    (:data:`lockprobe.agents.prompt.FIELDS`), and the default one if it is empty.
    """

    remark: str = ""
    warning: str = ""
    instruction: str = ""
    hypothesis: Ask = "before"

    def remarking(self, text: str) -> Briefing:
        """The briefing with one more remark."""
        return replace(self, remark=f"{self.remark} {text}".lstrip())


@dataclass(slots=True, kw_only=True)
class Situation:
    """Everything that an agent may use to decide: finished exchanges, oldest first, the current report and requests."""

    task: Task
    past: tuple[Turn, ...]
    percept: Percept
    briefing: Briefing = Briefing()

    @property
    def told(self) -> list[tuple[Percept, str]]:
        """All percepts that the agent still has, with the remarks that came with them, oldest first."""
        return [*((turn.percept, turn.remark) for turn in self.past), (self.percept, self.briefing.remark)]

    @property
    def outcome(self) -> Outcome | None:
        """What was told of the last attempt, also as positions imply it; None if nothing was."""
        return told_outcome(self.task, self.percept, self.past)


def told_outcome(task: Task, percept: Percept, past: Sequence[Turn]) -> Outcome | None:
    """The outcome that a report tells; where it tells positions alone, by comparison with the last ones in the past."""
    if percept.outcome is not None or percept.joint is None or percept.positions is None:
        return percept.outcome
    for turn in reversed(past):
        if (last := turn.percept.positions) is not None:
            joint = task.joints.index(percept.joint)
            return "moved" if percept.positions[joint] != last[joint] else "blocked"
    return None


@dataclass(frozen=True, kw_only=True)
class Step:
    """One step, truth and report.

    Attributes:
        step: From 1.
        state: True configuration before the step, a bit string in panel order.
        joint: The joint attempted, by its name in the box, and whether it really ``moved``.
        told_moved: The reported outcome of the attempt, also as positions imply it; None if nothing was reported.
        told_state: The reported configuration after the step, in panel order; None if not told, or truly pictured.
        told: The report after the step as the agent saw it.
        decision: The agent's answer; ``decision.claimed`` is about the *previous* step.
        sensed: A robot's measurements, including its own verdict (moved, blocked, failed), and the positions that a
            camera read, a bit string in panel order with ``?`` for an unclear joint, if reports have a named source.
        pictures: File names of the pictures taken afterwards, by kind.
        chosen: The joint that the agent chose, by its name, if another one was attempted; else None.
        remark: The remark to the agent with the report before this step.
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
    pictures: Mapping[PictureKind, PictureName] = field(default_factory=dict)
    chosen: str | None = None
    remark: str = ""

    @classmethod
    def of(cls, **values: Any) -> Step:
        """A step whose every value is given, in a third of the constructor's time."""
        step = object.__new__(cls)
        object.__setattr__(step, "__dict__", values)
        return step

    @property
    def told_falsely(self) -> bool:
        """Whether the report afterwards said the opposite of what happened."""
        return self.told_moved is not None and self.told_moved != self.moved


@dataclass(frozen=True, slots=True)
class TrialName:
    """A trial of a study, as its record and its calls name it: five parts between slashes, whatever the names hold.

    >>> str(TrialName("flips", "llm:openai/gpt-4o", "flip?p=0.4", repetition=2, trial=7))
    'flips/llm:openai%2Fgpt-4o/flip?p=0.4/rep=2/trial=7'

    ``agent`` is its name, or its spec if it has none; ``participant`` for people, who share its trials.
    """

    study: str
    agent: str
    condition: str
    repetition: int
    trial: int

    def __str__(self) -> str:
        names = "/".join(part.replace("/", "%2F") for part in (self.study, self.agent, self.condition))
        return f"{names}/rep={self.repetition}/trial={self.trial}"


@dataclass(frozen=True, slots=True, kw_only=True)
class ForkName:
    """A fork of a recorded trial, as its record names it.

    >>> str(ForkName(parent="flips/random/truth/rep=1/trial=7", at=8, arm="lie", time=2))
    'flips/random/truth/rep=1/trial=7/at=8/lie/time=2'

    ``parent`` is the key of the recorded trial, ``at`` the step whose report is changed, from 1, and ``time`` the
    number of this continuation, from 1. If it is ``truthful`` all later reports are true; else they are as in the
    trial's condition.
    """

    parent: str
    at: int
    arm: str
    truthful: bool = False
    time: int = 1

    def __str__(self) -> str:
        then = "/then=truth" if self.truthful else ""
        return f"{self.parent}/at={self.at}/{self.arm}{then}/time={self.time}"


@dataclass(frozen=True, slots=True, kw_only=True)
class TrialError:
    """The error that ended a trial, at a step that could not be played, from 1.

    Attributes:
        replies: Raw malformed replies, or the words of a refusal, if that was the reason; with their usage.
    """

    boundary: Boundary
    message: str
    step: Count
    replies: tuple[str, ...] = ()
    usage: Usage | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Trial:
    """One finished trial. The first names are those of its plan (:class:`lockprobe.trial.plan.Plan`).

    Attributes:
        key: Its :class:`~lockprobe.trial.record.TrialName`, for example ``flips/random/flip?p=0.4/rep=2/trial=7``.
        agent: Agent spec; of a person ``participant:ID``. ``called`` is the experimenter's name for it, if any.
        facts, plant: The facts of agent and plant: model, file hash, engine, settings; empty if their specs say all.
        condition: Label of its condition. ``specs`` are those of its interventions, in order, and ``doses`` those of
            them and of the modality that are not 0: ``{"flip.p": 0.4}``.
        channels, interventions: Those that act on reports, and all others, in order, each with its settings.
        joints, labels: Joint names, and the labels the agent knew them by, in panel order. ``target`` is a name.
        listing: The same labels in the order in which they were listed to the agent.
        opening: The report before the first step; ``opening_pictures`` and ``opening_sensed`` are as those of a step.
        ending: ``solved``, ``budget`` or ``error``. An error is never a failure to solve.
        changed: Spec of every intervention -> steps at which it changed what was told, asked, remembered or done;
            ``changed_steps`` are those at which all of them together did.
        fork: Of a fork, the recorded trial, the step and the arm; else None.
    """

    key: str
    study: str
    agent: str
    facts: Mapping[str, Fact]
    box: str
    condition: str
    modality: str
    channels: tuple[Mapping[str, Fact], ...]
    repetition: Count
    trial: Count
    seed: Whole
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
    opening_pictures: Mapping[PictureKind, PictureName] = field(default_factory=dict)
    assessment: bool = True
    hypothesis: Ask = "before"
    interventions: tuple[Mapping[str, Fact], ...] = ()
    specs: tuple[str, ...] = ()
    doses: Mapping[str, Finite] = field(default_factory=dict)
    changed: Mapping[str, Count] = field(default_factory=dict)
    changed_steps: Count = 0
    fork: ForkName | None = None
    called: str = ""
    opening_sensed: Mapping[str, Fact] = field(default_factory=dict)

    def __repr__(self) -> str:
        ending = f"error at {self.error.boundary}" if self.error else self.ending
        return f"<Trial {self.key}: {ending} after {len(self.steps)} of {self.budget} steps>"

    @property
    def solved(self) -> bool:
        """Whether the target moved."""
        return self.ending == "solved"

    @property
    def group(self) -> str:
        """What keys, tables and pages call its agent: its name, or its :attr:`spec` if it has none."""
        return self.called or self.spec

    @property
    def spec(self) -> str:
        """The spec of the agent that it counts for: its own, or ``participant`` for any person."""
        return group_of(self.agent)

    @property
    def player(self) -> str:
        """The person's spec: one cluster of trials. Empty for agents, whose trials are independent."""
        return self.agent if self.group == PEOPLE else ""

    @property
    def states_only(self) -> bool:
        """Whether reports or pictures gave only positions, never outcomes."""
        return bool(self.opening_pictures) or any(channel.get("tell") == "state" for channel in self.channels)

    @property
    def actions(self) -> tuple[str, ...]:
        """The joints attempted, in order."""
        return tuple(step.joint for step in self.steps)

    @property
    def said(self) -> tuple[Outcome | None, ...]:
        """What the agent said of each step, in the decision after it; None where nothing, as of the last step."""
        return (*(step.decision.claimed for step in self.steps[1:]), None)[: len(self.steps)]

    @property
    def picture_names(self) -> frozenset[str]:
        """File names of all pictures that were taken."""
        return frozenset(self.opening_pictures.values()).union(*(step.pictures.values() for step in self.steps))

    @property
    def p(self) -> float | None:
        """The flip rate, [0, 1], if one plain flip acted alone, 0 under the truth; else None."""
        return flip_rate(self.specs, self.modality, self.doses)

    @property
    def name(self) -> TrialName:
        """Its place in the study; of a fork that of its parent."""
        return TrialName(self.study, self.group, self.condition, self.repetition, self.trial)

    @property
    def owed_again(self) -> bool:
        """Whether it has to be played again: a fault outside the agent broke it."""
        return self.error is not None and self.error.boundary not in FINAL


def asked_again(trials: Iterable[Trial]) -> dict[str, tuple[int, int]]:
    """Agent -> replies after which it was asked again, and all its replies on record; agents without any are left out.

    After the last reply of a decision, and after one that ended a trial, nobody was asked again.
    """
    again, replies = Counter[str](), Counter[str]()
    for trial in trials:
        replied = [step.decision.replies for step in trial.steps] + ([trial.error.replies] if trial.error else [])
        replies[trial.group] += sum(map(len, replied))
        again[trial.group] += sum(len(one) - 1 for one in replied if one)
    return {agent: (number, replies[agent]) for agent, number in again.items() if number}
