"""What can be false is admitted at the end, and what cannot is not."""

from dataclasses import dataclass

import pytest

from lockprobe.interventions.conditions import read_condition
from lockprobe.people.deception_check import can_be_false
from lockprobe.trial.condition import Condition


@pytest.mark.parametrize(
    "spec",
    [
        "flip?p=0.4", "flip?p=0.4&only=moved + nudge", "burst?p=0.4", "yoked?p=0.4", "correction?p=0.4", "rgb?p=0.4",
        "nudge + rgb?p=0.4", "delay?lag=2", "warn", "tremble?p=0.1", "force?at=4",
    ],
)  # fmt: skip
def test_what_changes_what_is_told_or_done_can(spec):
    assert can_be_false(read_condition(spec))


@pytest.mark.parametrize(
    "spec",
    [
        "truth", "flip?p=0", "delay?lag=0", "drop?p=0.3", "reword?p=1", "nudge",
        "remark", "distract?p=0.3", "nudge + tremble?p=0", "rgb?blur=8", "rgb?p=0",
    ],
)  # fmt: skip
def test_what_leaves_out_rewords_or_adds_beside_the_report_cannot(spec):
    assert not can_be_false(read_condition(spec))


@dataclass(frozen=True, kw_only=True)
class Hush:
    """Somebody's own intervention."""

    def perceive(self, percept, past, task, rng):
        return percept


def test_of_what_another_package_does_nothing_is_known():
    assert can_be_false(Condition(interventions=(Hush(),)))
