"""Packages of strangers, installed for one test: a module and the metadata of a distribution on the import path."""

import importlib
import sys
from pathlib import Path

import pytest

WORKING = '''
"""What a stranger writes."""

import os
import subprocess
from dataclasses import dataclass, field, replace

from lockprobe import Agent, BadValue, Decision, Joint, Lockbox, Policy, Snapshot

@dataclass(frozen=True, kw_only=True)
class Hush:
    """The first reports are not given."""

    doses = ("steps",)
    steps: int = 1

    def perceive(self, percept, past, task, rng):
        quiet = 0 < len(past) <= self.steps
        return replace(percept, outcome=None, positions=None) if quiet else percept

class First:
    """Always the joint at one place of the listing."""

    def __init__(self, place: int = 0):
        self.place = place
        self.facts = {"place": place}

    async def decide(self, situation, rng):
        return Decision(joint=situation.task.joints[self.place])

class Plain:
    """The rules, and a number that is sensed."""

    def __init__(self, *, box, labels, rng, force=1.5):
        self.box, self.configuration, self.facts = box, box.initial, {"force": force}

    def observe(self):
        return Snapshot(configuration=self.configuration)

    def attempt(self, joint):
        self.configuration, moved = self.box.attempt(self.configuration, joint)
        outcome = "moved" if moved else "blocked"
        return Snapshot(configuration=self.configuration, joint=joint, outcome=outcome, sensed=dict(self.facts))

    def close(self):
        pass

def gate(size: int = 3):
    """A gate behind bolts in a row, each of which needs the next."""
    names = ["gate", *(f"bolt-{i}" for i in range(1, size))]
    return Lockbox(
        name=f"gate-{size}",
        joints=tuple(Joint(name=name, kind="prismatic") for name in names),
        interlock={name: ({after: True},) for name, after in zip(names, names[1:])},
        initial=(False,) * size,
        target="gate",
    )

GATE = gate(4)
STUCK = replace(gate(3), interlock={"gate": ({"bolt-1": True},), "bolt-1": ({"gate": True},)})

def untold(trial, weight: float = 1.0):
    """Share of attempts that were not reported."""
    return weight * sum(step.told_moved is None for step in trial.steps) / len(trial.steps) if trial.steps else None

def hasty(trial):
    """Whether it was solved in five steps."""
    return trial.solved and len(trial.steps) <= 5

def shout(words: str, times: int = 1):
    """Print words in capitals."""
    print(" ".join([words.upper()] * times))

def seen(spec):
    """A plant with a camera."""
    from lockprobe.plants.catalogue import PlantSource
    width = int(spec.options.get("width", 64))
    return PlantSource(spec=str(spec), make=lambda box, labels, rng: Plain(box=box, labels=labels, rng=rng), picture_size=(width, 64))

class Quits(First):
    """Ends the process when it is made."""

    def __init__(self):
        raise SystemExit("it quits")

def falls(box, labels, rng):
    """Ends the process when it is called."""
    raise SystemExit("it falls")

def breaks(*given, **options):
    """Breaks when it is called."""
    raise ZeroDivisionError("by nothing")
'''

POINTS = {
    "agents": {"first": "First"},
    "boxes": {"gate": "gate"},
    "interventions": {"hush": "Hush"},
    "measures": {"untold": "untold"},
    "plants": {"plain": "Plain"},
    "plant_sources": {"seen": "seen"},
}


def install(
    directory: Path,
    monkeypatch: pytest.MonkeyPatch,
    module: str = "strange",
    text: str = WORKING,
    points: dict[str, dict[str, str]] = POINTS,
    package: str = "strange-things",
) -> None:
    """Put a package on the import path until the end of the test.

    Args:
        points: Group, without ``lockprobe.`` -> name -> what in the module it stands for.
    """
    monkeypatch.delitem(sys.modules, module, raising=False)
    (directory / f"{module}.py").write_text(text, "utf-8")
    metadata = directory / f"{package.replace('-', '_')}-0.3.dist-info"
    metadata.mkdir()
    (metadata / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {package}\nVersion: 0.3\n", "utf-8")
    lines = [
        line
        for group, those in points.items()
        for line in (f"[lockprobe.{group}]", *(f"{name} = {module}:{what}" for name, what in those.items()))
    ]
    (metadata / "entry_points.txt").write_text("\n".join(lines) + "\n", "utf-8")
    monkeypatch.syspath_prepend(directory)
    importlib.invalidate_caches()
