"""Error rates of every test on simulated agents with known truth: the file that ships, and ``lockprobe audit`` prints.

    python benchmarks/audit.py > src/lockprobe/simulation/audit/measured.json

1000 studies of every world go through the tests of the report; 400 studies of many agents through its sentences on them
(``many_agents.py``). Takes hours on two cores; ``--studies 10 --many-studies 10`` takes minutes.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from many_agents import MANY_AGENTS, SentenceRate, sentence_rates

from lockprobe.foundation.parallel import Processes
from lockprobe.simulation.audit.rates import Rate, measure
from lockprobe.simulation.audit.simulated_agents import WORLDS


def as_data(rates: Sequence[Rate] | Sequence[SentenceRate], says: dict[str, str]) -> dict[str, Any]:
    """What the worlds are, and the rates in them."""
    rows = [asdict(one) | {"rate": one.rate, "error": one.error, "valid": one.valid} for one in rates]
    return {"worlds": says, "rates": rows}


def main() -> None:
    """Print the rates as JSON."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--studies", type=int, default=1000)
    parser.add_argument("--many-studies", type=int, default=400)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--workers", type=int, default=2)
    asked = parser.parse_args()
    same: dict[str, Any] = {"seed": asked.seed, "workers": Processes(asked.workers)}
    one = measure(list(WORLDS.values()), studies=asked.studies, **same)
    many = sentence_rates(list(MANY_AGENTS), studies=asked.many_studies, **same)
    found = {"seed": asked.seed} | as_data(one, {name: made.says for name, made in WORLDS.items()})
    found["many_agents"] = as_data(many, {name: made.says for name, made in MANY_AGENTS.items()})
    print(json.dumps(found, indent=1))


if __name__ == "__main__":
    main()
