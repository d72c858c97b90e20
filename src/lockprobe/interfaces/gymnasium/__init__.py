"""The box as a Gymnasium environment, ``lockprobe/Lockbox-v0``, and its registration.

Gymnasium looks up names in a registry that no entry point fills since its release 1.0. Importing Lockprobe imports no
Gymnasium: :func:`announce` registers the environment as soon as Gymnasium is loaded, in either order of imports.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from importlib.machinery import ModuleSpec, PathFinder
from types import ModuleType

__all__ = ["ENVIRONMENT", "announce", "register"]

ENVIRONMENT = "lockprobe/Lockbox-v0"
"""Name in Gymnasium's registry."""


def register() -> None:
    """Enter the environment in Gymnasium's registry. Idempotent."""
    from gymnasium.envs import registration

    if ENVIRONMENT not in registration.registry:
        registration.register(
            id=ENVIRONMENT,
            entry_point="lockprobe.interfaces.gymnasium.single:LockboxEnv",
            vector_entry_point="lockprobe.interfaces.gymnasium.vector:LockboxVectorEnv",
        )


def announce() -> None:
    """Register now if Gymnasium is loaded, else as soon as it is."""
    if sys.modules.get("gymnasium") is not None:
        register()
    elif not any(isinstance(finder, _UntilGymnasium) for finder in sys.meta_path):
        sys.meta_path.insert(0, _UntilGymnasium())


class _UntilGymnasium:
    """An import finder that waits for Gymnasium and finds nothing else."""

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """Find Gymnasium by its path, and register the environment after it is loaded."""
        found = PathFinder.find_spec(fullname, path) if fullname == "gymnasium" else None
        if found is None or found.loader is None:
            return None
        load = found.loader.exec_module

        def load_and_register(module: ModuleType) -> None:
            load(module)
            if self in sys.meta_path:
                sys.meta_path.remove(self)
            register()

        found.loader.exec_module = load_and_register  # type: ignore[method-assign]
        return found
