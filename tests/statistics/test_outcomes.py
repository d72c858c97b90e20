"""Trials as columns: what the tests look at is what the records say; agents that play alike whatever they are told."""

from dataclasses import replace

from builders import make_trial

from lockprobe.statistics.outcomes import plays_alike

AGENT = "llm:local"


def alike(reports, **more):
    """Trials told the truth and lied to in the first of their steps, acted in alike."""
    return [
        make_trial((3, 2, 1, 0), agent=AGENT, p=p, trial=t, **more | {"false_at": (1,) if p else ()})
        for p in (0.0, 0.4)
        for t in range(reports)
    ]


def test_an_agent_is_blind_if_ten_reports_differed_and_none_of_its_actions():
    assert not plays_alike(alike(9))
    assert plays_alike(alike(10))
    heeds = make_trial((3, 1, 2, 0), agent=AGENT, p=0.4, trial=0, false_at=(1,))
    assert not plays_alike([*alike(10)[:-1], heeds])
    last = [replace(trial, steps=trial.steps[:1]) for trial in alike(30)]  # nobody knows what it would have done next
    assert not plays_alike(last)
