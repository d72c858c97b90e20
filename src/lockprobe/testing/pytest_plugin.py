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


def _fixture(name: str) -> Any:
    """A fixture that gives the function of this name in :mod:`lockprobe.testing`."""

    def function() -> Callable[..., Any]:
        return _testing(name)

    function.__doc__ = f":func:`lockprobe.testing.{name}`."
    return pytest.fixture(name=name)(function)


check_intervention = _fixture("check_intervention")
check_agent = _fixture("check_agent")
check_plant = _fixture("check_plant")
check_box = _fixture("check_box")
check_measure = _fixture("check_measure")
make_trial = _fixture("make_trial")
play_trials = _fixture("play_trials")


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
