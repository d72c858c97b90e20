"""The design of a study, from its conditions alone: controls, axes, what is crossed, and the families of its contrasts.

Every contrast belongs to one family. The doses of an axis against its control are one: the flip rates of a modality,
and every dose with three levels or more of another intervention or another kind of flips. All other conditions of a
modality against its control are one, and so are the controls of the other modalities against that of the first; the
interactions of all that is crossed are one. So what is said of one family does not depend on the conditions of
another. Of another intervention a single dose is a condition like any other: with an axis of its own, ten conditions
would be ten families.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

from lockprobe.foundation.grouping import grouped
from lockprobe.statistics.conditions.axis import FLIPS, Series, SeriesArm, series_of, series_of_agents
from lockprobe.statistics.conditions.crossed import Crossed, crossed_of
from lockprobe.statistics.conditions.factors import Factor, factors_of, no_feedback_factor
from lockprobe.statistics.why.arms import arms_of


@dataclass(frozen=True, slots=True, kw_only=True)
class Comparison:
    """The conditions of one modality and what they are compared with.

    Attributes:
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


@dataclass(frozen=True, kw_only=True)
class Design:
    """What differs between the conditions of a study.

    Attributes:
        agents: What tables call the agents.
        axis: Labels of the conditions that differ in flip rate and modality alone, the truth among them.
        specs: Agent -> its spec, of those that are called otherwise.
    """

    agents: tuple[str, ...]
    arms: tuple[SeriesArm, ...]
    axis: frozenset[str]
    specs: Mapping[str, str] = field(default_factory=dict)

    def spec_of(self, agent: str) -> str:
        """The spec of an agent."""
        return self.specs.get(agent, agent)

    @cached_property
    def _shown(self) -> Mapping[str, list[SeriesArm]]:
        return grouped(self.arms, lambda arm: arm.modality)

    def shown(self, modality: str) -> Sequence[SeriesArm]:
        """The conditions of a modality."""
        return self._shown[modality]

    @property
    def modalities(self) -> tuple[str, ...]:
        """How the box is shown, without doses, each way once."""
        return tuple(self._shown)

    @cached_property
    def _controls(self) -> Mapping[str, str]:
        """Modality -> its control: the condition without interventions, or else the first."""
        return {name: next((arm for arm in own if not arm.acting), own[0]).label for name, own in self._shown.items()}

    @property
    def controls(self) -> frozenset[str]:
        """The labels of all controls."""
        return frozenset(self._controls.values())

    def control(self, label: str) -> str:
        """The label of the control of a condition."""
        return next(self._controls[arm.modality] for arm in self.arms if arm.label == label)

    @cached_property
    def series(self) -> tuple[Series, ...]:
        """Other doses than flip rates, of three levels or more, and options of agents."""
        doses = [one for one in series_of(self.arms) if not one.doses.keys() <= self.axis]
        # flips without options are of another reading beside the flip axis, which their name says
        other = replace(FLIPS, options="others=fresh")
        named = (replace(one, axis=other) if one.axis == FLIPS else one for one in doses)
        return (*named, *series_of_agents({agent: self.spec_of(agent) for agent in self.agents}))

    @cached_property
    def comparisons(self) -> Mapping[str, Comparison]:
        """Modality -> its conditions, by the families of their contrasts with its control."""
        found = dict[str, Comparison]()
        for modality, control in self._controls.items():
            own = self._shown[modality]
            axes = tuple(
                one for one in self.series if (one.modality, one.agent) == (modality, "") and control in one.doses
            )
            rest = [arm.label for arm in own if arm.label != control]
            on_axes = self.axis.union(*(one.doses for one in axes))
            found[modality] = Comparison(
                control=control,
                flips=tuple(label for label in rest if label in self.axis),
                axes=axes,
                others=tuple(label for label in rest if label not in on_axes),
                controls=() if found else tuple(self._controls.values())[1:],
                crossed=tuple(crossed_of(own)),
            )
        return found

    @property
    def other_axes(self) -> tuple[Series, ...]:
        """The doses of other interventions that are families of their own, in every modality."""
        return tuple(axis for of in self.comparisons.values() for axis in of.axes)

    @cached_property
    def factors(self) -> tuple[Factor, ...]:
        """Options that are no numbers, in which conditions differ alone.

        Those on the axis of a dose are none, nor what the arms of a study of controls say first and last.
        """
        dosed = [set(one.doses) for one in self.series if not one.agent]
        dosed += [set(arms[1].values()) for shown in self._shown.values() if (arms := arms_of(shown))]
        found = []
        for name, groups in factors_of(self.arms, self.controls):
            if apart := tuple(group for group in groups if not any(of >= {*group} for of in dosed)):
                found.append(Factor(name, apart))
        return tuple(found)

    @property
    def no_feedback(self) -> tuple[Factor, ...]:
        """False reports against no report at all, in each modality that has both."""
        return tuple(one for shown in self._shown.values() for one in no_feedback_factor(shown))
