"""Where attempts broke the rules of the box all numbers stay, and no sentence, heading or table judges an agent."""

import re

import pytest
from builders import write_study
from clumsy import CLUMSY

from lockprobe.report.compare.page import difference_table
from lockprobe.report.compare.studies import compare_studies
from lockprobe.report.rows import Results
from lockprobe.report.write import write_report
from lockprobe.studies.options.studyfile import study

AGENTS = ["cognitive:perseverant", "cognitive:careful", "human-inspired"]

ASKED = {
    "flips": ("flips", {"p": [0, 0.4, 0.8]}),
    "modalities": ("flips", {"p": [0], "modality": ["symbolic", "symbolic?tell=state"]}),
    "conditions": ("flips", {"condition": ["flip?p=0.5", "tremble?p=0.3", "flip?p=0.5 + tremble?p=0.3"]}),
    "doses": ("flips", {"sweep": "tremble?p=0,0.3,0.6"}),
    "why": ("why", {}),
}

_NEUTRAL = {
    ("overview", "question"), ("overview", "trial"), ("overview", "changed_nothing"), ("findings", "rules"),
    ("conditions", "answer"), ("readings", "what"), ("readings", "untested"), ("overview", "untested"),
}  # fmt: skip
"""Section and kind of the sentences that judge no agent; beside them only what was counted for a claim is one."""

_IF_DETECTED = "arm_contrast"
"""The quantity that a report has only where false reports are detected to change success."""

_VERDICTS = {
    "claims.html": "<strong>(borne out|(not )?compatible|not decided)",
    "report.html": "raises? the|lowers? the|higher at some|lower at some|Inconclusive|No (difference|effect)",
    "why.html": "raises? the|lowers? the|Inconclusive|No (difference|effect)",
}
"""Words of verdicts on each page, none of which stands in a note."""


@pytest.fixture(scope="module", params=list(ASKED))
def missed(request, tmp_path_factory):
    """A report of several agents whose attempts broke the rules, and the same with a hand that misses nothing."""
    name, more = ASKED[request.param]
    found = []
    for plant in (CLUMSY, "symbolic"):
        planned = study(name, agent=AGENTS, trials=8, repetitions=2, plant=plant, **more)
        directory = write_study(tmp_path_factory.mktemp(request.param) / "study", planned)
        write_report(directory)
        found.append((directory, Results.model_validate_json((directory / "results.json").read_bytes())))
    return found


def test_no_sentence_judges(missed):
    (_, found), (_, kept) = missed
    said = found.not_judged
    assert re.fullmatch(r"No agent is judged: \d+ of \d+ attempts broke the rules of the box\.", said)
    assert found.answer == said
    assert {one.text for one in found.findings if one.judges} == {said}
    assert {(row.note, row.test) for row in found.where("claim")} == {("not judged", said)}
    for one in (found, kept):
        neutral = {(said.section, said.kind) for said in one.findings if not said.judges and said.section != "claims"}
        assert neutral <= _NEUTRAL
    assert kept.not_judged == ""
    assert len({one.text for one in kept.findings if one.judges}) > 3


def test_numbers_stay_and_tables_say_that_they_judge_nobody(missed):
    (directory, found), (clean, kept) = missed
    quantities, others = ({row.quantity for row in one.rows} - {_IF_DETECTED} for one in (found, kept))
    assert quantities == others
    assert {curve.quantity for curve in found.curves} == {curve.quantity for curve in kept.curves}
    tables = sorted(path.name for path in (directory / "tables").glob("*.csv"))
    assert tables == sorted(path.name for path in (clean / "tables").glob("*.csv"))
    for table in tables:
        head, *rows = ((directory / "tables" / table).read_text()).splitlines()
        plain = (clean / "tables" / table).read_text().splitlines()[0]
        assert head.replace(",against the rules", "") == plain.replace(",against the rules", "") + ",judged"
        assert all(row.endswith(",no") for row in rows)


def visible(page):
    """A page without its notes."""
    return re.sub(r"<style.*?</style>|<script.*?</script>|<div class=.note.*?</div>", "", page, flags=re.DOTALL)


def test_pages_say_it_in_headings_and_captions(missed):
    (directory, found), (clean, _) = missed
    said = found.not_judged
    for page in sorted(path.name for path in clean.glob("*.html") if path.name != "audit.html"):
        text, plain = (one.joinpath(page).read_text() for one in (directory, clean))
        assert said in text
        assert said not in plain
        headings = re.findall(r'<span class="says">(.*?)</span>', text, re.DOTALL)
        assert not [one for one in headings if re.search(r"were detected|Highest|rejects?\b|Compared with", one)]
        verdicts = rf"<td[^>]*>(not )?detected</td>|{_VERDICTS[page]}"
        assert not re.search(verdicts, visible(text))
        assert re.search(verdicts, visible(plain))
        figures = [one for one in re.findall(r"<figcaption>(.*?)</figcaption>", text, re.DOTALL) if "Told:" not in one]
        assert all(said in one for one in figures)


@pytest.mark.parametrize("clumsy", [True, False])
def test_studies_are_compared_only_where_the_rules_held(tmp_path, clumsy):
    plant = CLUMSY if clumsy else "symbolic"
    for seed in (1, 2):
        planned = study("flips", agent="cognitive:careful", p=[0], trials=4, repetitions=1, plant=plant, seed=seed)
        write_study(tmp_path / str(seed), planned)
    found = compare_studies([tmp_path / "1", tmp_path / "2"])
    assert found.said.startswith("No agent is judged: ") is clumsy
    assert {row[-1] == "not judged" for row in difference_table(found, found.differences)[1:]} == {clumsy}
