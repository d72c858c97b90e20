"""The contracts as pytest fixtures. pytest finds them by itself where lockprobe is installed.

::

    def test_late(check_intervention):
        check_intervention(Late(lag=2))

Nothing of :mod:`lockprobe.testing` is imported before a fixture is asked for.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack
from importlib import import_module
from typing import Any

import pytest

__all__ = [
    "check_agent",
    "check_box",
    "check_intervention",
    "check_measure",
    "check_plant",
    "make_trial",
    "play_trials",
    "scripted_agent",
    "scripted_provider",
]


def _testing(name: str) -> Callable[..., Any]:
    found: Callable[..., Any] = getattr(import_module("lockprobe.testing"), name)
    return found


@pytest.fixture
def check_intervention() -> Callable[..., Any]:
    """:func:`lockprobe.testing.check_intervention`."""
    return _testing("check_intervention")


@pytest.fixture
def check_agent() -> Callable[..., Any]:
    """:func:`lockprobe.testing.check_agent`."""
    return _testing("check_agent")


@pytest.fixture
def check_plant() -> Callable[..., Any]:
    """:func:`lockprobe.testing.check_plant`."""
    return _testing("check_plant")


@pytest.fixture
def check_box() -> Callable[..., Any]:
    """:func:`lockprobe.testing.check_box`."""
    return _testing("check_box")


@pytest.fixture
def check_measure() -> Callable[..., Any]:
    """:func:`lockprobe.testing.check_measure`."""
    return _testing("check_measure")


@pytest.fixture
def make_trial() -> Callable[..., Any]:
    """:func:`lockprobe.testing.make_trial`."""
    return _testing("make_trial")


@pytest.fixture
def play_trials() -> Callable[..., Any]:
    """:func:`lockprobe.testing.play_trials`."""
    return _testing("play_trials")


@pytest.fixture
def scripted_agent() -> Callable[..., Any]:
    """:class:`lockprobe.testing.ScriptedAgent` of these places in the listing."""

    def scripted(*joints: int, **options: Any) -> Any:
        return _testing("ScriptedAgent")(joints=joints, **options)

    return scripted


@pytest.fixture
def scripted_provider() -> Iterator[Callable[..., Any]]:
    """:class:`lockprobe.testing.ScriptedProvider` of these answers, which serves until the test ends."""
    with ExitStack() as running:

        def serving(answers: Any = None, **options: Any) -> Any:
            return running.enter_context(_testing("ScriptedProvider")(answers, **options))

        yield serving
