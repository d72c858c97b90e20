"""Error rates of the tests: the audit that ships with the package, equal in every study."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from markupsafe import Markup

from lockprobe.foundation.formatting import percent
from lockprobe.report.prose.hypothesis_tests import QUESTIONS
from lockprobe.report.rows import Results
from lockprobe.report.section import Cells, Note, Part, Section, Template, Text
from lockprobe.simulation.audit.rates import shipped

__all__ = ["SECTIONS"]

_Rate = Mapping[str, Any]
"""A rate of the audit, as its file has it."""


def _show(found: Results) -> Iterator[Part]:
    """The top of the page, its parts, and the note at its end."""
    audit = shipped()
    yield Part("Error rates of the tests", "", [Template("audit_top", {"audit": audit})], name="top")
    for i, (question, asks) in enumerate(QUESTIONS.items(), 1):
        rates = [rate for rate in audit["rates"] if rate["question"] == question]
        yield Part(asks, _highest(rates), [_by_test(rates, audit["worlds"])], name=f"question-{i}")
    if many := audit["many_agents"]["rates"]:
        yield Part(
            "What is said of many agents",
            "A sentence on several agents is false if it is false of one of them.",
            [
                Cells(_said(many), numeric_from=1),
                Template("worlds", {"worlds": audit["many_agents"]["worlds"]}),
                Text(f"Of {many[0]['studies']} studies in each world.", style="note"),
            ],
            name="many-agents",
        )
    yield Part(
        "What is said at every look",
        "A study that is unfinished, was extended, or stops when it is decided is looked at after every block.",
        [Cells(_at_every_look(audit["every_look"]["rates"]), numeric_from=4), Note(_looks(audit["every_look"]))],
        name="every-look",
    )
    end = (
        f"Rejections in per cent of {audit['rates'][0]['studies']} studies in each world. The worlds are simple: they "
        "show some cases in which a test fails, not all."
    )
    yield Part("What the worlds are", "", [Note(end)], name="end")


def _highest(rates: Iterable[_Rate]) -> str:
    """How often a recommended test errs at most; empty if the truth is yes in every world."""
    errors = [rate["rate"] for rate in rates if rate["recommended"] and not rate["truth"]]
    if not errors:
        return ""
    return f"Where the truth is no, the recommended test rejects in at most {percent(max(errors), 1)} of studies."


def _by_test(rates: Iterable[_Rate], worlds: Iterable[str]) -> Cells:
    """A row for each world, a column for each test of a question."""
    known = {(rate["world"], rate["test"]): rate for rate in rates}
    tests = list(dict.fromkeys(test for _, test in known))
    rows = [[world, *(_cell(known[world, test]) for test in tests)] for world in worlds]
    return Cells([["world", *tests], *rows], numeric_from=1)


def _said(rates: Iterable[_Rate]) -> list[list[str]]:
    rows = [[rate["world"], str(rate["agents"]), rate["sentence"], _cell(rate)] for rate in rates]
    return [["world", "agents", "said", "of studies, %"], *rows]


def _at_every_look(rates: Iterable[_Rate]) -> list[list[str]]:
    rows = [
        [rate["says"], str(rate["agents"]), str(rate["worlds"]), rate["world"], _cell({**rate, "truth": False})]
        for rate in rates
    ]
    return [["said falsely at least once", "agents", "worlds", "the worst of them", "of studies, %"], *rows]


def _looks(found: Mapping[str, Any]) -> str:
    return (
        f"Of {found['rates'][0]['studies']} studies of {found['blocks']} blocks in each world, seed {found['seed']}: "
        "those in which a false statement is made at any of the looks, measured by benchmarks/every_look.py."
    )


def _cell(rate: _Rate) -> str:
    """A rate with its error: a power in brackets, a rate that is too high with a mark, a recommended test in bold."""
    said = f"{100 * rate['rate']:.1f} ± {100 * rate['error']:.1f}"
    said = f"[{said}]" if rate["truth"] else said if rate["valid"] else f"{said} !"
    return Markup("<b>{}</b>").format(said) if rate.get("recommended") else said


SECTIONS = (Section(name="audit", title="Error rates of the tests", show=_show, page="audit"),)
