"""Every quantity of a report has its line in the documentation, and every line its quantity."""

import re
from pathlib import Path

from net import STUDIES, kept

ROOT = Path(__file__).parents[2]
MOST = 45
"""Quantities that a reader has to know; what is a variant of one is a part of it (``of``)."""

PAGE = (ROOT / "docs" / "quantities.md").read_text("utf-8")


def test_the_page_lists_what_reports_hold_and_nothing_else():
    first = [line.split("|")[1] for line in PAGE.splitlines() if line.startswith("| `")]
    listed = {name for cells in first for name in re.findall(r"`([a-z_0-9]+)`", cells)}
    found = {re.split(r"[,.]", line)[0] for name in STUDIES for line in kept(name)}
    assert found - listed == {"measures"}
    source = "".join(path.read_text("utf-8") for path in (ROOT / "src/lockprobe/report").rglob("*.py"))
    assert {name for name in listed - found if f'"{name}"' not in source} == set()
    assert len(listed | {"measures"}) <= MOST
