"""From pictures to flips on the page; here the pictures are words in another form, whose false reports are believed."""

import pytest

from lockprobe.report.opened import open_study
from lockprobe.report.pages import page_of, tables_of
from lockprobe.report.results import results_of
from lockprobe.report.study_numbers import study_numbers
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.running.runner import run_study

AGENT, SEEN = "cognitive:perseverant", "symbolic?tell=state&form=json"
ASKED = study(
    "flips",
    agent=[AGENT, "random"],
    repetitions=1,
    trials=16,
    condition=[
        f"seen=flip?p=0.8&only=moved + {SEEN}",
        "replayed=yoked?claims=seen + symbolic?tell=state",
        "profile=flip?like=seen + symbolic?tell=state",
    ],
)


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    directory = tmp_path_factory.mktemp("lab") / "study"
    run_study(ASKED, directory)
    return results_of(study_numbers(open_study(directory)))


def test_its_rows_are_of_every_arm(found):
    own = {"agent": AGENT, "modality": SEEN}
    pictures = found.one("steps_difference", **own, of="pictures")
    share = found.one("share_accounted_for", **own, of="replayed")
    assert (share.value, share.corrected_for, share.family) == (1.0, 2, "pictures against words")
    assert found.one("steps_difference", **own, of="replayed").value == pytest.approx(pictures.value)
    means = [found.one("mean_steps_all", agent=AGENT, condition=label).value for label in ("seen", "truth")]
    assert pictures.value == pytest.approx(means[0] - means[1])
    assert found.one("false_reports_in_arm", **own, of="pictures").value > 20
    misread = [found.one(name, **own, of="") for name in ("hidden_moves", "invented_moves")]
    assert sum(row.count for row in misread) == found.one("false_reports_in_arm", **own, of="pictures").value


def test_the_first_screen_and_the_section_say_the_verdict(found):
    answer = found.answer_of("overview")
    assert f"{AGENT} takes fewer steps with positions as JSON than with words" in answer
    assert "account for the difference: 100 % [" in answer
    assert "Not known: random never said what its actions did" in answer
    page = page_of("report", found)
    assert page.count("do misreadings act as false reports?") == 1
    assert "Do misreadings of pictures act as false reports when agents open chain-4?" in page


def test_the_claim_of_the_paper_has_its_verdict(found):
    verdicts = {row.agent: row.note for row in found.where("claim", of="bridge")}
    assert verdicts == {AGENT: "borne out", "random": "not decided"}
    assert "misreadings give 100 % [" in found.said("claims", "bridge", agent=AGENT, modality=SEEN)[0]


def test_its_tables(found):
    table = tables_of(found)["bridge"]
    assert [line[1] for line in table if line[0] == AGENT] == ["words", "pictures", "replayed", "profile"]
    matrix = tables_of(found)["misread"]
    assert [line[2] for line in matrix if line[0] == AGENT][-1] == "all joints"
