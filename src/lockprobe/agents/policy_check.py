"""Checks what the policies of others return, so that a mistake in one is a message and never a success rate."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import wraps
from numbers import Real
from reprlib import Repr
from typing import Any

from lockprobe.foundation.errors import UserMistake

_TOLERANCE = 1e-6
"""How far a sum of probabilities may be from 1."""

_short = Repr()
_short.maxother, _short.maxtuple, _short.maxlist = 80, 12, 12


def check_returns(policy: type[Any]) -> None:
    """Make a class of policies check its probabilities at every call, unless Lockprobe wrote them."""
    method = policy.probabilities
    ours = str(getattr(method, "__module__", "")).partition(".")[0] == __name__.partition(".")[0]
    if not ours and not hasattr(method, "checked"):
        policy.probabilities = _with_probabilities_checked(method)
        policy.probabilities.checked = True


def _with_probabilities_checked(method: Callable[..., Any]) -> Callable[..., tuple[float, ...]]:
    @wraps(method)
    def probabilities(self: Any, view: Any, memory: Any) -> tuple[float, ...]:
        found = method(self, view, memory)
        numbers = _numbers(found)
        if len(numbers) == view.joints and min(numbers) >= 0 and abs(math.fsum(numbers) - 1) <= _TOLERANCE:
            return numbers
        wanted = f"{view.joints} numbers >= 0 that sum to 1 are expected"
        raise UserMistake(f"{type(self).__name__}.probabilities returned {_short.repr(found)}: {wanted}")

    return probabilities


def _numbers(found: Any) -> tuple[float, ...]:
    """What was returned as finite numbers; empty if it is anything else."""
    try:
        parts: tuple[Any, ...] = tuple(found)
    except TypeError:
        return ()
    if not all(isinstance(part, Real) and math.isfinite(part) for part in parts):
        return ()
    return tuple(map(float, parts))
