"""A box."""

from itertools import pairwise

from lockprobe import Joint, Lockbox


def gate(bolts: int = 3):
    """A gate that needs its first bolt, which needs the second, and so on; the last is free."""
    names = ["gate", *(f"bolt-{number}" for number in range(1, bolts + 1))]
    kinds = ["revolute"] + ["prismatic"] * bolts
    places = [((i + 0.5) / len(names), 0.5) for i in range(len(names))]
    return Lockbox(
        name=f"gate-{bolts}",
        joints=tuple(
            Joint(name=name, kind=kind, place=place) for name, kind, place in zip(names, kinds, places, strict=True)
        ),
        interlock={name: ({needed: True},) for name, needed in pairwise(names)},
        initial=(False,) * len(names),
        target="gate",
    )
