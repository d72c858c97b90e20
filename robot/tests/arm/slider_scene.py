"""One knob on one slider before the arm, as plain as it can be."""

from __future__ import annotations

import mujoco
import numpy as np
from lockprobe_robot.arm.guarded_move import HandlePath
from lockprobe_robot.arm.model import add_arm, add_hand
from lockprobe_robot.arm.simulated_arm import SimulatedArm

TOP = np.array([0.5, 0.0, 0.2])
AXIS = np.array([0.0, 0.0, -1.0])
TRAVEL = 0.08
PATH = HandlePath(points=np.linspace(TOP, TOP + np.array([0, TRAVEL, 0]), 9), axis=AXIS)


def slider(*, held=False):
    """A compiled scene with the arm over a knob that slides along y, or is held."""
    spec = mujoco.MjSpec()
    spec.compiler.degree = False
    spec.option.timestep = 0.002
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    bar = spec.worldbody.add_body(name="bar", pos=TOP + 0.05 * AXIS)
    bar.add_joint(
        name="joint-0",
        type=mujoco.mjtJoint.mjJNT_SLIDE,
        axis=[0, 1, 0],
        range=[0, 0.001 if held else TRAVEL],
        limited=True,
        damping=[2, 0, 0],
        frictionloss=0.6,
    )
    bar.add_geom(type=mujoco.mjtGeom.mjGEOM_CYLINDER, fromto=[0, 0, 0, 0, 0, 0.05], size=[0.015, 0, 0], mass=0.1)
    add_hand(spec, add_arm(spec))
    return spec.compile()


def arm_over(model, **options):
    """The arm at home, and the state that it moves."""
    data = mujoco.MjData(model)
    arm = SimulatedArm(model, data, rng=np.random.default_rng(1), **options)
    arm.stand()
    return arm, data
