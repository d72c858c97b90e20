"""The plants by spec. Heavy packages are imported only when a plant needs them.

Specs: ``symbolic``, ``fast-twin`` (the mechanism, pushed without an arm), ``twin`` (with arm, hand and force sensor),
``twin?model=FILE`` (a user's MuJoCo model, without an arm), ``manual`` (a person moves the joints of a real box),
``rig`` (the adapter of a real arm, rehearsed without it).
Options follow a question mark: ``twin?pose_error=0.004&looks=varied``. Installed packages add plants by an entry point
in the group ``lockprobe.plants``. ``python:module:Name`` names a class or function that is called with ``box``,
``labels`` (of its joints, in panel order), ``rng`` (the trial's stream ``plant``) and its options.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from functools import partial
from inspect import signature
from pathlib import Path

import numpy as np

from lockprobe.errors import BadValue, UnknownName
from lockprobe.lockbox.box import Lockbox
from lockprobe.plants.simulation import FilmHook, require_mujoco
from lockprobe.plants.symbolic import SymbolicPlant
from lockprobe.plants.twin_settings import CameraSettings, SceneSettings, TwinSettings, UserModelSettings
from lockprobe.plugins import Plugin, find_plugin, has_methods, is_own_function, plugin_names
from lockprobe.protocols import Plant
from lockprobe.spec import Spec, arguments_from, with_options

__all__ = ["PLANTS", "Make", "PlantSource", "known_plants", "resolve_plant", "with_camera"]

_SETTINGS: Mapping[str, type[SceneSettings]] = {"fast-twin": SceneSettings, "twin": TwinSettings}

PLANTS = ("symbolic", *_SETTINGS, "manual", "rig")

Make = Callable[[Lockbox, tuple[str, ...], np.random.Generator], Plant]

MakeFilmed = Callable[[Lockbox, tuple[str, ...], np.random.Generator, FilmHook], Plant]


@dataclass(frozen=True, slots=True, kw_only=True)
class PlantSource:
    """A resolved plant spec: how to build and check the plant.

    Attributes:
        spec: Its spec.
        settings: The settings of a simulated plant; None for any other plant.
        make: Builds it for one trial from the box, its joints' labels in panel order and the trial's stream ``plant``.
        check: Checks whether ``make`` works on this machine for a box; raises the same errors.
        make_filmed: Builds it for a film of its moving arm; None if there is nothing to film.
        photographs: Whether a real camera takes its pictures.
        painted_labels: Whether its pictures show labels that are painted on a real box, the same in every trial.
        is_attended: Whether somebody answers its questions at the terminal, so that trials run in this process one at a
            time. A plant of another package declares this by an attribute ``attended = True``.
        ships: Whether it is one of Lockprobe's own.
    """

    spec: str
    make: Make
    settings: CameraSettings | None = None
    check: Callable[[Lockbox], None] = lambda box: None
    make_filmed: MakeFilmed | None = None
    photographs: bool = False
    painted_labels: bool = False
    is_attended: Callable[[], bool] = lambda: False
    ships: bool = True

    @property
    def has_camera(self) -> bool:
        """Whether the plant can give pictures."""
        return self.settings is not None or self.photographs

    @property
    def lays_out(self) -> bool:
        """Whether the joints lie where the box says; not on a real panel, nor in a user's model."""
        return self.spec == "symbolic" or isinstance(self.settings, SceneSettings)


def known_plants() -> dict[str, str]:
    """Lockprobe's own plants, each with a description."""
    options = {name: ", ".join(field.name for field in fields(kind)) for name, kind in _SETTINGS.items()}
    model = ", ".join(field.name for field in fields(UserModelSettings))
    return {
        "symbolic": "The rules and nothing else.",
        "fast-twin": f"The mechanism, pushed without an arm, and a camera. Options: {options['fast-twin']}.",
        "twin": f"The same with a robot arm, a soft hand and a force sensor. Options: {options['twin']}. "
        f"A user's own model of the box, without an arm: {model}.",
        "manual": "A real box whose joints a person moves; the person or a camera tells the truth. Options: camera, "
        "handles, device.",
        "rig": "The adapter of a real arm, in rehearsal. Options: rung (scripted, twin, wire), truth (simulation, "
        "camera).",
    }


def resolve_plant(spec: str | Spec) -> PlantSource:
    """The plant that a spec names.

    Raises:
        UnknownName: If there is no such plant or option; the message lists what exists.
        BadValue: If an option has a value that it cannot have.
    """
    if not isinstance(spec, str | Spec):
        raise BadValue("plant", spec, f"one of {', '.join(PLANTS)}")
    spec = spec if isinstance(spec, Spec) else Spec.parse(spec, "plant")
    if spec.full_name == "twin" and "model" in spec.options:
        return _of_a_user(spec)
    if spec.full_name in _SETTINGS:
        settings = with_options(_SETTINGS[spec.full_name], spec.full_name, spec.options)
        make = _physical(settings)
        return PlantSource(
            spec=str(spec),
            settings=settings,
            make=make,
            make_filmed=partial(_filmed_twin, settings) if isinstance(settings, TwinSettings) else None,
            check=partial(_check, settings, make),
        )
    if spec.full_name == "symbolic":
        if spec.options:
            raise BadValue("plant", str(spec), "symbolic without options")
        return PlantSource(spec=str(spec), make=lambda box, labels, rng: SymbolicPlant(box))
    if spec.full_name == "manual":
        return _by_hand(spec)
    if spec.full_name == "rig":
        return _rehearsed(spec)
    if (plugin := find_plugin("plant", str(spec))) is not None:
        return _of_another_package(spec, plugin)
    raise UnknownName("plant", spec.full_name, [*PLANTS, *plugin_names("plant")])


def with_camera(plant: str, camera: str) -> Spec:
    """The spec of a plant with its option ``camera``, as if it had been written there.

    >>> str(with_camera("manual", "pictures"))
    'manual?camera=pictures'

    A plant of another package says itself, when it is made, whether it has the option.

    Raises:
        BadValue: If the plant has no such option, or its spec has another camera.
    """
    spec = Spec.parse(plant, "plant")
    if not camera:
        raise BadValue("camera", camera, "a folder, or webcam")
    if spec.full_name in PLANTS and spec.full_name != "manual":
        raise BadValue("camera", camera, f"--plant manual with it; {spec.full_name} has no such option")
    if spec.options.get("camera", camera) != camera:
        raise BadValue("camera", camera, f"none with {plant}, which has another")
    return spec if "camera" in spec.options else spec.with_value("camera", camera)


def _of_a_user(spec: Spec) -> PlantSource:
    """The plant of a user's model. Its spec includes the digest of the files, to detect a changed model."""
    settings = with_options(UserModelSettings, "twin?model", spec.options)
    if not settings.digest:
        from lockprobe.plants.user_model.mjcf_file import read_model

        return _of_a_user(spec.appending("digest", read_model(Path(settings.model), settings.folder).digest))

    def make(box: Lockbox, labels: tuple[str, ...], rng: np.random.Generator) -> Plant:
        from lockprobe.plants.user_model.user_model import UserModel

        return UserModel(box, labels=labels, settings=settings, rng=rng)

    def check(box: Lockbox) -> None:
        _check_renderer(settings)
        from lockprobe.plants.user_model.user_model import check_model

        check_model(box, settings)

    return PlantSource(spec=str(spec), settings=settings, make=make, check=check)


def _rehearsed(spec: Spec) -> PlantSource:
    from lockprobe.plants.rehearsal_settings import RehearsalSettings

    settings = with_options(RehearsalSettings, "rig", spec.options)

    def make(box: Lockbox, labels: tuple[str, ...], rng: np.random.Generator, film: FilmHook | None = None) -> Plant:
        from lockprobe.plants.hardware.rehearsal import rehearse_rig

        return rehearse_rig(settings, box, labels, rng, film)

    return PlantSource(
        spec=str(spec),
        make=make,
        make_filmed=None if settings.rung == "scripted" else make,
        check=lambda box: make(box, box.names, np.random.default_rng(0)).close(),
        photographs=settings.truth == "camera",
        is_attended=lambda: settings.rung == "wire",  # one at a time: it keeps time as a robot does
    )


def _by_hand(spec: Spec) -> PlantSource:
    from lockprobe.plants.manual import ManualSettings, check_manual, make_manual

    settings = with_options(ManualSettings, "manual", spec.options)
    return PlantSource(
        spec=str(spec),
        make=lambda box, labels, rng: make_manual(settings, box, labels),
        check=partial(check_manual, settings),
        photographs=bool(settings.camera),
        painted_labels=bool(settings.camera),
        is_attended=lambda: True,
    )


_EXPECTED = "a class with `facts`, `observe()`, `attempt(joint)` and `close()`, or a function of box, labels and rng"


def _makes_plants(found: Callable[..., object], given: Mapping[str, object]) -> bool:
    """Whether it is a class of plants, or a function of what a plant is made from; it is not called yet."""
    if not is_own_function(found):
        return has_methods(found, "observe", "attempt", "close")
    return given.keys() <= signature(found).parameters.keys()


def _of_another_package(spec: Spec, plugin: Plugin) -> PlantSource:
    """A plant from another package, which is imported when the plant is made or checked."""

    def make(box: Lockbox, labels: tuple[str, ...], rng: np.random.Generator) -> Plant:
        # not guarded: an error here breaks one trial, not the study
        kind, given = plugin.load(), {"box": box, "labels": labels, "rng": rng}
        if not _makes_plants(kind, given):
            raise BadValue("plant", str(spec), _EXPECTED)
        made: Plant = kind(**given, **arguments_from(kind, plugin.name, spec.options, given))
        return made

    def check(box: Lockbox) -> None:
        with plugin.guarded():
            plant = make(box, box.names, np.random.default_rng(0))
            is_one = isinstance(plant, Plant)
            if is_one:
                plant.close()
        if not is_one:
            raise BadValue("plant", str(spec), _EXPECTED)

    return PlantSource(
        spec=str(spec),
        make=make,
        check=check,
        is_attended=lambda: getattr(plugin.load(), "attended", False) is True,
        ships=False,
    )


def _physical(settings: SceneSettings) -> Make:
    def make(box: Lockbox, labels: tuple[str, ...], rng: np.random.Generator) -> Plant:
        if isinstance(settings, TwinSettings):
            from lockprobe.plants.twin import Twin

            return Twin(box, labels=labels, settings=settings, rng=rng)
        from lockprobe.plants.fast_twin import FastTwin

        return FastTwin(box, labels=labels, settings=settings, rng=rng)

    return make


def _filmed_twin(
    settings: TwinSettings, box: Lockbox, labels: tuple[str, ...], rng: np.random.Generator, film: FilmHook
) -> Plant:
    from lockprobe.plants.twin import Twin

    return Twin(box, labels=labels, settings=settings, rng=rng, film=film)


def _check(settings: SceneSettings, make: Make, box: Lockbox) -> None:
    """Refuse a plant that this machine cannot simulate or draw, and a box that cannot be built or reached."""
    _check_renderer(settings)
    make(box, box.names, np.random.default_rng(0)).close()


def _check_renderer(settings: CameraSettings) -> None:
    require_mujoco()
    from lockprobe.plants.rendering.choose_renderer import decide

    decide(settings.renderer)
