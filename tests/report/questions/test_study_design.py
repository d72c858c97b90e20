"""What was played, which questions a study has, what agents say they are, tidied replies, broken trials and limits."""

from dataclasses import replace

from builders import make_trial, play_study, small_study
from page_parts import part
from reported import found_in

from lockprobe.boxes.families import box
from lockprobe.report.page import Page, parts_of, tables_of
from lockprobe.trial.record import TrialError


def test_a_study_has_the_questions_that_apply_to_it(tmp_path):
    """One blind agent that is told the truth."""
    found = found_in(tmp_path, small_study(["random"], (0.0,), 1, 2))
    asked = ["overview", "trials", "loops", "speed", "optimal_actions", "conditions", "design", "agents", "limits"]
    assert [one.name for one in parts_of(found)] == [*asked, "claims"]
    tables = {"conditions", "claims"}
    assert {name for name, cells in tables_of(found).items() if cells} == tables
    assert "eople" not in Page(found=found).text().split("</style>")[-1]
    assert not found.where("boxes") + found.where("success_difference")


def test_refusals_and_tidied_replies_are_counted_by_agent(tmp_path):
    study = small_study(["random"])
    first, *others = play_study(study)
    refused = replace(
        make_trial([0], agent="random", p=0.3, repetition=2, trial=4, broken="model"),
        error=TrialError(boundary="refusal", message="refused: I cannot help.", step=2),
    )
    decision = replace(first.steps[0].decision, replies=("{", "[", "```{}```"), tidied=("fence", "prose"))
    first = replace(first, steps=(replace(first.steps[0], decision=decision), *first.steps[1:]))
    found = found_in(tmp_path, study, trials := [first, *others[:4], refused])
    assert found.one("broken", agent="random", condition="", of="refusal").value == 1
    broken = "random, broken at refusal"
    assert found.facts_about(broken) == {"first message": "refused: I cannot help.", "will be replayed": "no"}
    again, *tidied = sorted(found.where("replies"), key=lambda row: row.of)
    said = ("tidied", "tidied, a code fence", "tidied, text around the object")
    assert [(row.of, row.count) for row in tidied] == [(of, 1) for of in said]
    assert {row.n for row in tidied} == {sum(len(trial.steps) for trial in trials)}
    details, page = Page(found=found).text(), Page(found=found).text()
    assert (again.of, again.agent, again.count, again.n) == ("asked again", "random", 2, 3)
    assert "<p>2 of 3 replies of <code>random</code> could not be used and were asked for again.</p>" in details
    assert "They were tidied, and count as all others do." in details
    assert "a code fence 1, text around the object 1" in details
    assert "refused: I cannot help." in page
    assert "1 trial; shares and differences hold whatever became of it." in page


def test_a_prior_that_true_reports_contradict_is_said_to_be_wrong(tmp_path):
    """A target that needs two joints open is in none of the priors."""
    both = {"revolute-left": ({"slider-1": True, "slider-2": True},)}
    planned = replace(
        small_study(["random"], (0.0,), 1, 6), boxes=(replace(box("chain-4"), name="both", interlock=both),)
    )
    assert "On this box true reports contradict this prior" in part(
        Page(found=found_in(tmp_path, planned)).text(), "optimal_actions"
    )
