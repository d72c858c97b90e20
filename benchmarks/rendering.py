"""What a picture costs, with every renderer that works here, and whether they show the same.

One run prints, for the scene of chain-4 at 640 x 480: milliseconds per pair of colours and depth, milliseconds with all
that an RGB-D observation needs (files in PNG among it), the same after an attempt on `fast-twin`, their ratios to one
plain `mj_step` of the same scene, and in how many pixels the depth of each renderer differs by more than 2 mm from the
first one's.

    python benchmarks/rendering.py [--frames 20] [--pictures DIRECTORY]
"""

from __future__ import annotations

import argparse
import itertools
import time
from collections.abc import Callable
from pathlib import Path

import mujoco
import numpy as np
from lockprobe_robot.fast_twin import FastTwin
from lockprobe_robot.rendering.choose_renderer import probe
from lockprobe_robot.rendering.plant_camera import PlantCamera
from lockprobe_robot.scene.mechanism import Mechanism
from lockprobe_robot.scene.scene import LockboxScene, build_scene
from lockprobe_robot.twin_settings import SceneSettings

import lockprobe
from lockprobe.foundation.errors import BadValue
from lockprobe.interventions.camera import CameraChannel
from lockprobe.trial.pictures.frame import Frame
from lockprobe.trial.pictures.png import to_png
from lockprobe.trial.record import Percept, Task

TOLERANCE = 0.002
SIZE = (640, 480)


def configurations(model: mujoco.MjModel) -> list[mujoco.MjData]:
    """Every configuration of the four joints."""
    states = []
    for ends in itertools.product((0, 1), repeat=4):
        data = mujoco.MjData(model)
        for joint, end in enumerate(ends):
            data.qpos[model.joint(f"joint-{joint}").qposadr[0]] = model.joint(f"joint-{joint}").range[end]
        mujoco.mj_forward(model, data)
        states.append(data)
    return states


def median_ms(call: Callable[[], object], times: int) -> tuple[float, float]:
    """Median milliseconds of a call: by the clock, and of all processors together."""
    taken = []
    for _ in range(times):
        start = time.perf_counter(), time.process_time()
        call()
        taken.append((time.perf_counter() - start[0], time.process_time() - start[1]))
    clock, processors = 1e3 * np.median(taken, axis=0)
    return float(clock), float(processors)


def step_ms(model: mujoco.MjModel) -> float:
    """Milliseconds of one plain step, averaged over a thousand."""
    data = mujoco.MjData(model)
    start = time.perf_counter()
    for _ in range(1000):
        mujoco.mj_step(model, data)
    return time.perf_counter() - start


def main() -> None:
    """Prints the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--frames", type=int, default=20)
    parser.add_argument("--pictures", type=Path, help="where to write a picture of each renderer")
    options = parser.parse_args()
    settings = SceneSettings()
    scene = build_scene(lockprobe.box("chain-4"), labels=tuple("ABCD"), settings=settings, rng=np.random.default_rng(1))
    model = scene.spec.compile()
    step = step_ms(model)
    print(f"one mj_step of the scene: {step:.4f} ms")
    states = configurations(model)
    reference: list[np.ndarray] = []
    for probed in probe():
        if not probed.ok:
            print(f"{probed.name}: {probed.detail}")
            continue
        try:
            measure(
                SceneSettings(renderer=probed.name, width=SIZE[0], height=SIZE[1]),
                model,
                scene,
                states,
                options.frames,
                step,
                reference,
                options.pictures,
            )
        except BadValue as other_platform:
            print(other_platform)


def measure(
    settings: SceneSettings,
    model: mujoco.MjModel,
    scene: LockboxScene,
    states: list[mujoco.MjData],
    frames: int,
    step: float,
    reference: list[np.ndarray],
    pictures: Path | None,
) -> None:
    """Prints the lines of one renderer; the first one's depth becomes the reference."""
    rng, data = np.random.default_rng(2), mujoco.MjData(model)
    mechanism = Mechanism(model, data, scene)
    eye = PlantCamera(model, data, mechanism=mechanism, panel=scene.panel, settings=settings, rng=rng)

    def look(positions: tuple[bool, ...] | None = None, number: int = 0) -> Frame:
        mujoco.mj_copyData(data, model, states[number])
        return eye.look_now()()

    first = look()
    pair = median_ms(look, frames)
    channel = CameraChannel(depth="turbo")
    task = Task(joints=tuple("ABCD"), target="A", budget=20)
    whole = median_ms(lambda: channel.perceive(Percept(positions=(False,) * 4, look=look), (), task, rng), frames)
    print(first.renderer)
    plant = FastTwin(scene.box, labels=task.joints, settings=settings, rng=np.random.default_rng(3))
    attempts = itertools.cycle((0, 3, 2, 1, 0, 0, 1, 2, 3))

    def looked() -> Percept:
        snapshot = plant.attempt(next(attempts))
        return Percept(positions=snapshot.configuration, look=lambda positions=None: snapshot.look())

    channel.perceive(looked(), (), task, rng)
    twin = median_ms(lambda: channel.perceive(looked(), (), task, rng), frames)
    plant.close()
    rows = (("colours and depth", pair), ("RGB-D observation", whole), ("fast-twin attempt and observation", twin))
    for what, (clock, processors) in rows:
        print(f"  {what:34} {clock:7.1f} ms, {processors:7.1f} ms of processors, {clock / step:9.0f} steps")
    depths = [look(number=number).depth for number in range(len(states))]
    if reference:
        worst = max((np.abs(one - other) > TOLERANCE).mean() for one, other in zip(reference, depths, strict=True))
        print(f"  depth differs from the first renderer's in at most {100 * worst:.4f} % of pixels, 16 configurations")
    else:
        reference.extend(depths)
    if pictures is not None:
        pictures.mkdir(parents=True, exist_ok=True)
        (pictures / f"{first.renderer.split()[0]}.png").write_bytes(to_png(first.rgb))
    eye.close()


if __name__ == "__main__":
    main()
