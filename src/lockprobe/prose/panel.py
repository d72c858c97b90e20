"""The sentence on the panel of a study with pictures, and how much of the lock it gives away.

Pictures show where each joint sits; reports in words do not. On the panel of ``chain-4`` joints that lock each other
sit side by side, so that one who tries the nearest joint next is right more often than by chance. Where joints are
dealt anew to the panel in every trial, places say nothing of the lock.
"""

from __future__ import annotations

from math import comb

from lockprobe.lockbox.box import Lockbox
from lockprobe.lockbox.layouts import locking_pairs, neighbours

__all__ = ["panel_said"]


def panel_said(box: Lockbox, *, dealt: bool, listed_anew: bool) -> str:
    """Whether a study with pictures had one panel or dealt ones, and what that means, for people to read.

    Args:
        box: The box on its own panel.
        dealt: Whether its joints were dealt anew to the panel in every trial.
        listed_anew: Whether words list joints in an order drawn for every trial; else they list them along the panel.
    """
    if dealt:
        return (
            "The joints were dealt anew to the places of the panel in every trial, and all modalities and agents had "
            "the same deals. So where a joint sits says nothing about what it locks."
        )
    locking, near = locking_pairs(box), neighbours(box)
    by_chance = len(locking) * len(near) / comb(len(box.joints), 2)
    shown = (
        "words list the joints in an order drawn for every trial. So a difference between pictures and words can come "
        "from the panel; --layout shuffled deals it anew in every trial"
        if listed_anew
        else "words list the joints in the same order"
    )
    return (
        f"The panel was the same in every trial: of the pairs of joints that lock each other, {len(locking & near)} of "
        f"{len(locking)} sit side by side on it ({by_chance:.2g} on average if joints are dealt at random). Pictures "
        f"show this order, and {shown}."
    )
