"""From a modality's spec to what stands between box and agent."""

import pytest

from lockprobe.foundation.errors import BadValue, UnknownName
from lockprobe.interventions.camera import CameraChannel
from lockprobe.interventions.conditions import flips
from lockprobe.interventions.modality import check_shown, interventions_for, is_pictured, shown
from lockprobe.plants.catalogue import resolve_plant


@pytest.mark.parametrize(
    ("spec", "eye"),
    [
        ("rgb", CameraChannel()),
        ("rgbd", CameraChannel(depth=True)),
        ("rgbd?noise=0.5", CameraChannel(depth=True, noise=0.5)),
    ],
)
def test_pictures_come_from_the_camera_alone_where_they_are_true(spec, eye):
    assert is_pictured(spec)
    assert shown(spec) == eye
    assert interventions_for(flips((0.0,), "integrated", (spec,))[0]) == (eye,)


@pytest.mark.parametrize(
    ("spec", "message"),
    [
        ("depth", "no modality is called 'depth'; there are: symbolic, rgb, rgbd"),
        ("symbolic?depth=gray", "no option of symbolic is called 'depth'; there are: tell, form, places"),
        ("symbolic?tell=lies", "tell: got 'lies', expected one of state, outcome, both"),
        ("symbolic?places=1", "places: got '1', expected yes or no"),
        ("rgbd?colour=red", "no option of rgbd is called 'colour' .did you mean 'blur'..; there are: blur"),
        ("rgb?p=0.4", "no option of rgb is called 'p'; there are: blur, noise, occlude, exposure"),
        ("rgb?blur=-1", "blur: got -1.0, expected a number from 0"),
        ("rgbd?depth=turbo", "no option of rgbd is called 'depth'; there are: blur, noise, occlude, exposure"),
        ("symbolic?source=rumour", "source: got 'rumour', expected one of truth, verdict, camera"),
        (
            "symbolic?source=verdict on symbolic",
            "modality: got .*, expected a plant with an arm, twin or rig, not symb",
        ),
        (
            "symbolic?source=verdict on twin?model=m.xml&digest=0",
            "modality: got .*, expected a plant with an arm, twin",
        ),
        (
            "symbolic?source=camera on rig",
            "modality: got .*, expected a plant with a camera, fast-twin or twin, not rig",
        ),
    ],
)
def test_what_is_no_modality_or_none_of_a_plant_is_refused(spec, message):
    modality, _, plant = spec.partition(" on ")
    with pytest.raises((BadValue, UnknownName), match="^" + message):
        check_shown(flips((0.0,), modalities=[modality]), resolve_plant(plant or "fast-twin"))
