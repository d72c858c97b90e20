"""The candidate models of an agent's choices.

Some models have versions, for example one for each preset. The version that fits best represents its model, and results
state the number of versions.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from lockprobe.agents.human_inspired import PRESETS, HumanInspired
from lockprobe.agents.strategies import RoundRobin
from lockprobe.foundation.errors import UnknownName
from lockprobe.simulation.fit.choices import Choices, Heard, rule
from lockprobe.simulation.fit.likelihood import Lapse, Model, Softmax
from lockprobe.simulation.fit.result import PULLS

__all__ = ["RIVALS", "CandidateModel", "Versions", "candidates_named", "mapped"]

Array = NDArray[np.float64]
Versions = Mapping[str, Model]


@dataclass(frozen=True, slots=True, kw_only=True)
class CandidateModel:
    """One candidate model.

    Attributes:
        name: Its name.
        versions: Function from the choices to the model's versions by name.
        agent: Template of the spec of a version's agent, without fitted parameters; empty if there is no such agent.
        heeds: Whether it uses reports, and not only attempts.
    """

    name: str
    versions: Callable[[Choices, Sequence[Heard]], Versions]
    agent: str = ""
    heeds: bool = True


def candidates_named(names: Iterable[str] | None = None) -> list[CandidateModel]:
    """Candidate models by name, in the order of :data:`RIVALS`, with ``random`` always included; all without names.

    Raises:
        UnknownName: If there is no such model; the message lists those that exist.
    """
    asked = set(RIVALS if names is None else names)
    for name in sorted(asked - set(RIVALS)):
        raise UnknownName("model", name, RIVALS)
    return [rival for name, rival in RIVALS.items() if name in asked | {"random"}]


def _softmax(name: str, *pulls: str) -> Callable[[Choices, Sequence[Heard]], Versions]:
    """The softmax over a fading memory with a subset of its pulls; other pulls are 0."""

    def versions(choices: Choices, heard: Sequence[Heard]) -> Versions:
        features = {
            "target": choices.target,
            "closed": choices.closed,
            "failure": np.zeros_like(choices.place),
            "recent": choices.last,
            "stay": choices.stayed,
            "position": -choices.place,
        }
        columns = [features[pull] * choices.present for pull in pulls]
        model = Softmax.of(
            names=pulls,
            features=np.stack([np.zeros_like(choices.place), *columns], axis=2)[:, :, 1:].copy(),
            chosen=choices.chosen,
            present=choices.present,
            traces=(choices.age, choices.moves) if "failure" in pulls else None,
        )
        return {name: model}

    return versions


def _favourites(which: str) -> Callable[[Choices, Sequence[Heard]], Versions]:
    """One pull for each place in the listing, or for each label, relative to the first."""

    def versions(choices: Choices, heard: Sequence[Heard]) -> Versions:
        width = choices.present.shape[1]
        if which == "label":
            kinds, names = choices.label, choices.labels
        else:
            kinds = np.broadcast_to(np.arange(width), choices.label.shape)
            names = tuple(str(place + 1) for place in range(width))
        features = kinds[:, :, None] == np.arange(1, len(names))
        return {
            f"favourite-{which}s": Softmax.of(
                names=tuple(f"{which} {name} beside {names[0]}" for name in names[1:]),
                features=(features & choices.present[:, :, None]).astype(np.float64),
                chosen=choices.chosen,
                present=choices.present,
            )
        }

    return versions


def _follows(choices: Choices, follows: Array) -> Lapse:
    return Lapse.of(follows=follows, chosen=choices.chosen, present=choices.present)


def _round_robin(choices: Choices, heard: Sequence[Heard]) -> Versions:
    return {"round-robin": _follows(choices, rule(RoundRobin(), heard))}


def _human_inspired(choices: Choices, heard: Sequence[Heard]) -> Versions:
    """A version for each preset; presets that use the panel need a known panel."""
    seen = all(one.view.places for one in heard)
    agents = {
        f"human-inspired:{name}": HumanInspired(**preset)  # type: ignore[arg-type] # a preset is what it takes
        for name, preset in PRESETS.items()
        if seen or "nearest" not in preset
    }
    return {name: _follows(choices, rule(agent, heard)) for name, agent in agents.items()}


def _random_map(choices: Choices, heard: Sequence[Heard]) -> Versions:
    """A version for each window and each rule of avoidance; without a window there is no last joint to avoid."""
    kinds = [(w, avoid) for w, avoid in product(range(4), ("none", "last", "failed")) if w or avoid != "last"]
    return {
        f"random-map?window={window}&avoid={avoid}": _follows(choices, mapped(choices, window, avoid))
        for window, avoid in kinds
    }


def mapped(choices: Choices, window: int, avoid: str) -> Array:
    """The choices of :class:`lockprobe.agents.cognitive.RandomMap`, as probabilities of shape (choices, joints).

    In a known state it repeats the joint that it first attempted there; in a new state it takes any joint that is not
    avoided.
    """
    rows, places = np.arange(len(choices)), np.arange(choices.present.shape[1])
    failed = choices.failed if avoid == "failed" else np.zeros_like(choices.failed)
    state = np.column_stack([choices.trial, choices.reported, failed, choices.recent[:, :window]])
    states, which = np.unique(state, axis=0, return_inverse=True)
    which = which.reshape(-1)
    reported = np.flatnonzero(choices.done >= 0)  # of an attempt without a report the map learns nothing
    first = np.full(len(states), len(rows))
    np.minimum.at(first, which[reported], reported)
    before = first[which]
    known = before < rows
    barred = choices.last if avoid == "last" else (failed[:, None] >> places) & 1 > 0
    allowed = choices.present & ~barred
    allowed = np.where(allowed.any(axis=1, keepdims=True), allowed, choices.present)
    fresh: Array = allowed / allowed.sum(axis=1, keepdims=True)
    return np.where(known[:, None], choices.done[np.where(known, before, 0)][:, None] == places, fresh)


_SOFTMAX = "cognitive:softmax-memory"

_RIVALS = (
    CandidateModel(name="random", versions=_softmax("random"), agent="random", heeds=False),
    CandidateModel(name="favourite-places", versions=_favourites("place"), heeds=False),
    CandidateModel(name="favourite-labels", versions=_favourites("label"), heeds=False),
    CandidateModel(name="round-robin", versions=_round_robin, heeds=False),
    CandidateModel(name="no-repeat", versions=_softmax("no-repeat", "recent"), agent=_SOFTMAX, heeds=False),
    CandidateModel(
        name="win-stay-lose-shift", versions=_softmax("win-stay-lose-shift", "recent", "stay"), agent=_SOFTMAX
    ),
    CandidateModel(name="failure-memory", versions=_softmax("failure-memory", "failure"), agent=_SOFTMAX),
    CandidateModel(
        name="goal-and-failures",
        versions=_softmax("goal-and-failures", "target", "closed", "failure"),
        agent=_SOFTMAX,
    ),
    CandidateModel(name="softmax-memory", versions=_softmax("softmax-memory", *PULLS), agent=_SOFTMAX),
    CandidateModel(name="human-inspired", versions=_human_inspired, agent="{version}"),
    CandidateModel(name="random-map", versions=_random_map, agent="cognitive:{version}"),
)

RIVALS: Mapping[str, CandidateModel] = {rival.name: rival for rival in _RIVALS}
"""All candidate models by name."""
