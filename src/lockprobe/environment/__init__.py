"""The box as a Gymnasium environment, ``lockprobe/Lockbox-v0``, and its registration.

Gymnasium looks names up in a registry, and since its release 1.0 no entry point fills it: the package that has an
environment registers it when it is imported. Importing Lockprobe imports no Gymnasium: :func:`announce` registers the
environment as soon as Gymnasium is loaded, whichever of the two is imported first.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from importlib.machinery import ModuleSpec, PathFinder
from types import ModuleType

__all__ = ["ENVIRONMENT", "announce", "register"]

ENVIRONMENT = "lockprobe/Lockbox-v0"
"""Its name in Gymnasium's registry."""


def register() -> None:
    """Enter the environment in Gymnasium's registry, if it is not there yet."""
    from gymnasium.envs import registration

    if ENVIRONMENT not in registration.registry:
        registration.register(
            id=ENVIRONMENT,
            entry_point="lockprobe.environment.single:LockboxEnv",
            vector_entry_point="lockprobe.environment.vector:LockboxVectorEnv",
        )


def announce() -> None:
    """Register now if Gymnasium is loaded, else as soon as it is."""
    if sys.modules.get("gymnasium") is not None:
        register()
    elif not any(isinstance(finder, _UntilGymnasium) for finder in sys.meta_path):
        sys.meta_path.insert(0, _UntilGymnasium())


class _UntilGymnasium:
    """Waits among the finders of modules until Gymnasium has been loaded, and finds nothing else."""

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """Gymnasium as it is found anyway, with one thing to do after it is loaded."""
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
