"""Each section of a report has one sentence in its heading, with the numbers of the summary."""

from builders import make_trial, play_study, small_study

from lockprobe.analysis.summary import summarise
from lockprobe.lockbox.families import box
from lockprobe.prose.section_answers import section_answers


def test_every_section_has_one_short_sentence_with_the_numbers_of_its_agents():
    study = small_study(["human-inspired", "cognitive:insistent", "random"], (0.0, 0.4), 1, 8)
    summary = summarise(play_study(study), box("chain-4"))
    found = section_answers(summary)
    assert set(found) == {"side", "success", "speed", "loops", "rational", "tests", "said", "conditions"}
    assert all(said.endswith(".") and len(said.split()) <= 28 for said in found.values())
    (subject,) = summary.subjects
    loops = subject.conditions[0].behaviour.loops
    assert found["loops"].endswith(f": {100 * loops.value:.0f} % (cognitive:insistent).")
    assert found["conditions"] == "3 agents, 6 rows."


def test_nothing_is_said_of_a_study_without_trials():
    assert section_answers(summarise([make_trial([], broken="model")], box("chain-4"))) == {}
