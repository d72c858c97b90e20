"""Conditions under which no model of choices predicts anything."""

from lockprobe.interventions.catalogue import shipped
from lockprobe.simulation.fit.unpredicted import why_unpredicted
from lockprobe.trial.condition import place_of


def test_only_what_takes_reports_from_the_agent_is_not_predicted():
    for name, kind in shipped().items():
        spec = f"{name}=rgb" if "?" in name else name
        assert bool(why_unpredicted([spec])) == (place_of(kind) == "remembered")
    assert why_unpredicted([]) == ""
    assert "history takes reports" in why_unpredicted(["flip?p=0.4", "history?last=2", "nudge"])


def test_an_intervention_that_is_not_here_is_not_predicted_and_says_why():
    assert "no intervention is called 'shout'" in why_unpredicted(["nudge", "shout?p=0.2"])
    assert "python:somebody:Shout" in why_unpredicted(["python:somebody:Shout"])
