"""The contract test of a box."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

from lockprobe.boxes.box import Lockbox
from lockprobe.boxes.boxfile import box_from_data, toml_of
from lockprobe.boxes.families import find_box
from lockprobe.boxes.state_space import fault_of
from lockprobe.foundation.errors import UserMistake
from lockprobe.testing.records import check_record
from lockprobe.testing.trials import play_trials


def check_box(box: str | Path | Lockbox | Callable[[], Lockbox]) -> None:
    """Check that a box fulfils its contract.

    It can be solved, and no alternative of its target is contradictory. Asking for it again returns the same box, and
    so does writing it as data, settings or TOML and reading it back. It can be played.

    Args:
        box: A name, a path, a box, or a function that returns one.

    Raises:
        AssertionError: If it breaks one of these; the message says which.
    """
    found, again = _found(box), _found(box)
    assert isinstance(found, Lockbox), f"{found!r} is no Lockbox"
    assert found == again, f"{found.name} is another box when it is asked for again"
    fault = fault_of(found)
    assert fault is None, f"{found.name} is {fault}"
    try:
        read = box_from_data(json.loads(json.dumps(found.as_data())))
        toml_of(found)
    except UserMistake as mistake:
        raise AssertionError(f"{found.name} cannot be written down: {mistake}") from mistake
    assert read == found, f"{found.name} is another box when it is written down and read"
    check_record(play_trials("random", 1, box=found)[0], found.name)


def _found(box: str | Path | Lockbox | Callable[[], Lockbox]) -> Lockbox:
    return find_box(box) if isinstance(box, str | Path | Lockbox) else box()
