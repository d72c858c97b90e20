"""What was played, which questions a study has, which trial is to be watched first, and what limits the numbers."""

from builders import SOLUTION, make_trial, play_study, played_by_people, small_study
from page_parts import part
from reported import found_in

from lockprobe.report.page import page_of, parts_of, tables_of


def test_the_design_is_named_with_the_hashes_that_a_publication_gives(tmp_path):
    found = found_in(tmp_path, small_study(repetitions=1, trials=1))
    page = page_of(found)
    design = part(page, "design")
    hashes = found.settings_hash, found.results_hash
    for said in (*hashes, "4 joints", "optimum 4 steps", "0, 0.3, 0.6", "re-observed outcome noise"):
        assert said in design
    assert "6 trials of 2 agents." in design
    assert "<dt>Baselines</dt>" not in design  # both are, so that the report is about both
    assert "are reconstructions" in part(page, "limits")


def test_people_are_counted_apart(tmp_path):
    planned = small_study(("participant", "human-inspired"), (0.0, 0.3), 1, 2)
    trials = [*played_by_people(planned, 2), *play_study(small_study(("human-inspired",), (0.0, 0.3), 1, 2))]
    found = found_in(tmp_path, planned, trials)
    page = page_of(found)
    for said in ("8 trials of 1 agent and people.", "<dt>Subjects</dt><dd>people</dd>"):
        assert said in part(page, "design")
    assert "8 of 8 finished; of these, people: 4 of 4" in part(page, "design")
    assert "<code>participant</code>:" not in page
    assert "People practise before their first box" in part(page, "limits")


def test_a_study_has_the_questions_that_apply_to_it(tmp_path):
    """One blind agent that is told the truth."""
    found = found_in(tmp_path, small_study(["random"], (0.0,), 1, 2))
    asked = ["overview", "trials", "conditions", "loops", "speed", "optimal_actions", "design", "agents", "limits"]
    assert [one.name for one in parts_of(found)] == [*asked, "claims"]
    tables = {"success", "conditions", "loops", "speed", "optimal-actions", "claims"}
    assert {name for name, cells in tables_of(found).items() if cells} == tables
    assert "eople" not in page_of(found).split("</style>")[-1]
    assert not found.where("boxes") + found.where("success_difference")


def test_the_trial_to_watch_first_is_a_solved_one_if_there_is_one(tmp_path):
    trials = [
        make_trial(([0, 1, 2] * 7)[:20], agent="llm:a", trial=1),
        make_trial(SOLUTION, agent="llm:a", trial=2),
        make_trial([0], agent="llm:a", trial=3, broken="model"),
    ]
    planned = small_study(["llm:a"], (0.0,), 1, 3)
    for name, own, first in (("both", trials, 1), ("unsolved", trials[:1], 0), ("broken", trials[2:], None)):
        said = found_in(tmp_path / name, planned, own).fact("trials", "first")
        assert said == ("" if first is None else trials[first].key)
