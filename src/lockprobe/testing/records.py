"""Checks that facts and trials survive a round trip through JSON."""

from __future__ import annotations

import json
from collections.abc import Mapping

from lockprobe.trial.record import Trial
from lockprobe.trial.trial_json import trial_from_json, trial_to_json


def check_facts(facts: object, whose: str) -> None:
    """Check that facts map names to text, numbers, bools or None, and survive JSON.

    Raises:
        AssertionError: If they do not.
    """
    assert isinstance(facts, Mapping), f"the facts of {whose} are no mapping"
    plain = all(isinstance(fact, str | int | float | None) for fact in facts.values())
    assert plain, f"a fact of {whose} is no text, number, yes or no"
    assert json.loads(json.dumps(dict(facts))) == dict(facts), f"the facts of {whose} do not survive JSON"


def check_record(trial: Trial, whose: str) -> None:
    """Check that a trial did not break and survives JSON.

    Raises:
        AssertionError: If it did, or does not.
    """
    assert trial.error is None, f"a trial of {whose} broke: {trial.error and trial.error.message}"
    assert trial_from_json(trial_to_json(trial)) == trial, f"a trial of {whose} does not survive the record"
