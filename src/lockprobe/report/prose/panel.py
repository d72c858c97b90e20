"""The sentence on the panel of a study with pictures, and how much of the interlock it reveals.

Pictures show where each joint sits; reports in words do not. On the panel of ``chain-4`` joints that lock each other
sit side by side, so an agent that tries the nearest joint next is right more often than by chance. If the joints are
placed at random in every trial, positions say nothing about the lock.
"""

from __future__ import annotations

from math import comb

from lockprobe.boxes.box import Lockbox
from lockprobe.boxes.layouts import locking_pairs, neighbours

__all__ = ["panel_said"]


def panel_said(box: Lockbox, *, dealt: bool, listed_anew: bool, rigid: bool = False) -> str:
    """Whether a study with pictures had one panel or random ones, and what that means for its comparisons.

    Args:
        box: The box on the panel of all trials, if that was one.
        dealt: Whether its joints were dealt anew to the panel in every trial.
        listed_anew: Whether words list joints in an order that is drawn; else they list them along the panel.
        rigid: Whether the panel is that of a user's model, which nobody can deal anew.
    """
    if dealt:
        return (
            "In every trial the joints were assigned to positions on the panel at random, identically for all "
            "modalities and agents. So the position of a joint says nothing about the interlock."
        )
    locking, near = locking_pairs(box), neighbours(box)
    by_chance = len(locking) * len(near) / comb(len(box.joints), 2)
    shown = (
        "words list the joints in a random order. So a difference between pictures and words can come from the panel"
        f"{'' if rigid else '; --layout shuffled randomises it in every trial'}"
        if listed_anew
        else "words list the joints in the same order"
    )
    return (
        f"The panel was the same in every trial: of the pairs of joints that lock each other, {len(locking & near)} of "
        f"{len(locking)} sit side by side on it ({by_chance:.2g} on average in a random arrangement). Pictures "
        f"show this order, and {shown}."
    )
