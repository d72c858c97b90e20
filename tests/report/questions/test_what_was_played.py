"""What was played, seen and said: questions that apply, pictures, misreadings, tidied replies, what broke, and limits."""

import base64
import re
from dataclasses import replace

import numpy as np
import pytest
from builders import SOLUTION, make_trial, modality_study, play_study, small_study
from report.conftest import NAMES
from reported import found_in, tables_of

from lockprobe.boxes.families import box
from lockprobe.report.page import Page, parts_of
from lockprobe.report.questions.seen import embedded
from lockprobe.report.rows import Fact, Results
from lockprobe.trial.pictures.frame import from_png, to_png
from lockprobe.trial.record import TrialError


def part(page, name):
    """The markup of a part of ``report.html``; empty if the page has none of this name."""
    opens = rf'<details class="q" id="{re.escape(name)}">'
    found = re.search(rf'{opens}\n(.*?)(?=<details class="q" id=|</section>|</body>)', page, re.DOTALL)
    return found[1] if found else ""


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
    decision = replace(first.steps[0].decision, replies=("{", "[", "```{}```"), tidied=("text", "syntax"))
    first = replace(first, steps=(replace(first.steps[0], decision=decision), *first.steps[1:]))
    found = found_in(tmp_path, study, trials := [first, *others[:4], refused])
    assert found.one("broken", agent="random", condition="", of="refusal").value == 1
    broken = "random, broken at refusal"
    assert found.facts_about(broken) == {"first message": "refused: I cannot help.", "will be replayed": "no"}
    again, tidied = sorted(found.where("replies"), key=lambda row: row.of)
    assert (tidied.of, tidied.count, tidied.n) == ("tidied", 1, sum(len(trial.steps) for trial in trials))
    page = Page(found=found).text()
    assert (again.of, again.agent, again.count, again.n) == ("asked again", "random", 2, 3)
    assert "<p>2 of 3 replies of <code>random</code> could not be used and were asked for again.</p>" in page
    assert "They were tidied, and count as all others do." in page
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


def test_table_1_has_a_row_for_each_modality(tmp_path, modal):
    found = found_in(tmp_path, modality_study(), modal)
    head, *rows = tables_of(found)["table1"]
    assert head[:3] == ["agent", "modality", "claims"]
    assert [(row[1], *row[-2:]) for row in rows] == [
        ("RGB", "10", "10 of 10"),
        ("RGB-D", "30", "10 of 10"),
        ("positions and outcomes in words", "4", "4 of 10"),
    ]
    assert "Table 1" in part(Page(found=found).text(), "misreading")


def test_claims_are_held_against_reports_and_against_the_truth(tmp_path):
    """Two claims of each trial contradict the report, one of a step with a false report; another one believes it."""
    trials = [
        make_trial((0, 0, *SOLUTION), agent="llm:local", trial=i, p=0.4, false_at=(1, 2),
                   claims=[None, "moved", "blocked", "blocked", "moved", "moved"])
        for i in (1, 2, 3)
    ]  # fmt: skip
    found = found_in(tmp_path, small_study(("llm:local",), (0.4,), 1, 3), trials)
    (cell,) = found.cells
    rows = map(cell.get, ("misread", "false_report", "false_belief"))
    assert {(row.count, row.n, row.clusters) for row in rows} == {(6, 15, 3)}
    parts = cell.get("misread", "said moved"), cell.get("misinterpretations", "trials with any")
    assert [(row.count, row.n, row.clusters) for row in parts] == [(0, 6, 3), (3, 3, None)]
    assert cell.get("false_report", "steps").n == 18
    assert cell.value("misinterpretations") == 6
    share = "40 % [{:.0f}, {:.0f}]".format(*(100 * end for end in (cell.get("misread").low, cell.get("misread").high)))
    assert tables_of(found)["table1"][1] == ["llm:local", "0.4", "15", share, "40.0 %", "0.0 %", "6", "3 of 3"]


def test_the_rate_is_the_mean_over_trials_and_misread_is_pooled_over_claims(tmp_path):
    """One claim of one is misread, and none of three; agents that were not asked have no row."""
    said = ([None, "moved", None, None], [None, *["blocked"] * 3])
    trials = [make_trial((0,) * 4, agent="llm:a", claims=one, trial=i, budget=4) for i, one in enumerate(said, 1)]
    silent = [make_trial((0,) * 4, agent="llm:b", trial=i, budget=4) for i in (1, 2)]
    planned = replace(small_study(("llm:a", "llm:b"), (0.0,), 1, 2), max_steps=4)
    found = found_in(tmp_path, planned, [*trials, *silent])
    (cell,) = (one for one in found.cells if one.get("misread"))
    assert cell.value("misread") == 0.25
    assert cell.value("misinterpretations", "rate") == 0.5
    assert cell.value("misinterpretations", "SD of rates") == pytest.approx(0.5**0.5)
    assert "25&nbsp;% of the claims contradict the report" in Page(found=found).text()
    assert part(Page(found=found_in(tmp_path / "b", planned, silent)).text(), "misreading") == ""


def test_pictures_for_agents_are_shown_with_what_was_told_and_a_page_without_files_says_why(tmp_path, modal):
    found = found_in(tmp_path, modality_study(trials=2), [trial for trial in modal if trial.trial <= 2])
    kinds = [(fact.name, fact.text) for fact in found.facts if fact.name in ("rgb", "depth", "depth16")]
    names = [NAMES[i] for i in (0, 1, 0, 2, 1, 4)]  # those that only the record needs are left out
    assert kinds == list(zip(("rgb", "rgb", "rgb", "depth", "rgb", "depth"), names, strict=True))
    shown = part(Page(found=found, photographs={name: f"data:{name}" for name in NAMES}).text(), "seen")
    assert shown.count("Told: “”") == 4
    assert shown.count("<img src=") == 6
    assert f'<img src="data:{NAMES[2]}" alt="The box before the first step">' in shown
    assert "After step 1: revolute-left did not move." in shown
    missing = "No pictures are shown: the files, or the package pillow, are missing."
    assert missing in part(Page(found=found).text(), "seen")
    assert missing not in shown


def shown_small(directory, pixels, kind="rgb", name=f"{1:020x}.png"):
    """A picture as a page would show it; None if it shows none."""
    (directory / "pictures").mkdir(exist_ok=True)
    (directory / "pictures" / name).write_bytes(to_png(pixels) if pixels is not None else b"torn")
    facts = [Fact(about="seen rgb 1", name=kind, text=name)]
    found = embedded(directory, Results.model_construct(facts=facts)).get(name)
    return found and from_png(base64.b64decode(found.partition(",")[2]))


def test_colours_are_averaged_and_depth_gets_no_new_codes(tmp_path):
    """Codes of depth that alternate: their mean would be that of another depth."""
    even = np.full((301, 700, 3), 9, np.uint8)
    even[:, ::3] = 12
    small = shown_small(tmp_path, even)
    assert small.shape == (100, 233, 3)
    assert (small == 10).all()
    pixels = np.zeros((480, 640, 3), np.uint8)
    pixels[..., 0], pixels[..., 2] = 4, 248
    pixels[::2, ::3, 0], pixels[::2, ::3, 2] = 8, 0
    small = shown_small(tmp_path, pixels, "depth")
    assert small.shape == (240, 320, 3)
    assert {tuple(code) for code in small.reshape(-1, 3).tolist()} <= {(4, 0, 248), (8, 0, 0)}
    assert shown_small(tmp_path, pixels[..., 0], "depth").shape == (240, 320)
