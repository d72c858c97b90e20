"""The box as a Gymnasium environment, ``lockprobe/Lockbox-v0``. Importing this package registers it."""

from __future__ import annotations

from lockprobe.foundation.errors import needing

with needing("the environment", "gym"):
    from gymnasium.envs import registration

__all__ = ["ENVIRONMENT"]

ENVIRONMENT = "lockprobe/Lockbox-v0"
"""Name in Gymnasium's registry."""

if ENVIRONMENT not in registration.registry:
    registration.register(
        id=ENVIRONMENT,
        entry_point="lockprobe.interfaces.gymnasium.environment:LockboxEnv",
        vector_entry_point="lockprobe.interfaces.gymnasium.vector:LockboxVectorEnv",
    )
