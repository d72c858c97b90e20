"""An agent is said to ignore reports only if enough of them were followed by another action."""

from dataclasses import replace

from builders import make_trial, play_study, small_study

from lockprobe.analysis.summary import summarise
from lockprobe.prose.success import finding

AGENT = "llm:local"


def only(trials):
    (agent,) = summarise(trials).agents
    return agent


def test_an_agent_that_was_never_told_otherwise_is_not_called_blind():
    """Alike at every p because no report differed: that says nothing about the agent."""
    alike = [make_trial((3, 2, 1, 0), agent=AGENT, p=p, trial=t) for p in (0.0, 0.01) for t in (1, 2, 3)]
    assert not only(alike).blind
    told_otherwise = [
        make_trial((3, 2, 1, 0), agent=AGENT, p=p, trial=t, false_at=(1,) if p else ())
        for p in (0.0, 0.4)
        for t in range(10)
    ]
    assert only(told_otherwise).blind
    assert not only([trial for trial in told_otherwise if trial.trial < 9]).blind


def test_of_the_last_report_nobody_can_say_what_the_agent_would_have_done():
    trials = [
        make_trial((1,), agent=AGENT, p=p, trial=t, budget=1, false_at=(1,) if p else ())
        for p in (0.0, 0.4)
        for t in range(30)
    ]
    assert not only(trials).blind
    assert "whatever it was told" not in finding(only(trials))


def test_an_agent_that_heeds_reports_is_not_called_blind_in_small_studies():
    for seed in range(15):
        study = replace(small_study(("human-inspired",), p=(0.0, 0.05), repetitions=1, trials=2), seed=seed)
        (agent,) = summarise(play_study(study)).agents
        assert not agent.blind
