"""One's own hand on the arm moves what is free, feels what is held, and is refused when it is no hand."""

import numpy as np
import pytest
from lockprobe_robot.twin import Twin
from lockprobe_robot.twin_settings import TwinSettings
from mjcf_models import EXAMPLES, written

from lockprobe.boxes.families import box
from lockprobe.foundation.errors import BadFile
from lockprobe.plants.catalogue import resolve_plant

HAND = EXAMPLES / "own_hand.xml"
FREE, LOCKED = 3, 1


def twin(hand, **settings):
    options = TwinSettings(hand=str(hand), **settings)
    return Twin(box(), labels=tuple("ABCD"), settings=options, rng=np.random.default_rng(0))


def test_it_moves_a_free_joint_and_feels_a_locked_one():
    plant = twin(HAND)
    blocked, moved = plant.attempt(LOCKED), plant.attempt(FREE)
    assert (blocked.outcome, blocked.sensed["verdict"]) == ("blocked", "blocked")
    assert (moved.outcome, moved.sensed["verdict"]) == ("moved", "moved")
    assert moved.sensed["peak_force"] < 10 < blocked.sensed["peak_force"]


def test_the_plant_names_the_files_by_their_digest_and_refuses_others(tmp_path):
    spec = resolve_plant(f"twin?hand={HAND}").spec
    assert "hand_digest=" in spec
    assert resolve_plant(spec).spec == spec
    with pytest.raises(BadFile, match="another hand: its digest is"):
        twin(HAND, hand_digest="0" * 16)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("<mujoco><worldbody><body><geom size='.01'/></body></worldbody></mujoco>", "no site 'tool' in a body"),
        ("<mujoco><worldbody><body><geom size='-1'/></body></worldbody></mujoco>", "size"),
        (
            "<mujoco><extension><plugin plugin='mujoco.pid'/></extension></mujoco>",
            "is refused: a plugin would run code",
        ),
        ("<robot/>", "not an MJCF file"),
    ],
)
def test_what_is_no_hand_is_refused_in_one_line(tmp_path, text, said):
    with pytest.raises(BadFile, match=said) as refusal:
        twin(written(tmp_path, text))
    assert "\n" not in str(refusal.value)
