"""A lockbox as an embodiment of Inspect Robots: its policies play Lockprobe's trials.

    cd examples
    uv run python inspect_robots_lockbox.py                                    # random joints, two flip rates
    uv run python inspect_robots_lockbox.py --model openai/gpt-4o --trials 5
    uv run python inspect_robots_lockbox.py --condition 'tremble?p=0.2' --plant fast-twin --trials 5

Inspect Robots has two parts that can be exchanged, the policy and the embodiment, and no interventions. Here the
embodiment is Lockprobe's loop, held at each decision (``lockprobe/Lockbox-v0``). So Lockprobe's interventions act on
what any of its policies is told and does. Every trial ends as a Lockprobe record with truth and reports, next to the
log of Inspect Robots.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Sequence
from typing import Any

import gymnasium
import numpy as np
from inspect_robots import (
    Action,
    ActionChunk,
    ActionSemantics,
    Box,
    CameraSpec,
    EmbodimentBase,
    EmbodimentInfo,
    EvalLog,
    Observation,
    ObservationSpace,
    PolicyBase,
    PolicyConfig,
    PolicyInfo,
    Scene,
    StateField,
    StateSpec,
    StepResult,
    Task,
    eval,  # noqa: A004 - its name there
    resolve,
)
from inspect_robots.embodiment import PRIVILEGED_SUCCESS, RESETTABLE, SEEDABLE
from numpy.typing import NDArray

from lockprobe import Trial, UserMistake
from lockprobe.boxes.families import find_box
from lockprobe.boxes.solve import random_success
from lockprobe.interfaces.gymnasium import ENVIRONMENT
from lockprobe.statistics.loops import measure

UNKNOWN = 0.5
"""Position of a joint whose report is missing, and of every joint where pictures are shown."""

INSTRUCTION = "Open the lockbox: move the target joint."

HOW = """A box with {count} joints that lock each other in a hidden way. Each has two positions, 0 and 1. State
`target` is the number of the joint that has to move. State `joint_pos` is the reported position of every joint, 0.5
if it is not reported. One action attempts one joint: give the position at which it should be, and leave the others
where they are reported. An attempt moves the joint to its other position, or nothing if it is locked. The box is open
when the target joint moves. There are {budget} attempts."""


class LockboxEmbodiment(EmbodimentBase):
    """A lockbox. An action holds a target position for every joint; the joint farthest from its target is attempted.

    An action that asks for the reported positions attempts nothing and costs no step of the box.

    Args:
        condition: What acts on reports and actions, for example ``flip?p=0.4``; empty for true reports.
        box: Name of the box.
        plant: ``symbolic``, ``fast-twin`` or ``twin``.
        pictures: Whether the policy sees the box instead of reading positions; needs a physical plant.
        max_steps: Attempts per trial.

    Attributes:
        info: What Inspect Robots checks before a rollout.
        trials: The record of every finished trial, truth and told.

    Raises:
        UserMistake: If a name does not exist, or an intervention cannot act here.
    """

    def __init__(
        self,
        condition: str = "",
        box: str = "chain-4",
        plant: str = "symbolic",
        *,
        pictures: bool = False,
        max_steps: int = 20,
    ) -> None:
        self.trials: list[Trial] = []
        self._pictures = pictures
        self._env = gymnasium.make(
            ENVIRONMENT, box=box, plant=plant, condition=condition or None, max_steps=max_steps, shuffle="trial",
            modality="rgb" if pictures else "symbolic?tell=state", disable_env_checker=True,
        )  # fmt: skip
        count = int(self._env.action_space.n)
        self._told = np.full(count, UNKNOWN)
        self._last = Observation()
        cameras = []
        if pictures:
            height, width, channels = self._env.observation_space.shape
            cameras = [CameraSpec(name="panel", height=height, width=width, channels=channels)]
        positions = StateField(key="joint_pos", shape=(count,), unit="normalized")
        self.info = EmbodimentInfo(
            name=f"lockbox-{box}",
            action_space=Box(
                shape=(count,), low=np.zeros(count), high=np.ones(count),
                semantics=ActionSemantics(
                    control_mode="joint_pos", dim_labels=tuple(f"joint_{i + 1}" for i in range(count)),
                    max_step=(2.0,) * count,  # so that a move from 0 to 1 is one action
                ),
            ),
            observation_space=ObservationSpace(
                cameras=tuple(cameras), state=StateSpec(fields=(positions, StateField(key="target", shape=(1,))))
            ),
            control_hz=1.0,
            is_simulated=True,
            capabilities=frozenset({SEEDABLE, RESETTABLE, PRIVILEGED_SUCCESS}),
            docs=HOW.format(count=count, budget=max_steps).replace("\n", " "),
        )  # fmt: skip

    def reset(self, scene: Scene, *, seed: int | None = None) -> Observation:
        """Begin a trial. The same seed gives the same luck under every condition."""
        report, info = self._env.reset(seed=seed)
        return self._observed(report, info, scene.instruction)

    def step(self, action: Action) -> StepResult:
        """Attempt the joint whose target is farthest from its report. ``info`` holds the truth, for scorers only."""
        away = np.abs(np.asarray(action.data, dtype=np.float64) - self._told)
        if not away.any():
            return StepResult(observation=self._last, info={"success": False})
        report, _, solved, spent, info = self._env.step(int(away.argmax()))
        if solved or spent:
            self.trials.append(self._env.unwrapped.trial)
        return StepResult(
            observation=self._observed(report, info, self._last.instruction),
            terminated=solved,
            termination_reason="success" if solved else None,
            truncated=spent,
            info={"success": solved},
        )

    def close(self) -> None:
        """Close the plant."""
        self._env.close()

    def _observed(self, report: NDArray[Any], info: dict[str, Any], instruction: str | None) -> Observation:
        target = info["target"] if self._pictures else report[0]
        if not self._pictures:
            self._told = np.where(report[3:] == 2, UNKNOWN, report[3:])
        self._last = Observation(
            images={"panel": report} if self._pictures else {},
            state={"joint_pos": self._told.astype(np.float64), "target": np.array([target + 1.0])},
            instruction=instruction,
        )
        return self._last


class RandomJoints(PolicyBase):
    """The baseline: every joint is equally likely to be attempted, whatever was reported."""

    config = PolicyConfig()

    def __init__(self, seed: int = 0) -> None:
        self._seed = seed
        self._rng = np.random.default_rng(seed)

    def bind(self, embodiment_info: EmbodimentInfo) -> None:
        """Act in the space of the embodiment."""
        self.info = PolicyInfo(name="random-joints", action_space=embodiment_info.action_space)

    def reset(self, scene: Scene) -> None:
        """The same trial has the same luck whatever was played before."""
        self._rng = np.random.default_rng([self._seed, scene.init_seed or 0])

    def act(self, observation: Observation) -> ActionChunk:
        """One joint, to the other position than the reported one."""
        targets = np.array(observation.state["joint_pos"])
        joint = self._rng.integers(targets.size)
        targets[joint] = 1.0 if targets[joint] < 1 else 0.0
        return ActionChunk(actions=[Action(data=targets)])


def evaluate(policy: Any, body: LockboxEmbodiment, trials: int, log_dir: str) -> EvalLog:
    """Play trials through the rollout of Inspect Robots; ``body.trials`` then holds Lockprobe's records."""
    scenes = [Scene(id=f"trial-{i + 1}", instruction=INSTRUCTION, init_seed=i) for i in range(trials)]
    task = Task(name=body.info.name, scenes=scenes, scorer="success_at_end", max_steps=200)
    (log,) = eval(task, policy, body, log_dir=log_dir, store_actions=False)
    return log


def summary(log: EvalLog, trials: Sequence[Trial]) -> str:
    """Success by Inspect Robots, and what its log has not: false reports and loops, from the records."""
    said = f"success {log.results.metrics.get('success_at_end', float('nan')):.2f}"
    if trials:
        steps = [step for trial in trials for step in trial.steps]
        false = sum(step.told_falsely for step in steps) / len(steps)
        loops = measure([trial.actions for trial in trials]).any_loop.mean()
        said += f", {false:.0%} of reports false, loops in {loops:.0%} of {len(trials)} trials"
    return said


def main() -> None:
    """Play a policy under each condition, and print what came of it."""
    parser = argparse.ArgumentParser(description="Policies of Inspect Robots play a lockbox.")
    parser.add_argument("--model", help="a language model plays, for example openai/gpt-4o; without it, random joints")
    parser.add_argument("--condition", action="append", help="for example flip?p=0.4; may be repeated")
    parser.add_argument("--box", default="chain-4", help="name of a box")
    parser.add_argument("--plant", default="symbolic", help="symbolic, fast-twin or twin")
    parser.add_argument("--pictures", action="store_true", help="show pictures instead of positions")
    parser.add_argument("--trials", type=int, default=200)
    parser.add_argument("--logs", help="directory for the logs of Inspect Robots (a temporary one)")
    asked = parser.parse_args()
    policy = resolve("policy", "agent", model=asked.model) if asked.model else RandomJoints()
    with tempfile.TemporaryDirectory() as passing:
        for condition in asked.condition or ["", "flip?p=0.4"]:
            body = LockboxEmbodiment(condition, asked.box, asked.plant, pictures=asked.pictures)
            log = evaluate(policy, body, asked.trials, asked.logs or passing)
            body.close()
            print(f"{condition or 'truth':15} {summary(log, body.trials)}")
    print(f"{'chance':15} success {random_success(find_box(asked.box)):.2f} (exact, random joints)")


if __name__ == "__main__":
    try:
        main()
    except UserMistake as mistake:
        sys.exit(str(mistake))
