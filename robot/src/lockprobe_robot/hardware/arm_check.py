"""Checks an arm before it moves: holds its position under control, and measures latency, drift and force noise."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from lockprobe.foundation.errors import PlantFault
from lockprobe_robot.arm.guarded_move import GuardedMove
from lockprobe_robot.arm.protocol import Arm

SUCCESS_RATE = 0.95
"""Least share of control commands that the robot has to receive in time."""

MOST_LATE = 0.01
"""Largest share of late commands."""

MOST_DRIFT = 0.005
"""Largest distance that the tool may move while it is held, metres."""

MOST_NOISE = 2.0
"""Largest standard deviation of a component of the force while nothing is touched, newtons."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ArmCheck:
    """Measurements while the arm holds its position.

    Attributes:
        commands: Number of commands.
        period: Nominal duration of a command, seconds.
        latency: Median, 95th and 100th percentile of the duration of a command, seconds.
        late: Commands that took longer than 1.5 periods.
        success_rate: Lowest share of control commands received in time, [0, 1]; None if the arm does not report it.
        drift: Largest distance of the tool from its start, metres.
        noise: Largest standard deviation of a component of the force, newtons.
    """

    commands: int
    period: float
    latency: tuple[float, float, float]
    late: int
    success_rate: float | None
    drift: float
    noise: float

    @property
    def complaints(self) -> tuple[str, ...]:
        """The failed checks, one sentence each; empty if the arm may move."""
        found = []
        if self.success_rate is not None and self.success_rate < SUCCESS_RATE:
            found.append(f"the robot received {self.success_rate:.1%} of commands in time, least {SUCCESS_RATE:.0%}")
        if self.late > MOST_LATE * self.commands:
            found.append(f"{self.late} of {self.commands} commands were late, at most {MOST_LATE:.0%}")
        if self.drift > MOST_DRIFT:
            found.append(f"the tool drifted by {1000 * self.drift:.1f} mm, at most {1000 * MOST_DRIFT:g} mm")
        if self.noise > MOST_NOISE:
            found.append(f"the force varies by {self.noise:.1f} N, at most {MOST_NOISE:g} N")
        return tuple(found)


def check_arm(arm: Arm, *, commands: int = 500, clock: Callable[[], float] = time.monotonic) -> ArmCheck:
    """Hold the tool in place, and time every command.

    The first fifth of the commands does not count for drift and noise, because the controller settles under the weight.

    Args:
        arm: The arm within its bounds. An arm with ``success_rate`` is asked for it.
        commands: Number of commands, at least 10.
        clock: A monotonic clock, seconds.

    Raises:
        PlantFault: If the arm fails.
    """
    if commands < 10:
        raise PlantFault(f"an arm is checked with at least 10 commands, not {commands}")
    here, still, stiffness = np.array(arm.position()), np.zeros(3), GuardedMove().free_stiffness
    took, places, forces, rates = [], [], [], []
    for _ in range(commands):
        began = clock()
        arm.follow(here, still, stiffness=stiffness)
        took.append(clock() - began)
        places.append(arm.position())
        forces.append(arm.force())
        if (rate := getattr(arm, "success_rate", None)) is not None:
            rates.append(float(rate))
    median, most, longest = np.percentile(took, [50, 95, 100]).tolist()
    settled = commands // 5
    return ArmCheck(
        commands=commands,
        period=arm.period,
        latency=(median, most, longest),
        late=sum(one > 1.5 * arm.period for one in took),
        success_rate=min(rates[settled:], default=None),
        drift=float(np.linalg.norm(np.array(places[settled:]) - here, axis=1).max()),
        noise=float(np.std(forces[settled:], axis=0).max()),
    )
