"""A handle looks different and feels the same."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest

from lockprobe.plants.layers import HIDDEN
from lockprobe.plants.scene.appearance import HANDLES, look_of
from lockprobe.plants.scene.fitting import KNOB_RADIUS, KNOB_TOP
from lockprobe.plants.scene.handles import add_handle

PLAIN = look_of("plain", np.random.default_rng(1))


@pytest.mark.parametrize("shape", HANDLES)
def test_every_shape_is_the_same_to_the_touch_and_lies_within_it(shape):
    spec = mujoco.MjSpec()
    part = spec.worldbody.add_body(name="part")
    part.add_joint(type=mujoco.mjtJoint.mjJNT_SLIDE, axis=[1, 0, 0])
    add_handle(part, 3, np.array([0.02, 0.0]), replace(PLAIN, handle=shape))
    model = spec.compile()
    knob = model.geom("knob-3")
    assert knob.size[:2] == pytest.approx([KNOB_RADIUS, (KNOB_TOP - 0.002) / 2])
    assert model.body_mass[1] == pytest.approx(0.03)
    assert [bool(bits) for bits in model.geom_contype] == [i == knob.id for i in range(model.ngeom)]
    assert model.site_pos[model.site("knob-3").id] == pytest.approx([0.02, 0, KNOB_TOP])
    seen = [i for i in range(model.ngeom) if model.geom_group[i] != HIDDEN]
    assert (knob.id in seen) == (shape == "round")
    assert max(model.geom_size[i][0] for i in seen) == pytest.approx(KNOB_RADIUS)
    ball = int(mujoco.mjtGeom.mjGEOM_SPHERE)
    tops = [model.geom_pos[i][2] + model.geom_size[i][0 if model.geom_type[i] == ball else 1] for i in seen]
    assert max(tops) == pytest.approx(KNOB_TOP)
