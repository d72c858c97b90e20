"""What was played, what is left out of the numbers, and what limits them."""

from dataclasses import replace

from builders import SOLUTION, make_trial, play_study, played_by_people, small_study, write_study

from lockprobe.report.opened import open_study
from lockprobe.report.pages import page_of
from lockprobe.report.results import results_of
from lockprobe.report.study_numbers import study_numbers
from lockprobe.studies.options.studyfile import study


def found_in(directory, planned, trials=None):
    return results_of(study_numbers(open_study(write_study(directory / "study", planned, trials))))


def part_of(found, name):
    return page_of("report", found).partition(f'id="{name}"')[2].partition("</details>")[0]


def test_what_is_left_out_is_counted(tmp_path):
    study = small_study(["random"])
    broken = make_trial([0], agent="random", p=0.3, repetition=2, trial=4, broken="model")
    stranger = make_trial(SOLUTION, agent="random", p=0.3, repetition=9)
    found = found_in(tmp_path, study, [*play_study(study)[:5], broken, stranger])
    left_out = {row.of: row.value for row in found.where("left_out")}
    assert (left_out.pop("ended as error"), left_out.pop("outside the settings")) == (1, 1)
    assert left_out
    assert not any(left_out.values())
    part = part_of(found, "design")
    for said in (
        "1 trials that ended as error, 0 incomplete lines",
        "1 trials outside the settings",
        "5 of 24 finished",
    ):
        assert said in part


def test_the_design_is_named_with_the_hashes_that_a_publication_gives(tmp_path):
    found = found_in(tmp_path, small_study(repetitions=1, trials=1))
    part = part_of(found, "design")
    for said in (
        found.settings_hash,
        found.results_hash,
        "4 joints",
        "optimum 4 steps",
        "0, 0.3, 0.6",
        "re-observed outcome noise",
    ):
        assert said in part
    assert "6 trials of 2 agents." in part
    assert "<dt>Baselines</dt>" not in part  # both are, so that the report is about both
    assert "are reconstructions" in part_of(found, "limits")


def test_people_are_counted_apart(tmp_path):
    planned = small_study(("participant", "human-inspired"), (0.0, 0.3), 1, 2)
    trials = [*played_by_people(planned, 2), *play_study(small_study(("human-inspired",), (0.0, 0.3), 1, 2))]
    found = found_in(tmp_path, planned, trials)
    part = part_of(found, "design")
    assert "8 trials of 1 agent and people." in part
    page, details = page_of("report", found), page_of("details", found)
    assert "<dt>Subjects</dt><dd>people</dd>" in part
    assert "<h3><code>people</code></h3>" in details
    assert "Effects that are not estimated for <code>people</code>" in page
    assert "<code>participant</code>:" not in page + details
    assert "8 of 8 finished; of these, people: 4 of 4" in part
    assert "People practise before their first box" in part_of(found, "limits")


def test_conditions_have_limits_of_their_own(tmp_path):
    asked = {"agent": ["cognitive:careful", "cognitive:perseverant"], "trials": 2, "repetitions": 1}
    flips = part_of(found_in(tmp_path / "a", study("flips", **asked, p=[0, 0.4])), "limits")
    other = found_in(tmp_path / "b", study("flips", **asked, p=[0], condition=["nudge"]))
    assert "<dt>Conditions</dt><dd><code>truth</code>, <code>nudge</code></dd>" in part_of(other, "design")
    shown = "A difference between conditions shows the effect of an intervention"
    assert (shown in flips, shown in part_of(other, "limits")) == (False, True)
    pairs = "pairs of agents, each for the number of agents"
    assert (pairs in flips, "People practise" in flips) == (True, False)


def test_a_real_box_is_not_called_simulated(tmp_path):
    planned = replace(small_study(["random"], (0.0,), 1, 1), plant="manual")
    part = part_of(found_in(tmp_path, planned, [make_trial(SOLUTION, agent="random")]), "design")
    assert "<code>manual</code>, a real box that a person moves" in part
