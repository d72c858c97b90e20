"""What is refused when a study is made."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING

from lockprobe.foundation.errors import BadValue, UnknownName
from lockprobe.foundation.grouping import grouped
from lockprobe.foundation.spec import PEOPLE
from lockprobe.plants.catalogue import plant_change, resolve_plant
from lockprobe.studies.modality import check_distinct, check_shown, is_pictured
from lockprobe.studies.running.playable import PERSON, check_playable
from lockprobe.trial.condition import Condition, Contrast
from lockprobe.trial.doses import DOSES_SAID, can_be_fitted

if TYPE_CHECKING:
    from lockprobe.studies.study import Study

_CLOSEST_P = 1e-6

_LONGEST_CONTRAST = 100
"""Characters of the name of a contrast."""


def check_boxes(study: Study) -> None:
    """Refuse boxes that cannot be told apart, and several of them where only one has a meaning."""
    names = [box.name for box in study.boxes]
    if not names or len(set(names)) < len(names):
        raise BadValue("box", ", ".join(names), "at least one, and every one once")
    if len(names) > 1 and study.until:
        expected = "none with several boxes: what holds at every look is computed for one"
        raise BadValue("until", str(study.until), expected)


def check_people(study: Study) -> None:
    """Refuse what people cannot play."""
    if PEOPLE in study.agents:
        check_playable((one for one in study.conditions if not one.is_recorded), PERSON)
        if study.until:
            raise BadValue("until", str(study.until), "none with people, who are compared at one look")


def check_sizes(study: Study) -> None:
    """Refuse earlier plans that are larger."""
    for one in study.earlier:
        for name in ("repetitions", "trials"):
            planned, most = getattr(one, name), getattr(study, name)
            if not 1 <= planned <= most:
                raise BadValue(f"{name} of an earlier plan", planned, f"from 1 to {most}, the present number")


def check_contrasts(contrasts: Mapping[str, Contrast], labels: Sequence[str]) -> None:
    """Refuse contrasts that have no name, name unknown conditions, or have one on both sides."""
    for name, one in contrasts.items():
        if not name.strip() or len(name) > _LONGEST_CONTRAST:
            raise BadValue("contrasts", name, f"a name of 1 to {_LONGEST_CONTRAST} characters")
        for label in (*one.of, *one.minus):
            if label not in labels:
                raise UnknownName(f"condition of the contrast {name}", label, labels)
        if both := {*one.of} & {*one.minus}:
            raise BadValue(f"contrasts, {name}", min(both), "every condition on one side alone")


def check_doses(conditions: Sequence[Condition], p: Sequence[float]) -> None:
    """Refuse flip rates that are almost equal, and doses that no curve can be fitted to."""
    rates = sorted(p)
    close = any(second - first < _CLOSEST_P for first, second in pairwise(rates))
    if close or len({f"{rate:g}" for rate in rates}) < len(rates):
        raise BadValue("p", list(p), "values that differ by 0.000001 or more, within six digits")
    for one in conditions:
        for name, dose in one.doses.items():
            if not can_be_fitted(dose):
                raise BadValue(f"{name} of {one.label}", dose, DOSES_SAID)


def check_plant(study: Study) -> None:
    """Refuse what the plant of a condition cannot show, and changes that the study's plant does not allow."""
    own, shown = resolve_plant(study.plant), grouped(study.conditions, study.plant_of)
    check_distinct(study.modalities)
    for spec, conditions in shown.items():
        plant = resolve_plant(spec)
        check_shown(conditions, plant)
        if study.shuffle != "never" and plant.painted_labels and any(is_pictured(one.modality) for one in conditions):
            expected = "never with pictures of a real box, on which labels are painted"
            raise BadValue("shuffle", study.shuffle, expected)
        if study.layout != "fixed" and plant.lays_out is False:
            raise BadValue("layout", study.layout, f"fixed with {plant.spec}, whose joints stay where they are")
    for one in study.conditions:
        if own.ships and (change := plant_change(own, one.plant.options)) != one.plant:
            got, expected = (f"{part.spec or 'none'}, {dict(part.own)}" for part in (one.plant, change))
            raise BadValue(f"plant of {one.label}", got, expected)
