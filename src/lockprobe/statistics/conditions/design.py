"""The design of a study, from its conditions alone: controls, axes, what is crossed, and the families of its contrasts.

Every contrast belongs to one family. The doses of an axis against its control are one: the flip rates of a modality,
and every dose with three levels or more of another intervention or another kind of flips. All other conditions of a
modality against its control are one, and so are the controls of the other modalities against that of the first; the
interactions of all that is crossed are one. So what is said of one family does not depend on the conditions of
another. Of another intervention a single dose is a condition like any other: with an axis of its own, ten conditions
would be ten families.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from lockprobe.statistics.conditions.axis import FLIPS
from lockprobe.statistics.conditions.crossed import Crossed, crossed_of
from lockprobe.statistics.conditions.factors import Factor, factors_of, no_feedback_factor
from lockprobe.statistics.conditions.series import Series, SeriesArm, control_of, series_of, series_of_agents
from lockprobe.statistics.why.arms import arms_of


@dataclass(frozen=True, slots=True, kw_only=True)
class Comparison:
    """The conditions of one modality and what they are compared with.

    Attributes:
        control: Label of the control.
        flips: Labels of the flip rates that act: the family of the flip axis.
        axes: Doses of other interventions whose lowest level is the control, each a family of its own.
        others: Labels of all other conditions: another family.
        controls: In the first modality the labels of the controls of the others: a family too.
        crossed: Two interventions alone, together and not at all, then crossed doses.
    """

    control: str
    flips: tuple[str, ...]
    axes: tuple[Series, ...]
    others: tuple[str, ...]
    controls: tuple[str, ...]
    crossed: tuple[Crossed, ...]

    @property
    def labels(self) -> tuple[str, ...]:
        """All its conditions, the control first."""
        return (self.control, *self.flips, *self.dosed, *self.others, *self.controls)

    @property
    def dosed(self) -> tuple[str, ...]:
        """Labels of the doses of its other axes."""
        return tuple(label for axis in self.axes for label in axis.doses if label != self.control)


@dataclass(frozen=True, slots=True, kw_only=True)
class Design:
    """What differs between the conditions of a study.

    Attributes:
        agents: What tables call the agents.
        arms: The conditions as their specs tell them, in the order of the study.
        axis: Labels of the conditions that differ in flip rate and modality alone, the truth among them.
        specs: Agent -> its spec, of those that are called otherwise.
    """

    agents: tuple[str, ...]
    arms: tuple[SeriesArm, ...]
    axis: frozenset[str]
    specs: Mapping[str, str] = field(default_factory=dict)
    _controls: dict[str, SeriesArm] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        found = {modality: control_of(self.arms, modality) for modality in dict.fromkeys(a.modality for a in self.arms)}
        object.__setattr__(self, "_controls", {name: one for name, one in found.items() if one is not None})

    def spec_of(self, agent: str) -> str:
        """The spec of an agent."""
        return self.specs.get(agent, agent)

    @property
    def modalities(self) -> tuple[str, ...]:
        """How the box is shown, without doses, each way once."""
        return tuple(self._controls)

    def shown(self, modality: str) -> tuple[SeriesArm, ...]:
        """The conditions of a modality."""
        return tuple(arm for arm in self.arms if arm.modality == modality)

    def control(self, label: str) -> str:
        """The label of the control of a condition."""
        arm = next(arm for arm in self.arms if arm.label == label)
        return self._controls[arm.modality].label

    @property
    def controls(self) -> frozenset[str]:
        """The labels of all controls."""
        return frozenset(arm.label for arm in self._controls.values())

    def comparison(self, modality: str) -> Comparison:
        """The conditions of a modality and the families of their contrasts with its control."""
        own, control = self.shown(modality), self._controls[modality].label
        beside = tuple(self._controls[name].label for name in self.modalities[1:])
        rest = [arm.label for arm in own if arm.label != control]
        axes = tuple(one for one in self.series if not one.agent and one.modality == modality and control in one.doses)
        on_axes = self.axis | {label for one in axes for label in one.doses}
        return Comparison(
            control=control,
            flips=tuple(label for label in rest if label in self.axis),
            axes=axes,
            others=tuple(label for label in rest if label not in on_axes),
            controls=beside if modality == self.modalities[0] else (),
            crossed=tuple(crossed_of(own)),
        )

    @property
    def other_axes(self) -> tuple[Series, ...]:
        """The doses of other interventions that are families of their own, in every modality."""
        return tuple(axis for modality in self.modalities for axis in self.comparison(modality).axes)

    @property
    def factors(self) -> tuple[Factor, ...]:
        """Options that are no numbers, in which conditions differ alone.

        Those on the axis of a dose are none, nor what the arms of a study of controls say first and last.
        """
        dosed = [set(one.doses) for one in self.series if not one.agent]
        dosed += [set(arms[1].values()) for shown in map(self.shown, self.modalities) if (arms := arms_of(shown))]
        found = (
            Factor(one.name, tuple(group for group in one.groups if not any(of >= {*group} for of in dosed)))
            for one in factors_of(self.arms, self.controls)
        )
        return tuple(one for one in found if one.groups)

    @property
    def no_feedback(self) -> tuple[Factor, ...]:
        """False reports against no report at all, in each modality that has both."""
        return tuple(one for modality in self.modalities for one in no_feedback_factor(self.shown(modality)))

    @property
    def series(self) -> tuple[Series, ...]:
        """Other doses than flip rates, of three levels or more, and options of agents."""
        doses = (_named(one) for one in series_of(self.arms) if not one.doses.keys() <= self.axis)
        return (*doses, *series_of_agents({agent: self.spec_of(agent) for agent in self.agents}))


def _named(one: Series) -> Series:
    """A series beside the flip axis. Flips without options are of another reading there, which its name says."""
    return replace(one, axis=replace(FLIPS, options="others=fresh")) if one.axis == FLIPS else one
