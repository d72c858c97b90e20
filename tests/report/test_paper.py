"""What an article needs: the paper's exhibits by name, numbers of the study, methods without a spec, and TeX takes it."""

import json
import re
import shutil
import subprocess

import pytest
from builders import write_study
from typed import in_process

from lockprobe.report.page import results_text
from lockprobe.report.paper import condition_in_words, methods_tex, results_tex, write_paper
from lockprobe.report.results import results
from lockprobe.report.rows import Estimate, Fact
from lockprobe.statistics.every_look import E_PROCESS
from lockprobe.studies.options.studyfile import study

EXHIBITS = {"fig3", "fig4", "fig5a", "fig5b", "series-1-success"}


@pytest.fixture(scope="module")
def directory(tmp_path_factory):
    """Two kinds of false reports and two other conditions, one of them named; a baseline beside the agent."""
    kept = [f"flip?p={p}&others=kept" for p in (0.2, 0.6)]
    asked = {"agent": ("a_50%=cognitive:perseverant", "round-robin"), "p": (0, 0.4, 0.6), "trials": 8}
    planned = study("flips", **asked, condition=[*kept, "drop?p=1", "late=nudge?after=3"], repetitions=1)
    return write_study(tmp_path_factory.mktemp("paper") / "study", planned)


@pytest.fixture(scope="module")
def found(directory):
    return results(directory)


def test_the_command_writes_the_exhibits_under_their_names(found, directory, monkeypatch):
    monkeypatch.setattr("lockprobe.report.page.write_report", lambda directory, **_: directory / "report.html")
    (directory / "results.json").write_text(results_text(found), "utf-8")
    folder = directory / "paper"
    assert json.loads(in_process("report", directory, "--paper", "--json").stdout)["paper"] == str(folder)
    files = {path.name: path.read_bytes() for path in folder.iterdir()}
    tables = {"results.tex", "table1.tex", "methods.tex", "references.bib", "example.tex"}
    assert files.keys() == tables | {f"{name}.{form}" for name in EXHIBITS for form in ("pdf", "png")}
    for name in EXHIBITS:
        picture = files[f"{name}.pdf"]
        assert b"/FontFile2" in picture, name
        assert not re.search(rb"/Type3|Date", picture), name  # equal results give equal files
    example, bibliography = (files[name].decode() for name in ("example.tex", "references.bib"))
    assert {*re.findall(r"\\includegraphics\[.*?\]\{(.+?)\}", example)} == {f"{name}.pdf" for name in EXHIBITS}
    assert re.findall(r"\\begin\{(figure\*?)\}", example) == ["figure"] * 5
    assert [*re.findall(r"\\input\{(.+?)\}", example)] == ["methods", "results", "table1"]
    assert "VERSION" not in bibliography
    assert "RESULTS" not in example
    assert "<" not in example  # captions are text


@pytest.mark.skipif(shutil.which("pdflatex") is None, reason="TeX is not installed")
def test_a_real_tex_compiles_it(found, tmp_path):
    folder = write_paper(found, tmp_path)
    for program in ("pdflatex", "bibtex", "pdflatex", "pdflatex"):
        options = ["-interaction=nonstopmode", "-halt-on-error"] if program == "pdflatex" else []
        done = subprocess.run([program, *options, "example"], cwd=folder, capture_output=True, text=True)
        assert done.returncode == 0, done.stdout
    assert not re.search("undefined|Overfull", done.stdout)
    assert (folder / "example.pdf").stat().st_size > 10_000


def rows_of(tex):
    """The rows of a table in TeX, each with the agent whose it is."""
    lines = [line.removeprefix("{}").removesuffix(r" \\") for line in tex.splitlines() if line.startswith("{}")]
    return [tuple(cell.strip() for cell in re.split(r"(?<!\\)&", line)) for line in lines]


def test_the_table_has_the_numbers_of_the_rows_and_changes_from_the_control_alone(found):
    rows = rows_of(results_tex(found))
    changes = {(row.agent, row.condition): row for row in found.against_control()}
    assert len({row.control for row in found.where("success_difference", of="", versus="")}) > 1
    for (agent, at, trials, solved, change, p), cell in zip(rows, found.cells, strict=True):
        share, of = cell.get("success"), changes.get((cell.agent, cell.condition))
        assert (agent, trials) == (cell.agent.replace("_", r"\_").replace("%", r"\%"), str(share.n))
        assert at == condition_in_words(next(one for one in found.design.conditions if one.name == cell.condition))
        assert solved == rf"{100 * share.value:.0f} \% [{100 * share.low:.0f}, {100 * share.high:.0f}]"
        said = change.partition(" ")[0].replace("$-$", "-")
        assert float(said) == pytest.approx(100 * of.value, abs=0.5) if of else said == ""
        assert (p == "") == (of is None)
    assert [row[1] for row in rows[-2:]] == ["missing reports at rate 1", "late"]
    assert sum(bool(row[4]) for row in rows) == 7


def test_a_long_table_goes_on_in_another_float_and_flip_rates_are_numbers(tmp_path):
    planned = study("flips", agent=("random", "round-robin"), p=[i / 20 for i in range(18)], trials=1, repetitions=1)
    said = results_tex(results(write_study(tmp_path / "study", planned)))
    assert [len(rows_of(part)) for part in said.split(r"\end{table*}")[:-1]] == [32, 4]
    assert said.count(r"\addtocounter{table}{-1}") == 1
    assert [row[1] for row in rows_of(said)[:3]] == ["0", "0.05", "0.1"]
    assert r"agent & flip rate & trials & solved & change, points & P \\" in said


METHODS = r"""
We used Lockprobe {}~\cite{{lockprobe}}, which implements the system of Zenkri and Brock~\cite{{zenkri-brock}}. An agent
has 20 steps to open a box whose joints lock each other. The box was chain-4, with 4 joints. The interlock of their box
is not public; ours is a reconstruction. After each action it was shown as positions in words. Joints had neutral
labels, drawn anew in every trial. The box was played by 2 agents (a\_50\% and round-robin). Of these, round-robin is a
baseline. There were 7 conditions: the truth, false reports at rates 0.4 and 0.6, false reports that stay at rates 0.2
and 0.6, missing reports at rate 1 and late (a sentence against repetition, after 3). The flip rate is the probability
that the reported outcome is inverted; a false position is corrected when another joint is attempted. The design has 1
repetition of 8 trials for each agent and condition. Trials of the same number share their random numbers across
conditions and agents (seed 1). 112 of 112 planned trials were finished. Intervals of shares are 95 \% Wilson
intervals~\cite{{wilson1927}}. Changes of success were tested by permutation within blocks and McNemar's exact test,
corrected for at most 2 comparisons of a family; a change counts as detected if \emph{{P}} is below 0.05 and its 95\,\%
interval excludes 0. The settings of the study have the hash \texttt{{{}}}, its records \texttt{{{}}}.
"""


def test_the_methods_hold_no_spec(found):
    said = METHODS.format(found.lockprobe, found.settings_hash, found.results_hash)
    assert methods_tex(found) == " ".join(said.split()) + "\n"


def other_settings(found):
    (box,) = found.study["boxes"]
    boxes = [box | {"name": "fork", "joints": box["joints"][:1]}, box | {"name": "x"}]
    more = {"max_steps": 1, "shuffle": "study", "plant": "fast-twin?width=160", "boxes": boxes}
    return {"study": found.study | more | {"strategy_trials": 3, "strategy_conditions": ["late"]}}


def a_model_and_people(found):
    facts = {("llm:a/b", "model"): "b_1", ("llm:a/b", "top_p"): "0.5", ("llm:a/b", "seed"): "3"}
    facts |= {("participant", name): said for name, said in {"view": "panel", "history": "True"}.items()}
    rows = [Estimate(quantity="replies", agent="llm:a/b", of="asked again", count=3, n=30)]
    rows += [Estimate(quantity="people", agent="participant", value=2, unit="people")]
    told = [Fact(about=about, name=name, text=said) for (about, name), said in facts.items()]
    more = {"facts": (*found.facts, *told), "rows": (*found.rows, *rows)}
    return {"study": found.study | {"agents": ["participant", "llm:a/b", "human-inspired"]}, **more}


def at_every_look(found):
    """Two kinds of modalities, a trial that broke, and tests that hold at every look."""
    rows = [row.model_copy(update={"test": E_PROCESS} if row.control else {}) for row in found.rows]
    rows.append(Estimate(quantity="left_out", of="ended as error", value=3, unit="trials"))
    kept = [row for row in rows if row.quantity != "left_out" or row.value]
    first, *others = found.design.conditions
    conditions = (*(one.model_copy(update={"modality": "rgb"}) for one in (first, *others)), first, *others)
    facts = (Fact(about="overview", name="every_look", text="It holds 95 %."),)
    progress = found.progress.model_copy(update={"every_look": "extended", "finished": 100})
    design = found.design.model_copy(update={"conditions": conditions})
    return {"rows": tuple(kept), "facts": facts, "progress": progress, "design": design}


@pytest.mark.parametrize(
    ("fields", "said"),
    {
        other_settings: (
            "has 1 step to open|The 2 boxes were fork and x, with 1 to 4 joints. After each action it was shown as "
            "positions in words, on the plant fast-twin (width 160). Joints had neutral labels, drawn once for the "
            "study.|There were 6 conditions: |and missing reports at rate 1; strategies also under 1 further: late "
            "(a sentence against repetition, after 3).|repetition of 8 trials (3 of strategies) for"
        ),
        a_model_and_people: (
            r"The box was played by 2 participants and 2 agents (llm:\allowbreak{}a/\allowbreak{}b and human-inspired)."
            r" llm:\allowbreak{}a/\allowbreak{}b: model b\_1, top p 0.5. 3 of its 30 replies could not be used and were "
            "asked for again. Participants: view panel, history shown. There were"
        ),
        at_every_look: (
            "shown as RGB or positions in words.|There were 14 conditions: the truth, false|after 3), for each way of "
            r"showing the box. The|100 of 112 planned trials were finished; 3 trials ended as an error. It holds 95 \%. "
            r"Intervals of shares are 95\,\% confidence sequences~\cite{robbins1970}. Those of changes are|over blocks "
            r"of one trial under every condition|no change~\cite{ville1939}, corrected for at most 2 comparisons of a "
            r"family by closed testing~\cite{vovk-wang2021}; a change counts as detected if"
        ),
    }.items(),
)
def test_the_methods_say_what_was_played_and_how_it_was_judged(found, fields, said):
    text = methods_tex(found.changed(**fields(found)))
    assert [part for part in said.split("|") if part not in text] == []
    assert ("reconstruction" in text) == (fields is not other_settings)
    assert not re.search(r"\w\?\w|\w=\w|&|  ", text)
