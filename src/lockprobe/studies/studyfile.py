"""A study in a TOML file, and the one place where a request becomes a :class:`Study`.

::

    study = "flips"
    agent = ["llm:local", "random"]
    p = [0, 0.4]
    trials = 5

Every key is an option of ``lockprobe run`` of the same name. An option on the command line goes before the file.
A study file is data from anyone: it cannot name what runs code.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, TypeVar

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, ValidationError

from lockprobe.agents.catalogue import resolve
from lockprobe.errors import BadFile, BadValue, UnknownName
from lockprobe.inputs import read_toml
from lockprobe.interventions.flip import FlipKind
from lockprobe.lockbox.families import find_box
from lockprobe.plants.catalogue import resolve_plant
from lockprobe.plugins import refuse_python
from lockprobe.studies import paper
from lockprobe.studies.modality import SYMBOLIC, taken_in
from lockprobe.studies.study import LayoutKind, Study
from lockprobe.validation import plain

__all__ = ["SHIPPED", "STUDIES", "Request", "parse_p", "read_request", "study"]

STUDIES = ("flips", "modalities")

SHIPPED = ("mechanisms.toml",)
"""Study files that come with the package. One of the same name in the working directory goes before."""

LONGEST_SPEC = 1000
"""Characters of the spec of an agent, a plant or a modality."""

_T = TypeVar("_T")


Several = Annotated[
    list[str],
    Field(max_length=64),
    BeforeValidator(lambda given: [given] if isinstance(given, str) else given),
]
"""One, or a list of them."""


class Request(BaseModel):
    """What a user asks for; what is left out follows the study's own default."""

    model_config = ConfigDict(extra="forbid")

    study: str = "flips"
    agent: Several | None = None
    box: str | None = None
    p: Annotated[list[float], Field(max_length=1000)] | None = None
    trials: int | None = None
    repetitions: int | None = None
    seed: int | None = None
    max_steps: int | None = None
    flip: FlipKind | None = None
    plant: str | None = None
    modality: Several | None = None
    layout: LayoutKind | None = None
    shuffle: bool | None = None
    assessment: bool | None = None
    full: bool = False


def read_request(path: Path) -> Request:
    """The study in a TOML file: a user's, or one that ships (:data:`SHIPPED`), by its bare name.

    Raises:
        BadFile: If it is not one, with the key that is wrong.
    """
    if str(path) in SHIPPED and not path.exists():
        path = Path(__file__).with_name(path.name)
    try:
        request = Request.model_validate(read_toml(path))
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(map(str, first["loc"]))
        known = f"; keys are {', '.join(Request.model_fields)}" if first["type"] == "extra_forbidden" else ""
        raise BadFile(path, f"{where}: {plain(first['msg'])}{known}") from None
    for what, specs in (("agent", request.agent or ()), ("plant", [request.plant]), ("box", [request.box])):
        refuse_python(path, what, specs)
    return request


def study(request: Request | str = "flips") -> Study:
    """The study that a request, a TOML file, or a bare name with all defaults describes.

    A request for flips that says nothing of ``p``, ``trials``, ``repetitions`` and ``full`` gets the short extent; as
    soon as it says something, what it leaves out follows the paper. The modality study is always of the paper's
    extent, on a panel that is dealt anew in every trial; on a plant without a camera it has no pictures.

    Raises:
        UserMistake: If anything in it does not exist or is out of range.
    """
    if isinstance(request, str):
        request = read_request(Path(request)) if request.endswith(".toml") else Request(study=request)
    if request.study not in STUDIES:
        raise UnknownName("study", request.study, [*STUDIES, *SHIPPED, "FILE.toml"])
    modal = request.study == "modalities"
    plant = _given(request.plant, paper.ROBOT if modal else "symbolic")
    modalities = tuple(_given(request.modality, _shown_by_default(plant, modal=modal)))
    extent = paper.MODALITY_TRIALS if modal else _flips_extent(request)
    agents = request.agent if request.agent is not None else _players_by_default(modalities, modal=modal)
    for what, specs in (("agent", agents), ("plant", [plant]), ("modality", modalities)):
        _check_lengths(what, specs)
    for spec in agents:
        resolve(spec)
    planned = Study(
        name=request.study,
        agents=tuple(agents),
        box=find_box(_given(request.box, paper.BOX)),
        p=extent.p if request.p is None else tuple(request.p),
        flip=_given(request.flip, "transient"),
        repetitions=_given(request.repetitions, extent.repetitions),
        trials=_given(request.trials, extent.trials),
        max_steps=_given(request.max_steps, paper.MAX_STEPS),
        seed=_given(request.seed, 1),
        shuffle=_given(request.shuffle, True),
        plant=plant,
        layout=_given(request.layout, paper.MODALITY_PANEL if modal else "fixed"),
        modalities=modalities,
        assessment=_given(request.assessment, True),
    )
    planned.check_agents()
    return planned


def _check_lengths(what: str, specs: Sequence[str]) -> None:
    for spec in specs:
        if len(spec) > LONGEST_SPEC:
            raise BadValue(what, f"{spec[:40]}…", f"at most {LONGEST_SPEC} characters; these are {len(spec)}")


def _flips_extent(request: Request) -> paper.Extent:
    asked = request.full or any(given is not None for given in (request.p, request.trials, request.repetitions))
    return paper.FULL if asked else paper.SHORT


def _shown_by_default(plant: str, *, modal: bool) -> tuple[str, ...]:
    """The paper's modalities in the modality study, as far as the plant has a camera; reports in others."""
    return paper.MODALITIES if modal and resolve_plant(plant).has_camera else SYMBOLIC


def _players_by_default(modalities: tuple[str, ...], *, modal: bool) -> tuple[str, ...]:
    """Those that the study has by default; of the modality study's only those that have something to play."""
    if not modal:
        return ("llm:local", *paper.REFERENCES)
    return tuple(agent for agent in paper.LOOKERS if taken_in(agent, modalities))


def _given(value: _T | None, default: _T) -> _T:
    return default if value is None else value


def parse_p(text: str) -> list[float]:
    """Flip probabilities from ``0,0.1,0.2``."""
    try:
        return [float(part) for part in text.split(",")]
    except ValueError:
        raise BadValue("p", text, "numbers from 0 to 1 with commas between, for example 0,0.2,0.4") from None
