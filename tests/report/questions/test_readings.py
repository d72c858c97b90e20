"""What a false report is: what the reading changes."""

import pytest
from reported import found_in, tables_of

from lockprobe.report.format import entry_text
from lockprobe.studies.options.studyfile import study

AGENT, BLIND = "cognitive:perseverant", "random"
KEPT = "flip?p=0.4&others=kept"


def test_readings_are_compared_in_pairs_at_the_same_rate(tmp_path):
    asked = {"agent": [AGENT, BLIND], "p": [0, 0.4, 0.6], "flip": "re-observed,integrated", "trials": 20, "seed": 3}
    found = found_in(tmp_path, study("flips", **asked, condition="no-feedback=drop?p=1", repetitions=1))
    head, *rows = tables_of(found)["effects"]
    effects = [dict(zip(head, row, strict=True)) for row in rows]
    shown = [row for row in effects if row["agent"] == AGENT and row["control"].startswith("flip")]
    assert [(row["condition"], row["control"]) for row in shown] == [
        (f"flip rate {rate}, false reports that stay", f"flip rate {rate}") for rate in ("0.4", "0.6")
    ]
    gap = found.one("success_difference", agent=AGENT, condition=KEPT, control="flip?p=0.4")
    assert shown[0]["difference, points"] == entry_text(gap)
    kept, fresh = (found.one("success", agent=AGENT, condition=name) for name in (KEPT, "flip?p=0.4"))
    assert gap.value == pytest.approx(kept.value - fresh.value)
    assert found.where("success_difference", agent=BLIND, control="flip?p=0.4") == []  # it plays alike
