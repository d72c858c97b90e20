"""The table of an article: the numbers of the rows, each agent under each condition once, on as many pages as it takes."""

import re
import shutil
import subprocess
from types import SimpleNamespace as Some

import pytest
from builders import play_study, write_study

from lockprobe.report.paper_table import table_tex
from lockprobe.report.results import results
from lockprobe.studies.options.studyfile import study


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    planned = study(
        "flips", agent=("a_50%=cognitive:perseverant", "human-inspired"), p=(0, 0.6), trials=30, repetitions=1
    )
    return results(write_study(tmp_path_factory.mktemp("table") / "study", planned, play_study(planned)))


def test_the_table_has_six_columns_and_the_numbers_of_the_rows(found):
    lines = table_tex(found).splitlines()
    (head,) = [line for line in lines if line.startswith("agent")]
    assert head.count("&") == 5  # two columns under one head have no sign between them
    rows = [[cell.strip() for cell in line.split("&")] for line in lines if line.startswith("{}")]
    assert [row[1] for row in rows] == ["0", "0.6", "0", "0.6"]
    for row, (agent, condition) in zip(
        rows, [(agent, c) for agent in ("a_50%", "human-inspired") for c in ("truth", "flip?p=0.6")], strict=True
    ):
        solved = found.one("success", agent=agent, condition=condition)
        assert row[2:5] == [
            str(solved.n),
            f"{100 * solved.value:.0f}",
            f"$[{100 * solved.low:.0f}, {100 * solved.high:.0f}]$",
        ]
        if condition != "truth":
            change = found.one("success_difference", agent=agent, condition=condition, control="truth")
            assert row[5] == f"${100 * change.value:+.0f}$"
    assert r"a\_50\%" in rows[0][0]


def test_every_change_of_the_table_is_from_the_control_whatever_else_is_compared(tmp_path):
    conditions = ["flip?p=0.6&others=kept", "drop?p=1"]
    planned = study("flips", agent=("human-inspired", "round-robin"), p=(0, 0.6), condition=conditions, trials=8)
    found = results(write_study(tmp_path / "study", planned))
    against = {row.control for row in found.where("success_difference", agent="human-inspired", of="", versus="")}
    assert len(against) > 1
    shares = {}
    for line in table_tex(found).splitlines():
        if not line.startswith("{}"):
            continue
        agent, at, _, solved, _, change, *_ = map(str.strip, re.split(r"(?<!\\)&", line.removeprefix("{}")))
        shares[agent or next(reversed(shares))[0], at] = float(solved)
        agent, _ = next(reversed(shares))
        if change:
            truth = next(share for (of, _), share in shares.items() if of == agent)
            assert float(change.strip("$")) == pytest.approx(float(solved) - truth, abs=1)
    assert len(shares) == 8


def test_the_caption_says_where_a_change_is_of_fewer_trials_than_the_shares(tmp_path):
    planned = study("flips", agent="cognitive:careful", p=[0, 0.4], trials=6, repetitions=1)
    directory = write_study(tmp_path / "study", planned)
    assert "finished under both" not in table_tex(results(directory))
    records = directory / "trials.jsonl"
    lines = records.read_text("utf-8").splitlines(keepends=True)
    records.write_text("".join(line for line in lines if "p=0.4/rep=1/trial=6" not in line), "utf-8")
    assert table_tex(results(directory)).count("finished under both") == 1


def of_many(agents):
    """Results with so many conditions of each agent, all of them solved in 3 of 10 trials."""
    share = Some(value=0.3, n=10, low=0.1, high=0.6)
    cells = [
        Some(agent=agent, label=agent, condition=f"c{i}", p=None, modality="", get=lambda quantity: share)
        for agent, conditions in agents.items()
        for i in range(conditions)
    ]
    return Some(beside_flips=True, cells=cells, against_control=list, design=Some(conditions=()))


@pytest.mark.parametrize(
    ("agents", "parts"),
    [
        ({"a": 33}, [33]),
        ({"a": 34}, [33, 1]),
        ({"a": 20, "b": 12}, [32]),
        ({"a": 20, "b": 13}, [20, 13]),
        ({"a": 70, "b": 2}, [33, 33, 6]),
        (dict.fromkeys("abcdefghijklmnopqrstuvwxyz", 1), [22, 4]),
    ],
)
def test_a_long_table_goes_on_on_the_next_page(agents, parts):
    said = table_tex(of_many(agents))
    assert [one.count("{}") for one in said.split(r"\end{table*}")[:-1]] == parts
    rows = [line.split(" & ")[:2] for line in said.splitlines() if line.startswith("{}")]
    assert [at for _, at in rows] == [f"c{i}" for many in agents.values() for i in range(many)]
    assert said.count("(continued)") == said.count(r"\addtocounter{table}{-1}") == len(parts) - 1
    starts = [one[one.index("{}") :].split(" & ")[0] for one in said.split(r"\midrule")[1:]]
    assert all(start != "{}" for start in starts)  # every part begins with the name of an agent


@pytest.mark.skipif(shutil.which("pdflatex") is None, reason="TeX is not installed")
def test_every_part_fits_a_page(tmp_path):
    said = table_tex(of_many({"a": 70, "b": 32} | dict.fromkeys("cdefghijklmnopqrstuvwxyz", 1)))
    document = r"\documentclass[twocolumn]{article}\usepackage{booktabs}\begin{document}x" + said + r"\end{document}"
    (tmp_path / "x.tex").write_text(document, "utf-8")
    done = subprocess.run(["pdflatex", "-halt-on-error", "x"], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout
    assert "Overfull" not in done.stdout
    assert "too large" not in done.stdout
