"""The ray caster shows what OpenGL shows; its light follows the textbook (ambient, diffuse, gloss)."""

import mujoco
import numpy as np
import pytest
from lockprobe_robot.rendering.ray_caster import RayCaster, Shader
from lockprobe_robot.scene.scene import EYE, build_scene
from lockprobe_robot.twin_settings import SceneSettings

import lockprobe
from lockprobe.foundation.errors import BadValue

TOLERANCE = 2e-3
"""Metres by which depth may differ in all but a thousandth of the pixels."""


def both(model, data, camera, egl, *, width=160, height=120):
    drawn = egl(model, width=width, height=height).render(data, camera)
    return drawn, RayCaster(model, width=width, height=height).render(data, camera)


def ends(model, joints, configuration):
    """Data with every joint at its end."""
    data = mujoco.MjData(model)
    for joint in range(joints):
        first = model.joint(f"joint-{joint}")
        data.qpos[first.qposadr[0]] = first.range[1] if configuration[joint] else first.range[0]
    mujoco.mj_forward(model, data)
    return data


def test_depth_of_a_lockbox_agrees_but_for_a_thousandth(lockbox_model, egl):
    opengl, rays = egl(lockbox_model, width=320, height=240), RayCaster(lockbox_model, width=320, height=240)
    for configuration in ((0, 0, 0, 0), (1, 0, 1, 0), (0, 1, 1, 1)):
        data = ends(lockbox_model, 4, configuration)
        (rgb, depth), (cast_rgb, cast_depth) = (renderer.render(data, EYE) for renderer in (opengl, rays))
        assert (np.abs(depth - cast_depth) > TOLERANCE).mean() <= 1e-3
        assert np.abs(rgb.astype(int) - cast_rgb).mean() < 3


def test_varied_looks_agree_too(egl):
    box = lockprobe.box("chain-4")
    settings = SceneSettings(looks="varied")
    scene = build_scene(box, labels=tuple("ABCD"), settings=settings, rng=np.random.default_rng(2))
    model = scene.spec.compile()
    (rgb, depth), (cast_rgb, cast_depth) = both(model, ends(model, 4, (0, 1, 0, 1)), EYE, egl, width=320, height=240)
    assert (np.abs(depth - cast_depth) > TOLERANCE).mean() <= 1e-3
    assert np.abs(rgb.astype(int) - cast_rgb).mean() < 3


def test_letters_on_the_board_are_as_sharp(lockbox_scene, lockbox_model, egl):
    data = ends(lockbox_model, 4, (0, 0, 0, 0))
    (rgb, _), (cast_rgb, _) = both(lockbox_model, data, "rgbd", egl, width=640, height=480)
    dark, cast_dark = (picture.mean(axis=2) < 60 for picture in (rgb, cast_rgb))
    assert dark.sum() > 1000
    assert (dark & cast_dark).sum() / (dark | cast_dark).sum() > 0.9


@pytest.mark.parametrize(
    "light",
    [
        'pos="-.5 0 2" dir=".25 0 -1" diffuse=".6 .6 .6"',
        'pos="0 0 2" dir=".5 .2 -1" type="directional" diffuse=".6 .5 .4" castshadow="false"',
        'pos="0 .5 2" dir="0 0 -1" castshadow="false" ambient=".2 .1 .1" cutoff="20" exponent="3"',
        'pos="0 .5 2" dir="0 0 -1" type="point" attenuation=".5 .1 .2" castshadow="false"',
        'active="false"',
    ],
)
def test_light_and_shadow(light, egl):
    ground = '<geom type="plane" size="1 1 .01"/><geom type="box" size=".1 .1 .1" pos="0 0 .3"/>'
    camera = '<camera name="above" pos="0 0 3" fovy="30"/>'
    model = mujoco.MjModel.from_xml_string(f"<mujoco><worldbody><light {light}/>{ground}{camera}</worldbody></mujoco>")
    data = mujoco.MjData(model)
    (rgb, _), (cast_rgb, _) = both(model, data, "above", egl)
    assert np.abs(rgb.astype(int) - cast_rgb).mean() < 2


def test_where_nothing_is_to_be_seen_it_is_background():
    model = mujoco.MjModel.from_xml_string(
        "<mujoco><worldbody><light pos='0 0 3' directional='true'/><geom size='.1'/>"
        "<camera name='eye' pos='0 0 1' xyaxes='1 0 0 0 -1 0'/></worldbody></mujoco>"
    )
    rgb, depth = RayCaster(model, width=8, height=8).render(mujoco.MjData(model), "eye")
    assert not rgb.any()
    assert not depth.any()


def test_what_cannot_be_cast_is_refused():
    field = '<asset><hfield name="hills" nrow="3" ncol="3" size="1 1 1 1"/></asset>'
    world = '<worldbody><geom type="hfield" hfield="hills"/></worldbody>'
    model = mujoco.MjModel.from_xml_string(f"<mujoco>{field}{world}</mujoco>")
    with pytest.raises(BadValue, match="shows mjGEOM_HFIELD"):
        RayCaster(model, width=64, height=64)


WORLD = """
<mujoco>
  <visual><headlight active="0"/></visual>
  <asset>
    <material name="matt" rgba=".2 .4 .8 1" specular="0" shininess="0"/>
    <material name="gloss" rgba="0 0 0 1" specular="1" shininess=".5"/>
    <material name="glow" rgba=".2 .4 .8 1" specular="0" shininess="0" emission="1"/>
  </asset>
  <worldbody>
    <geom name="matt" type="plane" size="5 5 .1" material="matt"/>
    <geom name="gloss" type="plane" size="5 5 .1" material="gloss"/>
    <geom name="glow" type="plane" size="5 5 .1" material="glow"/>
    <geom name="bare" type="plane" size="5 5 .1" rgba=".6 .5 .4 1"/>
    <camera name="eye" pos="0 0 2"/>
    {light}
  </worldbody>
</mujoco>
"""
PAINT = np.array([0.2, 0.4, 0.8])
SUN = '<light type="directional" dir="0 0 -1" ambient=".1 .1 .1" diffuse=".5 .5 .5" specular="1 1 1"/>'
UP = np.array([0.0, 0.0, 1.0])


def shade(light, geom="matt", points=((0, 0, 0),), normal=UP, lit=True):
    """Colours of points that all have the same normal."""
    model = mujoco.MjModel.from_xml_string(WORLD.format(light=light))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    points = np.array(points, dtype=float)
    return Shader(model).shade(
        data,
        eye=0,
        geoms=np.full(len(points), model.geom(geom).id),
        points=points,
        normals=np.tile(np.asarray(normal, dtype=float), (len(points), 1)),
        pixel=np.full(len(points), 0.001),
        lit=[np.full(len(points), lit)] * model.nlight,
    )


def test_without_light_it_is_dark_but_for_what_glows():
    assert not shade("").any()
    assert shade("", "glow")[0] == pytest.approx(PAINT)


@pytest.mark.parametrize("degrees", [0, 30, 60, 89])
def test_diffuse_light_falls_with_the_cosine(degrees):
    turn = np.radians(degrees)
    [colour] = shade(SUN, normal=(np.sin(turn), 0, np.cos(turn)))
    assert colour == pytest.approx(PAINT * (0.1 + 0.5 * np.cos(turn)))


def test_what_faces_away_or_lies_in_shadow_gets_ambient_light_only():
    assert shade(SUN, normal=-UP)[0] == pytest.approx(0.1 * PAINT)
    assert shade(SUN, lit=False)[0] == pytest.approx(0.1 * PAINT)
    assert not shade(SUN, "gloss", lit=False).any()


def test_light_that_is_switched_off_adds_nothing_and_two_add_up():
    assert not shade(SUN.replace("<light ", '<light active="false" ')).any()
    assert shade(SUN + SUN)[0] == pytest.approx(2 * shade(SUN)[0])


def test_gloss_is_where_the_eye_sees_the_light_mirrored_and_fades_around():
    points = [(x, 0, 0) for x in (0.0, 0.1, 0.2, 0.4)]
    gloss = shade(SUN, "gloss", points)[:, 0]
    assert gloss[0] == pytest.approx(1)
    between = np.array([np.cos(np.arctan2(x, 2) / 2) for x, _, _ in points])
    assert gloss == pytest.approx(between ** (0.5 * 128))


def lamp(kind, height=1, **options):
    described = " ".join(f'{name}="{value}"' for name, value in options.items())
    return f'<light pos="0 0 {height}" dir="0 0 -1" diffuse="1 1 1" type="{kind}" {described}/>'


def test_a_lamp_shines_weaker_far_away():
    near, far = (shade(lamp("spot", height, exponent=0, attenuation="0 0 1"))[0] for height in (1, 2))
    assert near == pytest.approx(PAINT)
    assert far == pytest.approx(PAINT / 4)


def test_a_lamp_shines_only_into_its_cone():
    points = [(0, 0, 0), (0.1, 0, 0), (1, 0, 0)]
    inside, aside, outside = shade(lamp("spot", cutoff=20, exponent=0), points=points)
    assert inside == pytest.approx(PAINT)
    assert aside == pytest.approx(PAINT / np.hypot(1, 0.1))
    assert not outside.any()


def test_what_opengl_does_not_draw_is_not_drawn():
    assert not shade(lamp("point")).any()


def test_a_headlight_shines_from_the_eye():
    model = mujoco.MjModel.from_xml_string(
        WORLD.format(light="").replace('active="0"', 'active="1" ambient=".1 .1 .1" diffuse=".4 .4 .4"')
    )
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    one = {"geoms": np.array([0]), "points": np.zeros((1, 3)), "pixel": np.array([0.001]), "lit": []}
    [facing], [averted] = (Shader(model).shade(data, eye=0, normals=np.array([normal]), **one) for normal in (UP, -UP))
    assert facing == pytest.approx(0.5 * PAINT)
    assert averted == pytest.approx(0.1 * PAINT)


def test_without_a_material_a_geom_has_its_own_colour():
    assert shade(SUN, "bare", normal=-UP)[0] == pytest.approx(0.1 * np.array([0.6, 0.5, 0.4]))
