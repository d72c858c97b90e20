"""Every name that a box may have."""

import hashlib
import json

import pytest

from lockprobe.boxes.families import box
from lockprobe.foundation.errors import BadValue, UnknownName


def test_random_boxes_are_pinned():
    """A name in a paper has to mean the same box in every release: this must not be changed."""
    text = json.dumps([box(f"random-{n}-{seed}").as_data() for n in range(2, 9) for seed in (0, 17)], sort_keys=True)
    assert hashlib.sha256(text.encode()).hexdigest()[:16] == "de7a24a27339c780"


@pytest.mark.parametrize(
    ("name", "mistake", "message"),
    [
        ("chain-9", UnknownName, r"no box is called 'chain-9' \(did you mean 'chain-8'\?\); .*chain-2.*random-N-SEED"),
        ("random-5", UnknownName, "no box is called 'random-5'"),
        ("random-5-x", UnknownName, "no box is called 'random-5-x'"),
        ("random-5--1", UnknownName, "no box is called"),
        ("random-٣-1", UnknownName, "no box is called"),
        ("random-9-1", BadValue, "random-9-1: got 9, expected 2 to 8 joints"),
        ("random-1-1", BadValue, "random-1-1: got 1, expected 2 to 8 joints"),
        ("random-4-1000000000", BadValue, "got 1000000000, expected a seed of at most 999999999"),
    ],
)
def test_other_names_are_refused(name, mistake, message):
    with pytest.raises(mistake, match=message):
        box(name)
