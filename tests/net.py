"""The net: every number of the studies in ``tests/net``, a line each, from their records.

A study is its directory in ``NAME.zip`` and its numbers in ``NAME.txt``. ``python tests/net.py [NAME …]`` writes the
numbers anew; a line whose numbers are the same but for the last digits keeps them, so a diff shows what has moved.
``tests/net/README.md`` says what the studies are.
"""

from __future__ import annotations

import math
import sys
import tempfile
import zipfile
from collections.abc import Iterable
from pathlib import Path

import pytest
import stored
import strangers

from lockprobe.report.results import results
from lockprobe.report.rows import Curve, Estimate

NET = Path(__file__).with_name("net")
STUDIES = tuple(sorted(path.stem for path in NET.glob("*.zip")))

COLUMNS = ("value", "low", "high", "p_value", "n", "count", "clusters", "corrected_for")
"""What a line says of a number; a curve has its points instead: x, value, low, high."""

DIGITS = 1e-5
"""Relative difference of numbers on other machines and with other releases of scipy."""


def numbers(name: str, under: Path) -> dict[str, str]:
    """What each number of a study is of -> the number; the study is unpacked below this directory."""
    with pytest.MonkeyPatch.context() as patch:
        if name == "of-a-package":
            strangers.install(
                under, patch, points=strangers.POINTS | {"measures": {"untold": "untold", "hasty": "hasty"}}
            )
        found = results(unpacked(name, under))
    for row in found.rows:  # no share leaves 0 to 1, and no two are further apart
        least = {"share": 0, "points": -1 - (row.quantity == "success_interaction")}.get(row.unit, -math.inf)
        most = 1 if row.unit == "share" else -least
        assert all(end is None or least - DIGITS <= end <= most + DIGITS for end in (row.value, row.low, row.high)), row
    lines = dict((*map(_number, found.rows), *map(_curve, found.curves)))
    assert len(lines) == len(found.rows) + len(found.curves)
    return dict(sorted(lines.items()))


def unpacked(name: str, under: Path) -> Path:
    """The directory of a study. Its records are kept as lines, which any store can take."""
    with zipfile.ZipFile(NET / f"{name}.zip") as archive:
        archive.extractall(under)
    for lines in (under / name).rglob("trials.jsonl"):
        stored.store_lines(lines.parent)
    return under / name


def _number(row: Estimate) -> tuple[str, str]:
    return _of(row), _said(getattr(row, name) for name in COLUMNS)


def _curve(row: Curve) -> tuple[str, str]:
    return f"{_of(row)}, curve", _said((*row.x, *row.value, *row.low, *row.high))


def _of(row: Estimate | Curve) -> str:
    words = row.model_dump(exclude={*COLUMNS, "quantity", "doses", "x"}, exclude_defaults=True)
    doses = [f"{name}={dose:g}" for name, dose in row.doses.items()]
    return ", ".join((row.quantity, *(f"{name}={said}" for name, said in words.items()), *doses))


def _said(values: Iterable[float | None]) -> str:
    return " ".join("none" if value is None else f"{value:.7g}" for value in values)


def kept(name: str) -> dict[str, str]:
    """The numbers as they were written."""
    lines = (NET / f"{name}.txt").read_text("utf-8").splitlines()
    return dict(line.split("\t") for line in lines)


def same(was: str, now: str) -> bool:
    """Whether two lines of numbers differ in their last digits at most."""
    one, other = ([math.nan if word == "none" else float(word) for word in line.split()] for line in (was, now))
    return len(one) == len(other) and other == pytest.approx(one, rel=DIGITS, abs=1e-9, nan_ok=True)


def renew(name: str, under: Path) -> None:
    """Write the numbers of a study."""
    path = NET / f"{name}.txt"
    before = kept(name) if path.exists() else {}
    now = {
        of: before[of] if of in before and same(before[of], said) else said for of, said in numbers(name, under).items()
    }
    path.write_text("".join(f"{of}\t{said}\n" for of, said in now.items()), "utf-8")
    moved = sum(before[of] != said for of, said in now.items() if of in before)
    print(f"{name}: {len(now)} numbers, {len(before.keys() - now)} gone, {len(now.keys() - before)} new, {moved} moved")


if __name__ == "__main__":
    for asked in sys.argv[1:] or STUDIES:
        with tempfile.TemporaryDirectory() as scratch:
            renew(asked, Path(scratch))
