"""What was played, what is left out of the numbers, and what limits them."""

from builders import play_study, played_by_people, small_study
from reported import found_in

from lockprobe.report.page import page_of


def part_of(found, name):
    return page_of(found).partition(f'id="{name}"')[2].partition("</details>")[0]


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
    page = page_of(found)
    assert "<dt>Subjects</dt><dd>people</dd>" in part
    assert "<code>participant</code>:" not in page
    assert "8 of 8 finished; of these, people: 4 of 4" in part
    assert "People practise before their first box" in part_of(found, "limits")
