"""Boxes by name: the published ones, those of the literature, and hundreds that are drawn, valid or refused with the reason."""

import hashlib
import json
from collections import Counter

import pytest

from lockprobe.boxes.box import Lockbox, data_of
from lockprobe.boxes.families import STRUCTURES, box, generate
from lockprobe.boxes.solve import fault_of, optimum
from lockprobe.foundation.errors import UnknownName

PUBLISHED = [
    "chain-4", "chain-8", "bichain-5", "fork", "converge", "reset", "gray-code-5", "common-cause-4", "common-effect-3",
    "branched",
]  # fmt: skip


@pytest.mark.parametrize(
    ("names", "pinned"),
    [
        (PUBLISHED, "16230379b5ac6601"),
        ([f"random-{n}-{seed}" for n in range(2, 9) for seed in (0, 17)], "de7a24a27339c780"),
    ],
)
def test_a_name_in_a_paper_means_the_same_box_in_every_release(names, pinned):
    """What stands here must not be changed."""
    text = json.dumps([data_of(box(name)) for name in names], sort_keys=True)
    assert hashlib.sha256(text.encode()).hexdigest()[:16] == pinned


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("chain-9", r"no box is called 'chain-9' \(did you mean 'chain-8'\?\); .*chain-2.*random-N-SEED with N from 2 to 8"),
        *((name, "no box is called") for name in ("random-5", "random-٣-1", "random-9-1", "random-1-1", f"random-4-{10**9}")),
    ],
)  # fmt: skip
def test_other_names_are_refused(name, message):
    with pytest.raises(UnknownName, match=message):
        box(name)


@pytest.mark.parametrize("name", STRUCTURES)
def test_every_named_box_can_be_played(name):
    assert fault_of(box(name), shortest=2) is None


LAYOUTS = ("serial", "zigzag", "ngram", "grid", "scattered", "misleading")
RANDOM = tuple(f"random-{joints}" for joints in range(2, 9))
FAMILIES = (*STRUCTURES, *RANDOM * 4)


def test_hundreds_of_boxes_are_valid_or_refused_with_the_reason():
    counts = Counter()
    for i in range(0, 3_000, 7):
        family, layout = FAMILIES[i % len(FAMILIES)], LAYOUTS[i // 7 % 6]
        shortest, easier = 1 + i // 17 % 3, generate(family, i, layout=layout, dealt=i % 2 == 0, shortest=1)
        found = generate(family, i, layout=layout, dealt=i % 2 == 0, shortest=shortest)
        kind = "made" if isinstance(found, Lockbox) else found.partition(":")[0]
        counts[kind] += 1
        assert isinstance(easier, Lockbox) == (kind in ("made", "too short"))
        if isinstance(easier, Lockbox):
            assert (optimum(easier) >= shortest) == (kind == "made")
    assert set(counts) == {"made", "too short", "unsolvable", "contradictory"}
    assert counts["made"] > 150
