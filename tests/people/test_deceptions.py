"""What a study did to people is admitted at the end, and nothing else."""

from dataclasses import dataclass

import pytest

from lockprobe.interventions.conditions import read_condition, shipped
from lockprobe.people.scenes import _KINDS, deceptions
from lockprobe.trial.condition import Condition, place_of


@pytest.mark.parametrize(
    ("specs", "kinds"),
    [
        (["truth", "flip?p=0.4"], ["false"]), (["flip?p=0.4&only=moved + nudge"], ["false"]),
        (["phantom?p=0.4"], ["false"]),
        (["correction?p=0.4"], ["false"]), (["correction?p=0.4&first=truth&last=lie"], ["false"]),
        (["flip?p=0.4 + rgb"], ["false"]), (["delay?lag=2"], ["late"]),
        (["tremble?p=0.1"], ["another"]), (["warn"], ["warned"]),
        (["warn?rate=0.4 + flip?p=0.4"], ["false"]), (["warn + tremble?p=0.1"], ["another", "warned"]),
        (["tremble?p=0.1", "flip?p=0.4 + warn", "delay"], ["false", "late", "another"]),
        *(([spec], []) for spec in (
            "truth", "flip?p=0", "delay?lag=0", "drop?p=0.3", "nudge", "correction?p=1&first=truth&last=truth",
            "remark", "distract?p=0.3", "nudge + tremble?p=0", "rgb?blur=8",
        )),
    ],
)  # fmt: skip
def test_what_changes_what_is_told_or_done_is_named_and_nothing_else(specs, kinds):
    assert deceptions(map(read_condition, specs)) == tuple(kinds)


def test_of_every_shipped_intervention_that_people_can_play_it_is_known_what_it_does():
    named = {name for name, kind in shipped().items() if "?" not in name and place_of(kind) != "remembered"}
    assert set(_KINDS) == named - {"prompt", "hypothesis"}


@dataclass(frozen=True, kw_only=True)
class Hush:
    """Somebody's own intervention."""

    def perceive(self, percept, past, task, rng):
        return percept


def test_of_what_another_package_does_nothing_is_known():
    assert deceptions([Condition(interventions=(Hush(),))]) == ("changed",)
