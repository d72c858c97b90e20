"""Thirteen small studies of every kind, with the numbers and pages of their reports as text.

``python tests/frozen.py`` writes them into ``tests/golden/reports`` anew; the diff then shows what a change does to what
a reader sees.
"""

from __future__ import annotations

import gzip
import re
import shutil
import sys
import tempfile
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import pytest
import strangers
from builders import play_study, played_by_people, write_study
from placeholders import undrawn

from lockprobe.report.rows import Curve, Estimate, Finding, Results
from lockprobe.report.write import write_report
from lockprobe.statistics.rationality import JUDGED
from lockprobe.studies.branch import FORKS, branching, play_forks
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.records.journal import Journal, load

FROZEN = Path(__file__).parent / "golden" / "reports"

READER = "cognitive:perseverant"
SMALL: Mapping[str, Any] = {"agent": [READER, "random"], "trials": 8, "repetitions": 2, "seed": 5}

PAGES = ("report", "details", "claims", "why", "forks")


def flip_study(under: Path, name: str, patch: pytest.MonkeyPatch) -> Path:
    return write_study(under / name, study("flips", **SMALL, p=[0, 0.2, 0.4, 0.8]))


def sticky(under: Path, name: str, patch: pytest.MonkeyPatch) -> Path:
    agents = ["human-inspired", "ideal-observer", "random-no-repeat"]
    return write_study(under / name, study("flips", **{**SMALL, "agent": agents}, p=[0, 0.4], flip="sticky"))


def one_rate_broken(under: Path, name: str, patch: pytest.MonkeyPatch) -> Path:
    """A single rate, outcomes alone, and two trials that broke."""
    planned = study("flips", **SMALL, p=[0.4], flip="outcome-only")
    trials = play_study(planned)
    broken = [_broken(trial) if i in {3, 20} else trial for i, trial in enumerate(trials)]
    return write_study(under / name, planned, broken)


def _broken(trial: Any) -> Any:
    from lockprobe.trial.record import TrialError

    error = TrialError(boundary="reply", message="not one JSON object", step=4, replies=("{",))
    return replace(trial, steps=trial.steps[:3], ending="error", error=error, changed={}, changed_steps=0)


def condition_beside_flips(under: Path, name: str, patch: pytest.MonkeyPatch) -> Path:
    return write_study(under / name, study("flips", **SMALL, p=[0, 0.4], condition=["nudge"]))


def sweep(under: Path, name: str, patch: pytest.MonkeyPatch) -> Path:
    return write_study(under / name, study("flips", **SMALL, p=[0], sweep="tremble?p=0.1,0.3,0.6"))


def grid(under: Path, name: str, patch: pytest.MonkeyPatch) -> Path:
    crossed = [f"flip?p={p} + tremble?p={q}" for p in (0.2, 0.6) for q in (0.2, 0.5)]
    sweeps = {"p": [0, 0.2, 0.6], "condition": ["tremble?p=0.2", "tremble?p=0.5", *crossed]}
    return write_study(under / name, study("flips", **SMALL, **sweeps))


def crossed(under: Path, name: str, patch: pytest.MonkeyPatch) -> Path:
    conditions = ["drop?p=0.3", "drop?p=0.3 + flip?p=0.6"]
    return write_study(under / name, study("flips", **SMALL, p=[0, 0.6], condition=conditions))


def modalities(under: Path, name: str, patch: pytest.MonkeyPatch) -> Path:
    small = {**SMALL, "agent": ["human-inspired"], "p": [0, 0.4]}
    return write_study(under / name, study("flips", **small, modality=["symbolic?tell=state", "symbolic?tell=outcome"]))


def why(under: Path, name: str, patch: pytest.MonkeyPatch) -> Path:
    return write_study(under / name, study("why", agent=["cognitive:perseverant"], trials=60))


def forks(under: Path, name: str, patch: pytest.MonkeyPatch) -> Path:
    planned = study("flips", agent=[READER], p=[0, 0.4], trials=6, repetitions=1)
    directory = write_study(under / name, planned)
    wanted = branching(planned, load(directory), keys=(), at=["4"], told=["lie", "lie-truth"])
    with Journal.open(directory / FORKS, planned) as journal:
        play_forks(wanted, journal)
    return directory


def people(under: Path, name: str, patch: pytest.MonkeyPatch) -> Path:
    asked = {"agent": ["participant", "human-inspired"], "p": [0, 0.3], "trials": 6, "repetitions": 2}
    planned = study("flips", **asked)
    trials = [*played_by_people(planned, 2), *play_study(study("flips", **{**asked, "agent": ["human-inspired"]}))]
    return write_study(under / name, planned, trials)


def of_a_package(under: Path, name: str, patch: pytest.MonkeyPatch) -> Path:
    """An intervention and two measures that a package adds."""
    strangers.install(under, patch, points=strangers.POINTS | MEASURES)
    return write_study(under / name, study("flips", **SMALL, p=[0], condition=["hush?steps=2"]))


MEASURES = {"measures": {"untold": "untold", "hasty": "hasty"}}


def options(under: Path, name: str, patch: pytest.MonkeyPatch) -> Path:
    """An option of an agent, and a condition that never acts on it."""
    agents = [READER, f"{READER}?stay=3"]
    return write_study(under / name, study("flips", **{**SMALL, "agent": agents}, p=[0, 0.4], condition=["remark"]))


STUDIES: Mapping[str, Callable[[Path, str, pytest.MonkeyPatch], Path]] = {
    "flips": flip_study,
    "sticky": sticky,
    "one-rate-broken": one_rate_broken,
    "condition-beside-flips": condition_beside_flips,
    "sweep": sweep,
    "grid": grid,
    "crossed": crossed,
    "modalities": modalities,
    "why": why,
    "forks": forks,
    "people": people,
    "of-a-package": of_a_package,
    "options": options,
}


def numbers(directory: Path) -> list[str]:
    """Every number of the results, a line each: what it is of, then its columns with seven digits; then the sentences.

    Of a sentence the line says what it rests on, since the pages hold its text.
    """
    found = Results.model_validate_json((directory / "results.json").read_bytes())
    return [*map(_line, found.rows), *map(_curve, found.curves), *map(_sentence, found.findings)]


NUMBERS = ("value", "low", "high", "p_value", "n", "count", "clusters", "corrected_for")


def _line(row: Estimate) -> str:
    return "\t".join((*_of(row), _said(getattr(row, name) for name in NUMBERS)))


def _curve(row: Curve) -> str:
    return "\t".join((*_of(row), _said((*row.x, *row.value, *row.low, *row.high))))


def _sentence(row: Finding) -> str:
    """Whom a sentence judges, and the quantities that it rests on."""
    of = f"{row.section}, {row.kind}{', judges' * row.judges}{f', of {row.agent}' * bool(row.agent)}"
    return "\t".join((RESTS_ON, of, " ".join(row.rests_on)))


RESTS_ON = "rests on"


def _of(row: Estimate | Curve) -> tuple[str, str]:
    words = row.model_dump(exclude={*NUMBERS, "quantity", "doses", "x"}, exclude_defaults=True)
    doses = [f"{name}={dose:g}" for name, dose in row.doses.items()]
    return row.quantity, ", ".join([*(f"{name}={said}" for name, said in words.items()), *doses])


def _said(values: Iterable[float | None]) -> str:
    return " ".join("none" if value is None else f"{value:.7g}" for value in values)


class _Text(HTMLParser):
    """The text of a page, a block a line, without scripts, styles and drawings."""

    SILENT = frozenset({"script", "style", "svg", "head"})
    INLINE = frozenset({"a", "b", "i", "em", "strong", "code", "span", "wbr", "sup", "sub", "small", "abbr"})

    def __init__(self) -> None:
        super().__init__()
        self.lines: list[str] = [""]
        self.silent = 0

    def handle_starttag(self, tag: str, attrs: object) -> None:
        self.silent += tag in self.SILENT
        self._breaks(tag)

    def handle_endtag(self, tag: str) -> None:
        self.silent -= tag in self.SILENT
        self._breaks(tag)

    def _breaks(self, tag: str) -> None:
        if tag in {"td", "th"}:
            self.lines[-1] += " | "
        elif tag not in self.INLINE:
            self.lines.append("")

    def handle_data(self, data: str) -> None:
        if not self.silent:
            self.lines[-1] += data


def page_text(page: str) -> list[str]:
    """What a reader sees of a page, a block a line."""
    parser = _Text()
    parser.feed(page)
    lines = (re.sub(r"(\| )+", "| ", re.sub(r"\s+", " ", line)).strip(" |") for line in parser.lines)
    return [line for line in lines if line]


def reported(name: str, under: Path) -> tuple[list[str], list[str]]:
    """Numbers and pages of a study that is played below this directory, as they are kept."""
    with pytest.MonkeyPatch.context() as patch, undrawn(judged=JUDGED):
        return _reported(STUDIES[name](under, name, patch))


def _reported(directory: Path) -> tuple[list[str], list[str]]:
    write_report(directory)
    pages = []
    for name in PAGES:
        path = directory / f"{name}.html"
        if path.exists():
            pages += [f"== {name}", *page_text(path.read_text("utf-8"))]
    return numbers(directory), [_without_chance(line) for line in pages]


def _without_chance(line: str) -> str:
    """A line without what differs between machines and releases: times, versions and hashes."""
    line = re.sub(r"\b[0-9a-f]{32}\b", "HASH", line)
    return re.sub(r"\bLockprobe \d+\.\d+\.\d+\S*", "Lockprobe VERSION", line)


def kept(name: str) -> tuple[list[str], list[str]]:
    """Numbers and pages of a study as they were frozen."""
    numbers = gzip.decompress((FROZEN / f"{name}.tsv.gz").read_bytes()).decode()
    return numbers.splitlines(), (FROZEN / f"{name}.txt").read_text("utf-8").splitlines()


def freeze(under: Path) -> None:
    """Keep the reports as they are now."""
    shutil.rmtree(FROZEN, ignore_errors=True)
    FROZEN.mkdir(parents=True)
    for name in STUDIES:
        found, pages = reported(name, under)
        (FROZEN / f"{name}.tsv.gz").write_bytes(gzip.compress(_joined(found).encode(), mtime=0))
        (FROZEN / f"{name}.txt").write_text(_joined(pages), "utf-8")
        print(f"{name}: {len(found)} lines of numbers, {len(pages)} of pages", file=sys.stderr)


def _joined(lines: Sequence[str]) -> str:
    return "".join(f"{line}\n" for line in lines)


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as scratch:
        freeze(Path(scratch))
