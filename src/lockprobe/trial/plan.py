"""The plan of one trial: who plays which box under which condition, with which luck."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from lockprobe.boxes.box import Lockbox, Shuffle
from lockprobe.foundation.spec import group_of
from lockprobe.trial.condition import Condition
from lockprobe.trial.labels import Names
from lockprobe.trial.luck import Luck
from lockprobe.trial.protocols import Intervention
from lockprobe.trial.record import Ask, ForkName, Step, TrialName


@dataclass(frozen=True, slots=True, kw_only=True)
class Fork:
    """A fork of a recorded trial: one report, or the next action, is changed, and the agent plays on.

    Up to the report of step ``at`` the trial is the one on record. What its condition tells is replaced in that report
    by the truth, on which the arm acts.

    ``condition`` is the label of that of the forked trial, ``acting`` the intervention of the arm on the report, or on
    the action after it, and ``recorded`` are the recorded steps.
    """

    name: ForkName
    condition: str
    acting: tuple[Intervention, ...]
    recorded: tuple[Step, ...]

    def replaces(self, step: int) -> bool:
        """Whether the arm acts on the true report of this step, from 1, whatever the condition tells."""
        return step == self.name.at or (self.name.truthful and step > self.name.at)


@dataclass(frozen=True, kw_only=True)
class Plan:
    """The plan of one trial, which has a number and a repetition from 1.

    Attributes:
        agent: Agent spec; ``called`` is the name that the experimenter gave it, empty without one.
        seed: Seed of the study.
        budget: Steps; 20 in the paper.
        plant: The plant's spec.
        shuffle: How often labels are assigned to joints, and listed, in random order. With ``never`` the labels run
            along the panel, and a model's preference for a name or a list position is confounded with the box.
        assessment: Whether the agent is asked what its last action did.
        hypothesis: When the agent is asked how the box works, unless an intervention says otherwise.
        fork: The fork of a recorded trial; None for an ordinary trial.
    """

    study: str
    agent: str
    box: Lockbox
    condition: Condition
    repetition: int
    trial: int
    seed: int
    budget: int = 20
    plant: str = "symbolic"
    shuffle: Shuffle = "trial"
    assessment: bool = True
    hypothesis: Ask = "before"
    fork: Fork | None = None
    called: str = ""

    @cached_property
    def key(self) -> str:
        """The readable name of its record."""
        return str(self.name if self.fork is None else self.fork.name)

    @property
    def group(self) -> str:
        """What keys call its agent, as :attr:`lockprobe.trial.record.Trial.group`."""
        return self.called or group_of(self.agent)

    @property
    def name(self) -> TrialName:
        """Its place in the study; of a fork that of its parent."""
        return TrialName(self.study, self.group, self.label, self.repetition, self.trial)

    @property
    def label(self) -> str:
        """The label of its condition; of a fork that of its parent, to which the arm adds."""
        return self.condition.label if self.fork is None else self.fork.condition

    @property
    def modality(self) -> str:
        """How the box is shown."""
        return self.condition.modality

    @cached_property
    def luck(self) -> Luck:
        """The luck of the trial. It depends on seed, box, repetition and trial, not on the condition."""
        return Luck(seed=self.seed, box=self.box.name, repetition=self.repetition, trial=self.trial)

    @cached_property
    def names(self) -> Names:
        """The names of its joints for the agent."""
        return Names(
            self.box,
            shuffle=self.shuffle,
            seed=self.seed,
            luck=self.luck,
            budget=self.budget,
            assessment=self.assessment,
        )
