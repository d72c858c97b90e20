"""A modality study to report on, and reports whose pictures are not drawn."""

import pytest
from builders import SOLUTION, make_trial
from placeholders import undrawn

NAMES = [f"{i:020x}.png" for i in range(8)]
"""Names of pictures, of which trials have the first six, those of depth in 16 bits at 3 and 5."""

PICTURES = [
    {"rgb": NAMES[0]},
    {"rgb": NAMES[1]},
], [
    {"rgb": NAMES[0], "depth": NAMES[2], "depth16": NAMES[3]},
    {"rgb": NAMES[1], "depth": NAMES[4], "depth16": NAMES[5]},
]  # fmt: skip


def trials_of(modality, waits, agent="viewer", **more):
    """Trials that solve the box after so many blocked steps at the target, the first few of them misread."""
    return [
        make_trial(
            [0] * wait + list(SOLUTION), agent=agent, modality=modality, study="modalities", trial=i,
            claims=[None, *(["moved"] * min(wait, misread)), *["blocked"] * max(0, wait - misread), *["moved"] * 4],
            verdicts=["moved"] * (1 + (i == 1)) + ["blocked"] * wait, **more,
        )
        for i, (wait, misread) in enumerate(waits, 1)
    ]  # fmt: skip


@pytest.fixture(scope="module", autouse=True)
def placeholders():
    """Reports here hold placeholders for pictures, which tests/figures looks at."""
    with undrawn():
        yield


@pytest.fixture(scope="session")
def modal():
    """Trials that are solved soon with RGB, later with RGB-D and last with ground truth."""
    soon = [(1 + i % 3, 1) for i in range(10)]
    later = [(5 + i % 3, 3) for i in range(10)]
    latest = [(9 + i % 3, i < 4) for i in range(10)]
    return [
        *trials_of("rgb", soon, pictures=PICTURES[0]),
        *trials_of("rgbd", later, pictures=PICTURES[1]),
        *trials_of("symbolic", latest),
        *trials_of("symbolic", [(2, 0)] * 10, agent="human-inspired"),
    ]
