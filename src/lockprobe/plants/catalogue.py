"""The plants by spec.

Specs: ``symbolic`` and ``manual`` (a person moves the joints of a real box) are here. The distribution
``lockprobe-robot`` adds ``fast-twin`` (the mechanism, pushed without an arm), ``twin`` (with arm, hand and force
sensor), ``twin?model=FILE`` (a user's MuJoCo model), ``rig`` (the adapter of a real arm, rehearsed
without it) and a camera for ``manual``. Options follow a question mark: ``twin?pose_error=0.004&looks=varied``.

Installed packages add plants by an entry point in the group ``lockprobe.plants``. It names a class or function that is
called with ``box``, ``labels`` (of its joints, in panel order), ``rng`` (the trial's stream ``plant``) and its options;
``python:module:Name`` names it directly. A plant that has a camera, or that checks something before the first trial, is
an entry point in the group ``lockprobe.plant_sources``: a function of the spec that returns a :class:`PlantSource`,
which may also say which options a condition can change, and which of them are doses.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from inspect import signature
from typing import Any

import numpy as np

from lockprobe.boxes.box import Lockbox
from lockprobe.foundation.errors import BadValue, Missing, UnknownName
from lockprobe.foundation.plugins import (
    Plugin,
    docstring,
    find_plugin,
    has_methods,
    is_own_function,
    plugin_names,
    robot_plugin,
    runs_foreign_code,
)
from lockprobe.foundation.spec import Spec, arguments_from
from lockprobe.plants.manual import Manual, TerminalOperator
from lockprobe.plants.symbolic import SymbolicPlant
from lockprobe.trial.condition import PlantChange
from lockprobe.trial.plan import Plan
from lockprobe.trial.protocols import Plant

PLANTS: Mapping[str, str] = {
    "symbolic": "The rules and nothing else.",
    "fast-twin": "",
    "twin": "",
    "manual": "A real box whose joints a person moves; the person or a camera tells the truth. Option of "
    "lockprobe-robot: camera.",
    "rig": "",
}
"""Lockprobe's own, each with what it is; lockprobe-robot adds the others, which say it themselves."""

Make = Callable[[Lockbox, tuple[str, ...], np.random.Generator], Plant]

FilmHook = Callable[[Any, Any], None]
"""Called 25 times in a simulated second with MuJoCo's model and a state, which it must not change."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PlantSource:
    """A resolved plant spec: how to build and check the plant.

    Attributes:
        make: Builds it for one trial from the box, its joints' labels in panel order and the trial's stream ``plant``.
        check: Checks whether ``make`` works on this machine for a box; raises the same errors.
        picture_size: Width and height of simulated pictures, pixels; None if no camera is simulated.
        make_filmed: Builds it for a film of its moving arm; None if there is nothing to film.
        photographs: Whether a real camera takes its pictures, on which labels are painted, the same in every trial.
        has_arm: Whether an arm acts on the box, whose verdict on every attempt is ``sensed["verdict"]``.
        lays_out: Whether the joints lie where the box says, whatever it says. False for a rigid panel, real or a user's
            model, which nobody can deal anew; None if the plant does not say.
        is_attended: Whether somebody answers its questions at the terminal
            (:class:`lockprobe.trial.protocols.Plant`).
        ships: Whether it is one of Lockprobe's own.
        options: The options that a condition may change -> the value of each, in words; None for any, of a package that
            does not say which there are.
        doses: Those of them that are doses: numbers over which curves can be drawn.
    """

    spec: str
    make: Make
    check: Callable[[Lockbox], None] = lambda box: None
    picture_size: tuple[int, int] | None = None
    make_filmed: Callable[[Lockbox, tuple[str, ...], np.random.Generator, FilmHook], Plant] | None = None
    photographs: bool = False
    has_arm: bool = False
    lays_out: bool | None = None
    is_attended: Callable[[], bool] = lambda: False
    ships: bool = True
    options: Mapping[str, str] | None = None
    doses: tuple[str, ...] = ()

    @property
    def has_camera(self) -> bool:
        """Whether the plant can give pictures."""
        return self.picture_size is not None or self.photographs


_HERE = {
    "symbolic": PlantSource(
        spec="symbolic", make=lambda box, labels, rng: SymbolicPlant(box), lays_out=True, options={}
    ),
    "manual": PlantSource(
        spec="manual",
        make=lambda box, labels, rng: Manual(box, labels=labels, operator=TerminalOperator()),
        lays_out=False,
        is_attended=lambda: True,
        options={},
    ),
}


def known_plants() -> dict[str, str]:
    """Lockprobe's own plants, each with a description, or what has to be installed for it."""
    found = dict[str, str]()
    for name, said in PLANTS.items():
        try:
            found[name] = said or " ".join(docstring(_of_robot(name).load()).split())
        except Missing as missing:
            found[name] = str(missing)
    return found


def _of_robot(plant: str) -> Plugin:
    return robot_plugin("plant source", plant, f"the plant {plant} needs")


def plant_of(plan: Plan) -> Plant:
    """The plant of one trial."""
    luck = plan.luck  # the symbolic box draws nothing: a generator for it would take as long as three steps
    rng = luck.generator if plan.plant == "symbolic" else luck.physics()
    return resolve_plant(plan.plant).make(plan.box, plan.names.labels, rng)


def resolve_plant(spec: str | Spec) -> PlantSource:
    """The plant that a spec names."""
    if (here := _HERE.get(str(spec))) is not None:
        return here
    spec = spec if isinstance(spec, Spec) else Spec.parse(spec, "plant")
    if spec.full_name == "symbolic":
        raise BadValue("plant", str(spec), "symbolic without options")
    if spec.full_name in PLANTS:
        ours: PlantSource = _of_robot(str(spec)).load()(spec)
        return ours
    if (plugin := find_plugin("plant source", str(spec))) is not None and plugin.package:
        if not runs_foreign_code():  # then it says nothing of itself
            refused = plugin
            return PlantSource(spec=str(spec), make=lambda box, labels, rng: refused.load(), ships=False)
        with plugin.guarded():
            source = plugin.load()(spec)
        if not isinstance(source, PlantSource):
            raise BadValue("plant source", str(spec), "a function of spec that returns a PlantSource")
        return replace(source, ships=False)
    if (plugin := find_plugin("plant", str(spec))) is not None:
        return _of_a_maker(spec, plugin)
    raise UnknownName("plant", spec.full_name, [*PLANTS, *plugin_names("plant"), *plugin_names("plant source")])


def _of_a_maker(spec: Spec, plugin: Plugin) -> PlantSource:
    """A plant of another package, which is imported when the plant is made or checked."""
    expected = "a class with `facts`, `observe()`, `attempt(joint)` and `close()`, or a function of box, labels and rng"

    def make(box: Lockbox, labels: tuple[str, ...], rng: np.random.Generator) -> Plant:
        # not guarded: an error here breaks one trial, not the study
        kind, given = plugin.load(), {"box": box, "labels": labels, "rng": rng}
        if is_own_function(kind):
            fits = given.keys() <= signature(kind).parameters.keys()
        else:
            fits = has_methods(kind, "observe", "attempt", "close")
        if not fits:
            raise BadValue("plant", str(spec), expected)
        made: Plant = kind(**given, **arguments_from(kind, plugin.name, spec.options, given))
        return made

    def check(box: Lockbox) -> None:
        with plugin.guarded():
            plant = make(box, box.names, np.random.default_rng(0))
            if not isinstance(plant, Plant):
                raise BadValue("plant", str(spec), expected)
            plant.close()

    return PlantSource(
        spec=str(spec),
        make=make,
        check=check,
        is_attended=lambda: getattr(plugin.load(), "attended", False),
        ships=False,
    )


def plant_change(plant: str | PlantSource, asked: Mapping[str, str]) -> PlantChange:
    """What a condition changes of the study's plant: of what it asks for the options that differ, each in one writing.

    >>> plant_change("twin", {"pose_error": "0.010", "looks": "plain"}).options
    {'pose_error': '0.01'}
    """
    if not asked:
        return PlantChange()
    own = plant if isinstance(plant, PlantSource) else resolve_plant(plant)
    spec = Spec.parse(own.spec, "plant")
    if own.options is None:  # a plant of another package, which does not say what it has
        known: Mapping[str, str] = spec.options
        there = dict(asked)
    else:
        known = own.options
        for option in asked:
            if option not in known:
                raise UnknownName(f"option of {spec.full_name}", option, known or ["none"])
        there = dict(resolve_plant(spec.adding(asked)).options or {})
    changed = {option: there[option] for option in sorted(asked) if there[option] != known.get(option)}
    return PlantChange(options=changed, own={option: float(known[option]) for option in changed if option in own.doses})
