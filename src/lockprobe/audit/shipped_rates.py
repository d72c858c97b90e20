"""The audit as it was measured for this release, shipped as data, so that every report can stand beside it.

``measured.json`` is what ``lockprobe audit --studies 1000 --json`` prints.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict
from functools import cache
from importlib.resources import files
from typing import Any

from lockprobe.audit.rates import Rate
from lockprobe.audit.simulated_agents import WORLDS

__all__ = ["as_data", "false_positives", "measured", "shipped"]


def as_data(rates: Sequence[Rate], *, seed: int) -> dict[str, Any]:
    """The audit as JSON holds it."""
    return {
        "seed": seed,
        "worlds": {name: WORLDS[name].says for name in dict.fromkeys(rate.world for rate in rates)},
        "rates": [asdict(rate) | {"rate": rate.rate, "error": rate.error, "valid": rate.valid} for rate in rates],
    }


@cache
def shipped() -> dict[str, Any]:
    """The shipped audit as JSON holds it; not to be changed."""
    found: dict[str, Any] = json.loads(files("lockprobe.audit").joinpath("measured.json").read_text(encoding="utf-8"))
    worlds = {name: WORLDS[name].says if name in WORLDS else says for name, says in found["worlds"].items()}
    return found | {"worlds": worlds}


@cache
def measured() -> tuple[Rate, ...]:
    """The shipped audit."""
    derived = ("rate", "error", "valid")
    return tuple(
        Rate(**{name: value for name, value in row.items() if name not in derived}) for row in shipped()["rates"]
    )


def false_positives(test: str) -> tuple[Rate, Rate] | None:
    """The lowest and the highest false-positive rate of a test over the worlds where it should find nothing."""
    found = sorted((rate for rate in measured() if rate.test == test and not rate.truth), key=lambda rate: rate.rate)
    return (found[0], found[-1]) if found else None
