"""``lockprobe readings``, as typed."""

import json

import pytest
from typed import in_process

from lockprobe.foundation.errors import BadValue
from lockprobe.simulation.exact.readings import FALSE_REPORTS, as_table, success_under


def ask(*words):
    return in_process("readings", *words).output


GIVEN = ("--agent", "human-inspired", "--p", "0,0.4", "--box", "chain-3", "--max-steps", 5)


def test_it_prints_a_table_of_every_kind_of_false_report():
    text = ask(*GIVEN)
    assert text.endswith(as_table(success_under(["human-inspired"], "chain-3", p=[0, 0.4], max_steps=5)) + "\n")
    assert all(f"| {name} | 1.000 [0.00] | " in text or f"| {name} | 0." in text for name in FALSE_REPORTS)


def test_it_prints_one_object_a_cell():
    cells = [json.loads(line) for line in ask(*GIVEN, "--json").splitlines()]
    assert len(cells) == 2 * len(FALSE_REPORTS)
    assert cells[1] | {"success": 0} == {
        "agent": "human-inspired", "name": "re-observed outcome noise", "condition": "flip?p=0.4", "p": 0.4,
        "success": 0, "low": cells[1]["success"], "high": cells[1]["success"],
        "false_outcomes": pytest.approx(0.4), "trials": None,
    }  # fmt: skip


def test_a_rate_that_is_none_is_named():
    with pytest.raises(BadValue, match=r"^p: got 'much', expected numbers from 0 to 1 with commas between"):
        ask("--p", "much")
