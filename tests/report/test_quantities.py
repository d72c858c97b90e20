"""Every quantity of a report has its line in the documentation, and every line its quantity."""

import re
from pathlib import Path

from net import STUDIES, kept

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "quantities.md").read_text("utf-8")


def test_the_page_lists_what_reports_hold_and_nothing_else():
    first = [line.split("|")[1] for line in PAGE.splitlines() if line.startswith("| `")]
    listed = {name for cells in first for name in re.findall(r"`([a-z_0-9]+)`", cells)}
    forks = [name.removesuffix("_change_by_fork") for name in listed if name.endswith("_change_by_fork")]
    listed |= {f"{name}_after_true_report" for name in forks}
    found = {re.split(r"[,.]", line)[0] for name in STUDIES for line in kept(name)}
    assert found - listed == {"measures"}
    source = "".join(path.read_text("utf-8") for path in (ROOT / "src/lockprobe/report").rglob("*.py"))
    unknown = {name for name in listed - found if not re.search(rf'["_{{]{name.split("_")[-1]}|"{name}"', source)}
    assert unknown == set()
