"""How well fits of cognitive models recover the truth about simulated agents, for three tables of a page.

    OMP_NUM_THREADS=1 python benchmarks/recovery.py parameters|models|findings [--sets N] [--workers N]

The tables are in benchmarks/README.md. Agents of known truth (``known_agents.py``) play the paper's flip study many
times, and the models are fitted to each of the studies on its own:

- ``parameters``: fitted parameters against the true ones, and the coverage of their intervals;
- ``models``: how often the true model is the best of all;
- ``findings``: how often the claims of a fit about an agent are false.
"""

from __future__ import annotations

import argparse
import asyncio
import math
import os
import sys
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import islice
from typing import TypeVar

import numpy as np
from known_agents import MODELS, PARAMETERS, WORLDS, RuleAgent, softmax_memory

from lockprobe.agents.catalogue import resolve
from lockprobe.boxes.families import box
from lockprobe.foundation.parallel import Pool, Processes
from lockprobe.interventions.conditions import flips, interventions_in
from lockprobe.plants.symbolic import SymbolicPlant
from lockprobe.simulation.fit.candidate_models import RIVALS, candidates_named
from lockprobe.simulation.fit.choices import choices_of, hear
from lockprobe.simulation.fit.fitting import fit_agent
from lockprobe.simulation.fit.model_comparison import FittedCandidate, compare_models
from lockprobe.simulation.fit.optimise import maximum, parameters
from lockprobe.simulation.fit.result import CLOSE, FitClaim, Parameter
from lockprobe.statistics.proportions import proportion
from lockprobe.trial.loop import play
from lockprobe.trial.plan import Plan
from lockprobe.trial.protocols import Agent
from lockprobe.trial.record import Trial

BOX = box("chain-4")
NONE = "\N{EN DASH}"

_R = TypeVar("_R")


@dataclass(frozen=True, slots=True, kw_only=True)
class Study:
    """A simulated study of one agent: the paper's flip study with the default reading of a false report.

    Attributes:
        agent: The agent, or its spec.
        seed: Its seed.
        p: Flip rates.
        repetitions: Repetitions.
        trials: Trials per repetition and flip rate.
        pulls: The truth about the agent (:class:`known_agents.KnownAgent`).
    """

    agent: str | RuleAgent
    seed: int
    p: tuple[float, ...] = (0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6)
    repetitions: int = 3
    trials: int = 10
    pulls: Mapping[str, int | None] = field(default_factory=dict)

    def play(self) -> list[Trial]:
        """All its trials."""
        player: Agent = resolve(self.agent).make() if isinstance(self.agent, str) else self.agent
        plans = [
            Plan(
                study="recovery",
                agent=str(self.agent),
                box=BOX,
                condition=condition,
                repetition=repetition,
                trial=trial,
                seed=self.seed,
                budget=20,
            )
            for condition in flips(self.p)
            for repetition in range(1, self.repetitions + 1)
            for trial in range(1, self.trials + 1)
        ]

        async def all_of_them() -> list[Trial]:
            return [
                await play(plan, plant=SymbolicPlant(BOX), interventions=interventions_in(plan.condition), agent=player)
                for plan in plans
            ]

        return asyncio.run(all_of_them())


def seeds(sets: int, first: int) -> range:
    """The seeds of so many studies of one agent."""
    return range(first, first + sets)


def results(
    work: Callable[[Study], _R], studies: Mapping[str, Sequence[Study]], workers: Pool
) -> Iterator[tuple[str, list[_R]]]:
    """The name of each agent and the results of its studies, as soon as they are there; progress goes to stderr."""
    found = workers.map(work, [study for mine in studies.values() for study in mine])
    for name, mine in studies.items():
        got: list[_R] = []
        for one in islice(found, len(mine)):
            got.append(one)
            print(f"\r{name}: {len(got)} of {len(mine)} studies", end="", file=sys.stderr, flush=True)
        print(file=sys.stderr)
        yield name, got


# Parameters


def fitted_parameters(study: Study) -> Sequence[Parameter]:
    """The parameters of ``softmax-memory`` fitted to a study."""
    trials = study.play()
    heard = [hear(trial) for trial in trials]
    choices = choices_of(trials, heard)
    model = RIVALS["softmax-memory"].versions(choices, heard)["softmax-memory"]
    return parameters(model, maximum(model), choices)


@dataclass(frozen=True, slots=True, kw_only=True)
class Recovered:
    """The recovery of one parameter over many studies.

    Attributes:
        name: Its name.
        truth: Its true value.
        median: Median of the fitted values.
        spread: Standard deviation of the fitted values.
        covered: Coverage: share of 95 % intervals that hold the truth, [0, 1].
    """

    name: str
    truth: float
    median: float
    spread: float
    covered: float

    def __str__(self) -> str:
        """As a cell of the table."""
        said = f"{self.truth:.1f}: {self.median:z.2f} ± {self.spread:.2f}, {self.covered:.2f}"
        return said.replace("-", "\N{MINUS SIGN}")


def recovered(truth: Mapping[str, float], fits: Sequence[Sequence[Parameter]]) -> list[Recovered]:
    """Compare the fits of one agent with the truth, parameter by parameter; those that are not named are 0."""
    found = []
    for same in zip(*fits, strict=True):
        true, values = truth.get(same[0].name, 0.0), np.array([one.value for one in same])
        held = [(one.low is None or one.low <= true) and (one.high is None or true <= one.high) for one in same]
        found.append(
            Recovered(
                name=same[0].name,
                truth=true,
                median=float(np.median(values)),
                spread=float(values.std()),
                covered=sum(held) / len(held),
            )
        )
    return found


def parameter_table(sets: int, workers: Pool) -> None:
    """Print the recovery of every parameter of every agent."""
    studies = {
        name: [Study(agent=softmax_memory(truth), seed=seed) for seed in seeds(sets, 1000)]
        for name, truth in PARAMETERS.items()
    }
    found = {name: recovered(PARAMETERS[name], fits) for name, fits in results(fitted_parameters, studies, workers)}
    print_head("parameter", *found)
    for same in zip(*found.values(), strict=True):
        print_row(f"`{same[0].name}`", *same)
    shares = [one.covered for mine in found.values() for one in mine]
    error = math.sqrt(0.95 * 0.05 / sets)
    print(f"\nOf all intervals, {np.mean(shares):.3f} hold the truth (lowest {min(shares):.2f}, highest ", end="")
    print(f"{max(shares):.2f}; Monte Carlo error {error:.3f} at 0.95).")


# Models


@dataclass(frozen=True, slots=True, kw_only=True)
class Best:
    """The best models of one study.

    Attributes:
        bic: By BIC.
        aicc: By AICc.
        plain: By BIC if shared luck is ignored: every choice counts as independent.
    """

    bic: str
    aicc: str
    plain: str


def best_models(study: Study) -> Best:
    """Which of all models is the best for a study."""
    trials = study.play()
    heard = [hear(trial, {BOX.name: BOX}) for trial in trials]
    found = compare_models(choices_of(trials, heard), heard, candidates_named())
    return Best(
        bic=found.best.rival.name,
        aicc=min(found.competitors, key=_aicc).rival.name,
        plain=min(map(_independent, found.competitors), key=lambda one: one.bic).rival.name,
    )


def _aicc(one: FittedCandidate) -> float:
    return math.inf if one.aicc is None else one.aicc


def _independent(one: FittedCandidate) -> FittedCandidate:
    """The same, as if choices were independent."""
    return replace(one, repeats=1.0, effective=one.effective * one.repeats, charged=float(len(one.best.values)))


def model_table(sets: int, workers: Pool) -> None:
    """Print how often the true model is the best, and which model is the best for an agent with weak pulls."""
    weak = softmax_memory(PARAMETERS["faint"])
    studies = {
        **{model: [Study(agent=agent, seed=seed) for seed in seeds(sets, 5000)] for model, agent in MODELS.items()},
        "faint": [Study(agent=weak, seed=seed) for seed in seeds(max(1, sets // 2), 5000)],
    }
    counts: set[int] = set()
    after = []
    print_head("truth", "found by BIC", "taken for", "found by AICc", "agent")
    for name, found in results(best_models, studies, workers):
        bic, aicc, plain = (Counter(getattr(one, by) for one in found) for by in ("bic", "aicc", "plain"))
        if name in MODELS:
            others = Counter({model: n for model, n in bic.items() if model != name})
            shares = [f"{100 * by[name] / sets:.0f} %" for by in (bic, aicc)]
            counts |= {bic[name], aicc[name]}
            print_row(f"`{name}`", shares[0], counted(others), shares[1], f"`{MODELS[name]}`")
        if name == "random":
            after.append(f"If shared luck is ignored, BIC calls {wilson(plain[name], sets)} random agents random.")
        if name == "faint":
            after.append(f"{len(found)} studies of the faint agent: by BIC {counted(bic)}; by AICc {counted(aicc)}.")
    print("\n95 % Wilson intervals: " + "; ".join(wilson(n, sets) for n in sorted(counts, reverse=True)) + ".")
    print(*after, sep="\n")


# Findings


@dataclass(frozen=True, slots=True, kw_only=True)
class Claims:
    """The claims of the fit to one study.

    Attributes:
        best: The best model by BIC.
        described: Whether it was shown to predict.
        made: The claims: the name of the effect, with ``+`` if it makes a joint more likely and ``-`` if less.
        false: The false ones.
    """

    best: str
    described: bool
    made: list[str]
    false: list[str]


def claims(study: Study) -> Claims:
    """What a fit claims about the agent of a study."""
    fit = fit_agent(str(study.agent), study.play(), candidates_named(), boxes={BOX.name: BOX}, within=CLOSE)
    wrong = [claim for claim in fit.claims if study.pulls.get(claim.about, 0) not in (None, claim.direction)]
    return Claims(
        best=fit.rivals[0].model,
        described=fit.described is not None,
        made=[*map(_signed, fit.claims)],
        false=[*map(_signed, wrong)],
    )


def _signed(claim: FitClaim) -> str:
    return f"{claim.about} {'+' if claim.direction > 0 else '-'}"


def finding_table(sets: int, workers: Pool) -> None:
    """Print the claims about every known agent, and how many of them are false."""
    studies = {
        name: [Study(agent=world.agent, pulls=world.pulls, seed=seed) for seed in seeds(sets, 7000)]
        for name, world in WORLDS.items()
    }
    deaf, misled, heeding = [list[bool]() for _ in range(3)]
    print_head("what the agent does", "best by BIC", "shown to predict", "claims", "false claims")
    for name, found in results(claims, studies, workers):
        made, false = (Counter(claim for one in found for claim in told(one)) for told in (_made, _false))
        best = Counter(one.best for one in found)
        print_row(name, counted(best), sum(one.described for one in found), counted(made), counted(false))
        if not isinstance(WORLDS[name].agent, RuleAgent):
            heeding += ["reports +" in one.made for one in found]
        elif "reports" not in WORLDS[name].pulls:
            deaf += [any(claim.split()[0] in ("reports", "failure") for claim in one.made) for one in found]
            misled += [bool(one.false) for one in found]
    print("\n95 % Wilson intervals:")
    print(
        f"- Agents that ignore reports are said to heed reports or failures in {wilson(sum(deaf), len(deaf))} studies."
    )
    print(f"- A false claim of any kind is made about them in {wilson(sum(misled), len(misled))} studies.")
    print(f"- Those of the last rows are said to heed reports in {wilson(sum(heeding), len(heeding))} studies.")


def _made(one: Claims) -> Iterable[str]:
    return one.made


def _false(one: Claims) -> Iterable[str]:
    return one.false


# Tables


def print_head(*names: str) -> None:
    """Print the head of a table."""
    print(f"| {' | '.join(names)} |\n|{'---|' * len(names)}", flush=True)


def print_row(*cells: object) -> None:
    """Print a row of a table."""
    print(f"| {' | '.join(map(str, cells))} |", flush=True)


def counted(found: Counter[str]) -> str:
    """Names with their counts, the most frequent first."""
    ordered = sorted(found.items(), key=lambda one: (-one[1], one[0]))
    return ", ".join(f"`{name}` {n}" for name, n in ordered) or NONE


def wilson(count: int, n: int) -> str:
    """A count with the 95 % interval of its share."""
    share = proportion(count, n)
    return f"{count} of {n} ({100 * share.low:.1f} to {100 * share.high:.1f} %)"


TABLES = {"parameters": (parameter_table, 300), "models": (model_table, 100), "findings": (finding_table, 10)}
"""Name of a table -> what prints it, and the number of studies of each agent on the page."""


def main() -> None:
    """Print one of the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("table", choices=TABLES)
    parser.add_argument("--sets", type=int, help="studies of each agent (300, 100 or 10, as on the page)")
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1, help="processes (all cores)")
    asked = parser.parse_args()
    printed, usual = TABLES[asked.table]
    printed(usual if asked.sets is None else asked.sets, Processes(asked.workers))


if __name__ == "__main__":
    main()
