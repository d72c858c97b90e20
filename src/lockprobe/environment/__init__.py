"""The box as a Gymnasium environment, ``lockprobe/Lockbox-v0``.

Importing it imports no Gymnasium; ``import lockprobe`` announces the environment.
"""

from __future__ import annotations

from lockprobe.environment.registration import ENVIRONMENT, announce, register

__all__ = ["ENVIRONMENT", "announce", "register"]
