"""A moment can be looked at as often as one likes while it lasts, and what made the picture is then a fact."""

import mujoco
import numpy as np
import pytest

from lockprobe.errors import PlantFault
from lockprobe.plants.rendering import plant_camera as eye_module
from lockprobe.plants.rendering.camera import Sight
from lockprobe.plants.scene.mechanism import Mechanism
from lockprobe.plants.settings import SceneSettings

RAYS = SceneSettings(renderer="rays", width=64, height=64, depth_noise=0.002)


@pytest.fixture
def sight(lockbox_scene, lockbox_model, state):
    """Makes a sight of the lockbox, with a stream of noise."""

    def make(seed=1):
        data, rng = state(lockbox_model), np.random.default_rng(seed)
        mechanism = Mechanism(lockbox_model, data, lockbox_scene)
        return Sight(lockbox_model, data, mechanism=mechanism, scene=lockbox_scene, settings=RAYS, rng=rng)

    return make


def test_a_moment_can_be_looked_at_until_it_ends(sight):
    seen = sight()
    first, second = seen.now(), seen.now()
    np.testing.assert_array_equal(first().rgb, second().rgb)
    np.testing.assert_array_equal(first().rgb, first().rgb)
    seen.end_moment()
    for look in (first, second):
        with pytest.raises(PlantFault, match="after the next attempt"):
            look()
    assert seen.now()().rgb.shape == (64, 64, 3)


def test_the_renderer_is_a_fact_once_it_has_made_a_picture_and_stays_one(sight):
    seen = sight()
    look = seen.now()
    assert seen.facts["renderer"] is None
    frame = look()
    assert seen.facts["renderer"] == frame.renderer
    seen.close()
    assert seen.facts["renderer"] == frame.renderer


def test_the_fact_is_what_drew_and_not_what_was_asked_for(sight, monkeypatch):
    really = eye_module.open_renderer

    def another(*args, **options):
        renderer = really(*args, **options)
        renderer.name = "paint by numbers"
        return renderer

    monkeypatch.setattr(eye_module, "open_renderer", another)
    seen = sight()
    seen.now()()
    assert seen.facts["renderer"] == "paint by numbers"


def test_facts_are_engine_settings_and_renderer(sight):
    facts = sight().facts
    assert facts["engine"] == f"mujoco {mujoco.__version__}"
    assert (facts["width"], facts["depth_noise"], facts["mechanism"]) == (64, 0.002, "contact")


def test_a_look_that_is_refused_takes_no_luck(sight):
    one, other = sight(), sight()
    late = one.now()
    one.end_moment()
    with pytest.raises(PlantFault):
        late()
    np.testing.assert_array_equal(one.now()().depth, other.now()().depth)
