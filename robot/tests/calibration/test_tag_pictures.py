"""A printed tag shows its cells where the layout says, upright and not mirrored."""

import numpy as np
from box_model.scenes import scene_of
from calibration.tag_pictures import HandCamera, add_tag_prints
from lockprobe_robot.box_model.tag_layout import place_tags

from lockprobe.boxes.families import box


def tagged_scene(seed=5):
    scene = scene_of(box("chain-2"))
    tags = place_tags(scene.panel)
    bits = np.random.default_rng(seed).random((4, 8, 8)) < 0.5
    add_tag_prints(scene.spec, tags, bits)
    return scene, tags, bits


def test_every_cell_is_seen_where_it_belongs():
    scene, tags, bits = tagged_scene()
    camera = HandCamera(scene.spec, width=960, height=720)
    above = np.eye(4)
    above[:3, :3] = np.diag([1, -1, -1])
    above[2, 3] = 0.4
    pose = scene.panel.pose @ above
    picture = camera.look(pose)[..., 1].astype(float)
    camera.close()
    steps = (np.arange(8) - 3.5) / 8 * tags.side
    for middle, cells in zip(tags.middles, bits, strict=True):
        x, y = np.meshgrid(middle[0] + steps, middle[1] - steps)
        columns = 479.5 + camera.focal * x / 0.4
        rows = 359.5 - camera.focal * y / 0.4
        seen = picture[np.rint(rows).astype(int), np.rint(columns).astype(int)]
        assert seen[cells].min() > 2 * seen[~cells].max() + 40
