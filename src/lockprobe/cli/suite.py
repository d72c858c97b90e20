"""Runs a suite from the command line: its studies one after the other, then its page."""

from __future__ import annotations

import json as json_
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import cast

import typer

from lockprobe.cli.format_cost import print_estimates, say_unlimited
from lockprobe.cli.printing import print_rows
from lockprobe.cli.progress import results_line, settings_line
from lockprobe.cli.run_study import BUDGET_REACHED, allowed_budget, play_study
from lockprobe.foundation.errors import BadValue, Conflict
from lockprobe.foundation.left_out import LeftOutSection, without
from lockprobe.studies.costs.call_log import read_calls
from lockprobe.studies.costs.spending import Ledger
from lockprobe.studies.file_names import SETTINGS, is_suite
from lockprobe.studies.options import paper
from lockprobe.studies.options.agent_names import joined_agents
from lockprobe.studies.options.settings import read_study
from lockprobe.studies.records.results_hash import hash_of_parts, hashes_of_suite
from lockprobe.studies.running.runner import Limits
from lockprobe.studies.study import LIMITS, Study
from lockprobe.studies.suites import Suite, begin_suite, read_suite, suite_directories, suite_studies
from lockprobe.studies.until import MOST, Until

__all__ = ["report_suite", "run_suite"]

_CHOSEN = ("agent", "until", "most")
"""Options of a study that the user of a suite may set."""


def run_suite(
    suite: Suite,
    asked: Mapping[str, object],
    out: Path | None,
    limits: Limits,
    *,
    budget: float | None,
    again: str | None,
    estimate: bool,
    report: bool,
    json: bool,
) -> None:
    """Play the owed trials of a suite, and write its page.

    Raises:
        Conflict: If the suite fixes an option that is given.
        BadValue: If ``again`` is given before the suite has been played.
    """
    for name in asked:
        if name not in _CHOSEN:
            option = "--" + name.replace("_", "-")
            raise Conflict(option, suite.name, "a suite fixes everything except --agent, --until and --most")
    directory = out or Path("lockprobe-runs") / suite.name
    suite = _as_asked(suite, directory, asked)
    studies = suite_studies(suite, _agents(suite, directory, cast("list[str] | None", asked.get("agent"))))
    if estimate:
        parts = [(study, directory / name) for name, study in studies.items()]
        return print_estimates(parts, batch=limits.access.batch, json=json)
    if again is not None and not is_suite(directory):
        raise BadValue("again", again, "a suite that has been played before in this directory")
    begin_suite(directory, suite)
    _say_settings(directory, studies, json=json)
    say_unlimited(next(iter(studies.values())), budget)
    unfinished: dict[str, int] = {}
    for name, study in studies.items():
        allowed = allowed_budget(study, budget, directory / name)
        if allowed is not None:
            allowed.spent += _spent(directory, suite, without=name)
        found = play_study(study, directory / name, limits, allowed, again=again, report=None, json=json)
        if found:
            unfinished[name] = found
        if found == BUDGET_REACHED:
            break
    _say_results(directory, suite, json=json)
    if report:
        report_suite(directory, json=json)
    return _end(unfinished, json=json)


def _as_asked(suite: Suite, directory: Path, asked: Mapping[str, object]) -> Suite:
    """The suite with the rule by which its studies stop, if one is given; else as it was begun in its directory."""
    until, most = asked.get("until"), asked.get("most")
    if until is None and most is not None:
        raise BadValue("most", most, f"--until with it; else an agent plays {suite.size} trials of {suite.name}")
    there = read_suite(directory) if is_suite(directory) else suite
    if until is None:
        return there if there.name == suite.name else suite
    if most is None:
        return suite.until_decided(Until.parse(str(until)), there.trials if there.until else MOST)
    if not 1 <= int(str(most)) <= LIMITS["trials"]:
        raise BadValue("most", most, f"a whole number from 1 to {LIMITS['trials']}")
    return suite.until_decided(Until.parse(str(until)), int(str(most)))


def _end(unfinished: Mapping[str, int], *, json: bool) -> None:
    """Say which studies were not played to their end, and why, by their exit statuses, and exit with the highest."""
    if not unfinished:
        return
    if json:
        print(json_.dumps({"event": "unfinished", "studies": dict(unfinished)}), flush=True)
        raise typer.Exit(max(unfinished.values()))
    said = [f"{name} ({'the budget' if status == BUDGET_REACHED else 'errors'})" for name, status in unfinished.items()]
    print(f"Not finished: {', '.join(said)}, as said above; the same command goes on")
    raise typer.Exit(max(unfinished.values()))


def _say_settings(directory: Path, studies: Mapping[str, Study], *, json: bool) -> None:
    """Print the hash of the settings of all studies, with the agents that are there."""
    parts = {}
    for name, study in studies.items():
        there = read_study(directory / name) if (directory / name / SETTINGS).exists() else study
        agents, names = joined_agents(there.agents, study.agents), {**there.names, **study.names}
        parts[name] = replace(study, agents=agents, names=names).settings_hash
    found = hash_of_parts(parts)
    print(json_.dumps({"event": "settings", "settings_hash": found}) if json else settings_line(found), flush=True)


def _say_results(directory: Path, suite: Suite, *, json: bool) -> None:
    """Print the hash of the records of all studies."""
    found = hashes_of_suite(directory, suite)
    event = {"event": "results", "settings_hash": found.settings, "results_hash": found.results}
    print(json_.dumps(event) if json else results_line(found), flush=True)


def _agents(suite: Suite, directory: Path, asked: list[str] | None) -> tuple[str, ...]:
    """The agents asked for; else those in the directory; else the suite's default agents."""
    if asked:
        return tuple(asked)
    there: tuple[str, ...] = ()
    for name in suite_directories(directory, suite):
        found = read_study(directory / name)
        named = [f"{found.names[agent]}={agent}" if agent in found.names else agent for agent in found.agents]
        there = joined_agents(there, named)
    return there or ("llm:local", *paper.REFERENCES)


def _spent(directory: Path, suite: Suite, *, without: str) -> float:
    """The maximum cost of the other studies of a suite in US dollars; with a budget every call has a price."""
    spent = 0.0
    for name in suite_directories(directory, suite):
        if name != without:
            found = Ledger(read_study(directory / name), read_calls(directory / name)).total
            spent += (found.dollars or 0.0) + (found.dollars_unknown or 0.0)
    return spent


def report_suite(directory: Path, *, json: bool) -> None:
    """Write the scores and the page of a suite, and print the scores."""
    # the modules of the report take seconds, which --help and --estimate need not wait for
    from lockprobe.report.suite.page import score_table, write_suite
    from lockprobe.report.suite.results import suite_results

    found = suite_results(directory)
    left_out: list[LeftOutSection] = []
    page = write_suite(found, directory, left_out=left_out.append)
    if json:
        print(json_.dumps({"event": "suite", **found.plain(), "page": str(page)}, allow_nan=False), flush=True)
        return
    print_rows(score_table(found))
    print(f"Suite: {page}{without(left_out)}")
