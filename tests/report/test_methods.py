"""The paragraph on the methods: what was played and how, each thing once, and every number of it is of the study."""

import json
import re
from importlib.resources import files

import pytest
from builders import play_study, write_study

from lockprobe.report.methods import methods_tex
from lockprobe.report.results import results
from lockprobe.report.rows import Estimate, Fact
from lockprobe.studies.options.studyfile import study

KEPT = "flip?p=0.4&others=kept"
MODEL = {
    "model": "acme/m",
    "answered by": "m-2026",
    "host": "127.0.0.1",
    "temperature": "0.7",
    "top_p": "provider default",
    "effort": "not taken",
    "max_tokens": "1000",
    "repairs": "4",
}


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    """A named strategy, a condition of strategies beside it, and a baseline; 12 trials of each."""
    planned = study(
        "flips",
        agent=("a_50%=cognitive:perseverant", "random"),
        p=(0, 0.4),
        condition=(KEPT, "late=nudge?after=3"),
        trials=12,
        repetitions=1,
    )
    return results(write_study(tmp_path_factory.mktemp("methods") / "study", planned, play_study(planned)))


def test_every_number_of_the_methods_is_in_the_results(found):
    """But those of the article's conventions: 95 % intervals and the level of 0.05."""
    known = json.dumps(found.plain()) + str(len(found.study["agents"])) + str(len(found.design.conditions))
    for number in re.findall(r"\d[\d.]*\d|\d", methods_tex(found)):
        assert number in known or number in ("95", "0.05", "1927"), number


def test_the_settings_of_a_language_model_are_said(found):
    facts = [Fact(about="random", name=name, text=text) for name, text in MODEL.items()]
    said = methods_tex(found.changed(facts=(*found.facts, *facts)))
    assert (
        r"\texttt{random}: model acme/m, answered by m-2026, on the host 127.0.0.1, temperature 0.7, top-p left to the provider, no reasoning "
        "effort, at most 1000 tokens a reply, a malformed reply asked for again up to 4 times, no seed sent."
    ) in said
    assert "answered by" not in methods_tex(found)
    assert "could not be used" not in said
    again = Estimate(quantity="replies_asked_again", agent="random", value=0.25, count=29, n=116)
    asked = methods_tex(found.changed(rows=(*found.rows, again), facts=(*found.facts, *facts)))
    assert "no seed sent. 29 of its 116 replies could not be used and were asked for again." in asked


def test_what_holds_at_every_look_is_named_with_its_sources(tmp_path, found):
    planned = study("flips", agent=("cognitive:perseverant", "random"), p=(0, 0.2, 0.4), trials=12, repetitions=1)
    trials = [trial for trial in play_study(planned) if trial.trial <= 9 or trial.agent == "random"]
    said = methods_tex(results(write_study(tmp_path / "part", planned, trials)))
    assert r"95\,\% confidence sequences~\cite{robbins1970}" in said
    assert (
        r"\emph{P} is 1 divided by the largest wealth so far, corrected for at most 2 comparisons of a family by"
        in said
    )
    assert "McNemar" not in said
    cited = {key for text in (said, methods_tex(found)) for key in re.findall(r"cite\{(.+?)\}", text)}
    known = files("lockprobe.report").joinpath("templates/references.bib").read_text(encoding="utf-8")
    assert {*re.findall(r"^@\w+\{(.+),$", known, flags=re.MULTILINE)} == cited
    nothing = methods_tex(results(write_study(tmp_path / "none", planned, [])))
    assert r"\emph{P}" not in nothing
