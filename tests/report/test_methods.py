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


def test_every_condition_stands_once_with_what_its_name_stands_for(found):
    said = methods_tex(found)
    assert r"(\texttt{a\_50\%} and \texttt{random})" in said
    assert r"\texttt{random} is a baseline." in said
    assert r"\texttt{late} = \texttt{nudge?after=3}" in said
    assert said.count(r"\texttt{flip?p=0.4\&others=kept}") == 1
    assert "1 repetition of 12 trials" in said
    assert "shown as positions in words. Joints had neutral labels, drawn anew in every trial." in said


def test_conditions_of_strategies_alone_stand_once(found):
    alone = found.changed(study=dict(found.study) | {"strategy_conditions": [KEPT]})
    assert r"There were 3 conditions: \texttt{truth}, " in methods_tex(alone)
    assert r"; strategies also under 1 further: \texttt{flip?p=0.4\&others=kept}. \texttt{lockprobe" in methods_tex(
        alone
    )
    assert methods_tex(alone).count("others=kept") == 1


def test_only_what_was_played_is_called_a_reconstruction(found, tmp_path):
    assert "ours is a reconstruction" in methods_tex(found)
    assert "strategy, whose algorithm" not in methods_tex(found)
    planned = study("flips", agent="human-inspired", box="reset", p=(0,), trials=1, repetitions=1)
    other = methods_tex(results(write_study(tmp_path / "study", planned)))
    assert "ours is a reconstruction" not in other
    assert r"\texttt{human-inspired} reconstructs their strategy, whose algorithm is not public." in other


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


def test_people_are_counted(found):
    people = found.changed(
        study=dict(found.study) | {"agents": ["participant", "random"]},
        facts=[
            Fact(about="participant", name=name, text=text)
            for name, text in (("design", "within"), ("feedback", "False"))
        ],
    )
    rows = [
        Estimate(quantity="people", agent="participant", value=12),
        *(
            Estimate(quantity="boxes_each", agent="participant", of=of, value=n)
            for of, n in (("fewest", 1), ("most", 2))
        ),
    ]
    said = methods_tex(people.changed(rows=(*people.rows, *rows)))
    assert r"played by 12 participants and 1 agent (\texttt{random})." in said
    assert r"Participants: design \texttt{within}, feedback not shown, 1 to 2 boxes finished by each." in said
    assert "clustered by person for people" in said


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
