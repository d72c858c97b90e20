"""Sentences name the dose that conditions differ in."""

from builders import SOLUTION, make_trial

from lockprobe.report.prose.doses import at_dose, cause
from lockprobe.report.prose.hypothesis_tests import asked, effect_said
from lockprobe.report.prose.success import finding
from lockprobe.statistics.conditions.axis import FLIPS, Axis
from lockprobe.statistics.summary import summarise

TREMBLE = Axis(kind="tremble", dose="p", rest="nudge")


def test_a_dose_is_named_with_its_cause_and_its_zero():
    assert (cause(FLIPS), at_dose(0), at_dose(0.4)) == ("false reports", "when told the truth", "at a flip rate of 0.4")
    assert (cause(TREMBLE), at_dose(0, TREMBLE)) == ("higher doses of tremble", "under nudge alone")
    assert at_dose(0.4, TREMBLE) == "at a tremble p of 0.4"
    assert cause(Axis(kind="rgb", dose="blur")) == "higher doses of rgb blur"


def test_sentences_about_another_dose_say_nothing_of_flips():
    made = [
        make_trial(SOLUTION if i < n else (0,) * 20, p=p, trial=i + 1)
        for p, n in ((0.0, 9), (0.4, 4))
        for i in range(9)
    ]
    (agent,) = summarise(made, axis=TREMBLE).agents
    said = [
        finding(agent),
        asked("speed", TREMBLE),
        *(effect_said(test.name, TREMBLE) for test in agent.inference.tests),
    ]
    assert not [one for one in said if "flip" in one or "false reports" in one.lower() or "the truth" in one]
    assert "under nudge alone" in said[0]


def test_an_effect_of_another_reading_names_it():
    made = [
        make_trial((0,) * 20 if p and i < 20 else SOLUTION, p=p, trial=i + 1) for p in (0.0, 0.4) for i in range(30)
    ]
    said = []
    for options in ("", "others=kept"):
        (agent,) = summarise(made, axis=Axis(kind="flip", dose="p", options=options)).agents
        said.append(finding(agent).partition(" than when told the truth")[0])
    first, second = (one.partition("solved the box less often ")[2] for one in said)
    assert (first, second) == ("at a flip rate of 0.4", "with false reports that stay at a flip rate of 0.4")
