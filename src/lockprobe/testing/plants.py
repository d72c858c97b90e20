"""The contract test of a plant."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from lockprobe.boxes.box import Configuration, Lockbox
from lockprobe.boxes.families import find_box
from lockprobe.foundation.plugins import allow
from lockprobe.plants.catalogue import resolve_plant
from lockprobe.studies.running.single import run_trial
from lockprobe.testing.records import check_facts, check_record
from lockprobe.trial.plan import LABELS
from lockprobe.trial.protocols import Plant


@dataclass(frozen=True, slots=True, kw_only=True)
class PlantTried:
    """What :func:`check_plant` tried on one box.

    Attributes:
        plant: Name of the plant.
        box: Name of the box.
        attempts: Attempts at joints,
        moved: and those that moved one.
        joints: Number of joints that were attempted.
        configurations: Number of configurations in which a joint was attempted.
        resets: Number of plants that were made, and started in the initial configuration.
    """

    plant: str
    box: str
    attempts: int
    moved: int
    joints: int
    configurations: int
    resets: int

    def __str__(self) -> str:
        return (
            f"{self.plant} on {self.box}: {self.attempts} attempts at {self.joints} joints in {self.configurations} "
            f"configurations as the interlock says ({self.moved} moved, {self.attempts - self.moved} blocked), "
            f"{self.resets} resets"
        )


def check_plant(
    plant: str | Callable[..., Plant],
    *,
    boxes: Sequence[str | Path | Lockbox] = ("chain-4", "bichain-4", "gray-code"),
    attempts: int = 40,
) -> tuple[PlantTried, ...]:
    """Check that a plant fulfils its contract.

    It starts with the box's initial configuration, and looking changes nothing. An attempt toggles the joint if the
    interlock allows that and changes nothing else; the snapshot says so. A new plant starts afresh. Its sensors and
    facts survive the record. It can be closed. For each box a line says what was tried.

    Args:
        plant: Its spec, or a callable with ``box``, ``labels`` and ``rng``.
        boxes: The boxes that it is made for.
        attempts: Number of random attempts on each box.

    Returns:
        What was tried on each box.

    Raises:
        AssertionError: If it breaks one of these; the message says which.
    """
    name = plant if isinstance(plant, str) else getattr(plant, "__name__", type(plant).__name__)
    found = []
    for asked in boxes:
        box = find_box(asked)
        first, other = _made(plant, box), _made(plant, box)
        assert isinstance(first, Plant), f"{name} has no `facts`, `observe`, `attempt` or `close`"
        _check_start(first, box, name)
        seen = _check_attempts(first, box, attempts, name)
        _check_start(other, box, name)
        check_facts(first.facts, name)
        first.close()
        other.close()
        if isinstance(plant, str):
            check_record(run_trial(agent="random", box=box, plant=plant), name)
        tried = _tried(seen, box, name, resets=3 if isinstance(plant, str) else 2)
        print(tried)
        found.append(tried)
    return tuple(found)


def _made(plant: str | Callable[..., Plant], box: Lockbox) -> Plant:
    rng, labels = np.random.default_rng(7), tuple(LABELS[: len(box.joints)])
    if isinstance(plant, str):
        allow(plant)
        return resolve_plant(plant).make(box, labels, rng)
    return plant(box=box, labels=labels, rng=rng)


def _check_start(plant: Plant, box: Lockbox, name: str) -> None:
    for _ in range(2):
        seen = plant.observe()
        assert seen.configuration == box.initial, f"{name} does not start as {box.name} does, or looking changes it"
        assert (seen.joint, seen.outcome) == (None, None), f"{name} reports an attempt before the first one"


def _check_attempts(plant: Plant, box: Lockbox, attempts: int, name: str) -> list[tuple[Configuration, int, bool]]:
    """Make random attempts; each with its configuration, its joint, and whether the joint moved."""
    made = []
    now, rng = box.initial, np.random.default_rng(11)
    for _ in range(attempts):
        joint = int(rng.integers(len(box.joints)))
        allowed = box.may_move(now, joint)
        made.append((now, joint, allowed))
        now, _moved = box.attempt(now, joint)
        seen = plant.attempt(joint)
        where = f"on {box.name}, where the interlock {'lets' if allowed else 'does not let'} joint {joint} move"
        assert seen.joint == joint, f"{name} reports another joint than the one attempted, {joint}"
        assert seen.configuration == now, f"{name} does not obey the interlock {where}"
        assert seen.outcome == ("moved" if allowed else "blocked"), f"{name} reports a wrong outcome {where}"
        check_facts(seen.sensed, f"{name}, what it senses,")
    return made


def _tried(made: Sequence[tuple[Configuration, int, bool]], box: Lockbox, name: str, *, resets: int) -> PlantTried:
    return PlantTried(
        plant=name,
        box=box.name,
        attempts=len(made),
        moved=sum(moved for _, _, moved in made),
        joints=len({joint for _, joint, _ in made}),
        configurations=len({configuration for configuration, _, _ in made}),
        resets=resets,
    )
