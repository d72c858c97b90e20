"""What was played, which questions a study has, what agents say they are, tidied replies, broken trials and limits."""

from dataclasses import replace

from builders import make_trial, play_study, played_by_people, small_study
from page_parts import part
from reported import found_in

from lockprobe.report.page import Page, parts_of, tables_of
from lockprobe.trial.record import TrialError


def test_people_are_counted_apart(tmp_path):
    planned = small_study(("participant", "human-inspired"), (0.0, 0.3), 1, 2)
    trials = [*played_by_people(planned, 2), *play_study(small_study(("human-inspired",), (0.0, 0.3), 1, 2))]
    found = found_in(tmp_path, planned, trials)
    page = Page(found=found).text()
    for said in ("8 trials of 1 agent and people.", "<dt>Subjects</dt><dd>people</dd>"):
        assert said in part(page, "design")
    assert "8 of 8 finished; of these, people: 4 of 4" in part(page, "design")
    assert "<code>participant</code>:" not in page
    assert "People practise before their first box" in part(page, "limits")


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


def test_broken_trials_are_shown_by_agent_and_boundary_with_the_first_message(tmp_path):
    ends = {("llm:b", 1): "model", ("llm:a", 1): "reply", ("llm:a", 2): "model", ("llm:a", 3): "reply"}
    trials = [
        replace(
            make_trial([0], agent=agent, trial=trial, broken=boundary),
            error=TrialError(boundary=boundary, message=f"<i>{trial}</i>", step=2, again=trial == 1),
        )
        for (agent, trial), boundary in ends.items()
    ]
    found = found_in(tmp_path, small_study(["llm:b", "llm:a"], (0.0,), 1, 3), trials)
    rows = [(row.agent, row.of, row.value) for row in found.where("broken", condition="")]
    assert rows == [("llm:a", "model", 1), ("llm:a", "reply", 2), ("llm:b", "model", 1)]
    assert found.facts_about("llm:a, broken at reply") == {"first message": "<i>1</i>", "will be replayed": "yes"}
    page = Page(found=found).text()
    assert "4 trials; shares and differences hold whatever became of them." in page
    assert '<td>reply</td><td>2</td><td class="long">&lt;i&gt;1&lt;/i&gt;</td><td>yes</td>' in page


def test_facts_that_differ_between_trials_are_listed_up_to_eight(tmp_path):
    facts = [{"model": "m", "few": f"<{i % 2}>", "many": str(i)} for i in range(1, 11)]
    trials = [make_trial([0], agent="llm:a", trial=i, facts=facts[i - 1], budget=1) for i in range(1, 11)]
    found = found_in(tmp_path, replace(small_study(["llm:a"], (0.0,), 1, 10), max_steps=1), trials)
    said = {"model": "m", "few": "<1>; <0>", "many": "10 different values"}
    assert found.facts_about("llm:a") == said
    assert "few <b>&lt;1&gt;; &lt;0&gt;</b>" in Page(found=found).text()
