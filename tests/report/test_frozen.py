"""Reports of thirteen kinds of studies: every number and every sentence is as it was frozen.

A change that moves one on purpose freezes them anew (``python tests/frozen.py``) and says why.
"""

import difflib
import re

import pytest
from frozen import FROZEN, RESTS_ON, STUDIES, kept, reported

from lockprobe.report.rows import UNITS

DIGITS = 1e-5
"""Relative difference of numbers on other machines and with other releases of scipy."""


@pytest.mark.parametrize("name", STUDIES)
def test_numbers_and_pages_are_as_they_were(name, tmp_path):
    (numbers, pages), (before, pages_before) = reported(name, tmp_path), kept(name)
    assert list(difflib.unified_diff(pages_before, pages, "before", "now", lineterm="", n=0)) == []
    found, frozen = ([line.split("\t") for line in lines] for lines in (numbers, before))
    assert [_of(line) for line in found] == [_of(line) for line in frozen]
    moved = [
        (quantity, of, was, now)
        for (quantity, of, was), (_, _, now) in zip(frozen, found, strict=True)
        if was != now and not _equal(was, now)
    ]
    assert moved == []


def _of(line: list[str]) -> list[str]:
    """What a line is of; of a sentence all of it."""
    return line if line[0] == RESTS_ON else line[:2]


@pytest.mark.parametrize("name", STUDIES)
def test_every_judgement_rests_on_numbers_that_are_there(name):
    lines = [line.split("\t") for line in kept(name)[0]]
    known = {quantity for quantity, *_ in lines if quantity != RESTS_ON}
    sentences = [(of, rests_on.split()) for quantity, of, rests_on in lines if quantity == RESTS_ON]
    assert len(sentences) > 10
    for of, rests_on in sentences:
        assert {*rests_on} <= known, of
        assert rests_on or ", judges" not in of, of


@pytest.mark.parametrize("name", STUDIES)
def test_a_report_has_at_most_5_000_words_when_all_is_unfolded(name):
    pages = "\n".join(kept(name)[1]).split("== ")
    (report,) = [page for page in pages if page.startswith("report\n")]
    assert len(report.split()) <= 5_000


@pytest.mark.parametrize("name", STUDIES)
def test_every_unit_is_one_of_the_list(name):
    units = {one[1] for line in kept(name)[0] if (one := re.search(r"(?:\t|, )unit=(.*?)(?:, \w[\w.]*=|\t)", line))}
    assert {"steps", "trials"} <= units
    assert units - {""} <= {*UNITS}


def _equal(was: str, now: str) -> bool:
    pairs = [(float(one), float(other)) for one, other in zip(*_values(was, now), strict=True)]
    return all(other == pytest.approx(one, rel=DIGITS, abs=1e-9, nan_ok=True) for one, other in pairs)


def _values(*lines: str) -> list[list[str]]:
    return [line.replace("none", "nan").split(" ") for line in lines]


def test_every_study_is_frozen_and_none_beside_them():
    assert {path.name.split(".")[0] for path in FROZEN.iterdir()} == set(STUDIES)
