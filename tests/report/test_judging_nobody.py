"""Where attempts broke the rules of the box all numbers stay, and no sentence, heading or table judges an agent."""

import json
import re

import pytest
from builders import write_study
from clumsy import CLUMSY

from lockprobe.report import write_report
from lockprobe.report.compare import compare_studies
from lockprobe.report.compare_page import difference_table
from lockprobe.studies.studyfile import study

AGENTS = ["cognitive:perseverant", "cognitive:careful", "human-inspired"]

ASKED = {
    "flips": ("flips", {"p": [0, 0.4, 0.8]}),
    "modalities": ("flips", {"p": [0], "modality": ["symbolic", "symbolic?tell=state"]}),
    "conditions": ("flips", {"condition": ["flip?p=0.5", "tremble?p=0.3", "flip?p=0.5 + tremble?p=0.3"]}),
    "doses": ("flips", {"sweep": "tremble?p=0,0.3,0.6"}),
    "why": ("why", {}),
}

_SENTENCES = {
    "answer", "answers", "beside", "chance", "comparisons_said", "conclusions", "courses_said", "findings",
    "forks_said", "interaction", "loop_findings", "modality_findings", "needed", "ranking_said", "said", "verdict",
}  # fmt: skip
"""Fields of the results that hold sentences on agents."""

_NEUTRAL = {"not judged", "not measured"}
"""Verdicts that are none."""


@pytest.fixture(scope="module", params=list(ASKED))
def missed(request, tmp_path_factory):
    """A report of several agents whose attempts broke the rules, and the same with a hand that misses nothing."""
    name, more = ASKED[request.param]
    found = []
    for plant in (CLUMSY, "symbolic"):
        planned = study(name, agent=AGENTS, trials=15, repetitions=2, plant=plant, **more)
        directory = write_study(tmp_path_factory.mktemp(request.param) / "study", planned)
        write_report(directory)
        found.append((directory, json.loads((directory / "results.json").read_text())))
    return found


def sentences(value, name=""):
    """All sentences on agents in results, with the name of their field."""
    if isinstance(value, str):
        return {(name, value)} if name in _SENTENCES and (value.endswith(".") or name == "verdict") else set()
    if isinstance(value, dict):
        inner = [
            sentences(one, key if name != "answers" else name) for key, one in value.items() if key != "conditions"
        ]
        return set().union(*inner)
    return set().union(*(sentences(one, name) for one in value)) if isinstance(value, list) else set()


def test_no_sentence_judges(missed):
    (_, content), (_, kept) = missed
    said = content["not_judged"]
    assert re.fullmatch(r"No agent is judged: \d+ of \d+ attempts broke the rules of the box\.", said)
    assert content["findings"] == [said]
    assert content["overview"]["answer"] == said
    assert {one for _, one in sentences(content)} <= {said, *_NEUTRAL}
    assert kept["not_judged"] == ""
    assert len(sentences(kept)) > 3


def test_numbers_stay_and_tables_say_that_they_judge_nobody(missed):
    (directory, content), (clean, kept) = missed
    assert content.keys() == kept.keys()
    tables = sorted(path.name for path in (directory / "tables").glob("*.csv"))
    assert tables == sorted(path.name for path in (clean / "tables").glob("*.csv"))
    for table in tables:
        head, *rows = ((directory / "tables" / table).read_text()).splitlines()
        plain = (clean / "tables" / table).read_text().splitlines()[0]
        assert head.replace(",against the rules", "") == plain.replace(",against the rules", "") + ",judged"
        assert all(row.endswith(",no") for row in rows)


def test_pages_say_it_in_headings_and_captions(missed):
    (directory, content), (clean, _) = missed
    said = content["not_judged"]
    for page in sorted(path.name for path in clean.glob("*.html") if path.name != "audit.html"):
        text, plain = (one.joinpath(page).read_text() for one in (directory, clean))
        assert said in text
        assert said not in plain
        headings = re.findall(r'<span class="says">(.*?)</span>', text, re.DOTALL)
        assert not [one for one in headings if re.search(r"were detected|Highest|rejects?\b|Compared with", one)]
        visible = re.sub(r"<style.*?</style>|<script.*?</script>|<div class=.note.*?</div>", "", text, flags=re.DOTALL)
        assert not re.search(r"<td[^>]*>(not )?detected</td>", visible)
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
