"""``lockprobe run``: play the trials that a study still owes, then write its report.

Help and a mistyped name import no arithmetic and no report: what plays is imported once there is something to play.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Mapping
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer

from lockprobe.agents.catalogue import resolve
from lockprobe.agents.llm.settings import Access
from lockprobe.cli import options
from lockprobe.cli.study_options import Name, with_study_options
from lockprobe.foundation import plugins
from lockprobe.foundation.terminal_text import printable
from lockprobe.studies.options.study_options import read_file, read_options

_ESTIMATE = "Only estimate the cost; call no model and write nothing."
_SHARD = "Play only part i of n of the trials, for example 3/16; `lockprobe import` joins the directories (all)."


@options.under_headings(
    {
        "Options": "agent p trials until condition box full out estimate budget",  # what most people need
        "The study": "boxes repetitions strategy_trials seed max_steps plant layout shuffle as_paper",
        "Reports and conditions": "sweep flip modality assessment hypothesis",
        "Running": "workers shard cluster allow report json",
        "Hosted models": "connections timeout retries",
    }
)
@with_study_options(explained=True)
def run(
    what: Name,
    asked: Mapping[str, object],
    out: options.Out = None,
    workers: options.Workers = None,
    shard: Annotated[str | None, typer.Option(metavar="i/n", help=_SHARD)] = None,
    cluster: options.ClusterAt = None,
    connections: options.Connections = 10,
    timeout: options.Timeout = 120.0,
    retries: options.Retries = 6,
    budget: options.Budget = None,
    allow: options.Allow = None,
    estimate: Annotated[bool, typer.Option("--estimate", help=_ESTIMATE)] = False,
    report: Annotated[bool, typer.Option(help="Write the report; `lockprobe report DIR` does it later.")] = True,
    json: options.AsJson = False,
    help_all: options.HelpAll = False,
) -> None:
    """Play a study, or resume it, and write its report. The same command again resumes it; what people did there stays.

    flips: what false reports do. modalities: what pictures do. why: whether lies change success through what they say
    or as any odd report does. looks: which of eight features of pictures make agents misread them.

    Without options flips is a short study: 300 trials at each flip rate of a cognitive model, the human-inspired
    strategy and random, and 6 of the embedded model at 0 and 0.4, in a minute; modalities RGB, RGB-D and reports, 10
    trials each, on a simulated box with a camera, of a scripted agent, human-inspired and random; why seven conditions,
    50 trials of a model in each and 150 of a strategy, of three strategies; looks 16 scenes, 10 trials in each, of
    scripted agents.

    --condition and --sweep vary anything else that lockprobe list interventions shows; the truth is played with them,
    as control. --p without them plays those rates and no others.

    Another --agent with --out and settings of a study is added to it, with the same luck. Exit status 3: a budget ended
    it; 1: trials are owed again, or none ended validly.
    """
    plugins.allow(*(allow or ()))
    for agent in read_options(what, asked).agents[0]:  # what is mistyped waits for no import
        resolve(agent)
    if "agent" in asked and what.endswith(".toml") and (theirs := read_file(Path(what)).agent):
        print(printable(f"--agent replaces the agents of {what}: {', '.join(theirs)}"), file=sys.stderr)
    from lockprobe.cli.run_study import planned_study, play_study
    from lockprobe.foundation.workers import Cluster
    from lockprobe.studies.running.executor import Limits
    from lockprobe.studies.study import Shard

    access = Access(connections=connections, timeout=timeout, retries=retries)
    with nullcontext() if estimate or cluster is None else Cluster.connect(cluster) as machines:
        if machines is not None:
            print(f"Cluster: {machines.processors()} processors", file=sys.stderr)
        limits = Limits(workers=workers or min(os.cpu_count() or 1, 8), access=access, cluster=machines)
        planned, directory = planned_study(what, asked, out)
        planned = replace(planned, shard=None if shard is None else Shard.parse(shard))
        if estimate:
            from lockprobe.cli.format_cost import print_estimates

            print_estimates(planned, directory, json=json)
            return
        play_study(planned, directory, limits, budget, report=report, json=json)
