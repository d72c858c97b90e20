"""What is shown of a model and of its state."""

import mujoco
import numpy as np

from lockprobe.plants.rendering.visible import SHOWN_GROUPS, shown_options, shown_state


def test_a_state_is_shown_as_it_is_and_stays_as_it_was(lockbox_model):
    data, seen = mujoco.MjData(lockbox_model), mujoco.MjData(lockbox_model)
    data.qpos[:] = np.linspace(0.01, 0.05, lockbox_model.nq)
    everything = mujoco.mjtState.mjSTATE_INTEGRATION
    before = np.empty(mujoco.mj_stateSize(lockbox_model, everything))
    after = before.copy()
    mujoco.mj_getState(lockbox_model, data, before, everything)
    stale = data.geom_xpos.copy()
    shown_state(lockbox_model, data, seen)
    mujoco.mj_getState(lockbox_model, data, after, everything)
    np.testing.assert_array_equal(after, before)
    np.testing.assert_array_equal(data.geom_xpos, stale)
    mujoco.mj_forward(lockbox_model, data)
    for what in ("geom_xpos", "geom_xmat", "cam_xpos", "cam_xmat", "light_xpos", "light_xdir"):
        np.testing.assert_array_equal(getattr(seen, what), getattr(data, what), what)
    assert (seen.geom_xpos != stale).any()


def test_things_that_hang_on_mocap_bodies_are_shown_where_they_are_put():
    model = mujoco.MjModel.from_xml_string(
        "<mujoco><worldbody><body name='hand' mocap='true'><geom size='.1'/></body></worldbody></mujoco>"
    )
    data, seen = mujoco.MjData(model), mujoco.MjData(model)
    data.mocap_pos[0] = (1, 2, 3)
    shown_state(model, data, seen)
    np.testing.assert_array_equal(seen.geom_xpos[0], (1, 2, 3))


def test_options_show_the_shown_groups_and_no_sites_or_tendons():
    options = shown_options()
    assert tuple(map(bool, options.geomgroup)) == SHOWN_GROUPS
    assert not options.sitegroup.any()
    assert not options.flags[mujoco.mjtVisFlag.mjVIS_TENDON]
