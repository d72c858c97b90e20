"""An arm touches the panel, and nothing else touches anything; what is hidden is not shown."""

import itertools

from lockprobe_robot.geom_groups import ARM, HIDDEN, NOTHING, PANEL, SHOWN_GROUPS

LAYERS = {"panel": (PANEL, NOTHING), "arm": (ARM, PANEL), "looks": (NOTHING, NOTHING)}


def test_only_the_arm_touches_and_only_the_panel():
    touching = {
        frozenset((one, other))
        for (one, (kind, _)), (other, (_, touches)) in itertools.product(LAYERS.items(), repeat=2)
        if kind & touches
    }
    assert touching == {frozenset(("arm", "panel"))}


def test_what_is_hidden_is_not_shown_and_what_has_no_group_is():
    assert not SHOWN_GROUPS[HIDDEN]
    assert SHOWN_GROUPS[0]
