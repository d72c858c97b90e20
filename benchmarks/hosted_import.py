"""What importing and opening a hosted model takes, relative to importing Inspect AI's model layer alone.

    uv run python benchmarks/hosted_import.py [--rounds 5]

Every way runs in a fresh process, and they take turns; the least processor time of each counts. The model of the last
rows is one of a server with OpenAI's interface, whose package takes most of what is left. Nothing is asked.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys

MODEL = "openai-api/fake/model"
WAYS = {
    "import Inspect AI's model layer": "import inspect_ai.model",
    "import a hosted agent": "import lockprobe.agents.llm.model",
    "import Inspect AI's provider with OpenAI's package": "import inspect_ai.model._providers.openai_compatible",
    "open a model with Inspect AI": f"from inspect_ai.model import get_model; get_model({MODEL!r})",
    "open a hosted agent": f"from lockprobe.agents.catalogue import resolve; resolve('llm:{MODEL}').make()",
}


def seconds(code: str) -> float:
    """Processor time of one statement in a fresh process."""
    timed = f"import time; began = time.process_time(); {code}; print(time.process_time() - began)"
    environment = os.environ | {"FAKE_BASE_URL": "http://127.0.0.1:9/v1", "FAKE_API_KEY": "none"}
    done = subprocess.run([sys.executable, "-c", timed], env=environment, check=True, capture_output=True, text=True)
    return float(done.stdout.split()[-1])


def main() -> None:
    """Print the table."""
    asked = argparse.ArgumentParser()
    asked.add_argument("--rounds", type=int, default=5)
    given = asked.parse_args()
    for code in WAYS.values():
        seconds(code)  # so that nobody is charged for compiling
    rounds = [{way: seconds(code) for way, code in WAYS.items()} for _ in range(given.rounds)]
    least = {way: min(one[way] for one in rounds) for way in WAYS}
    first = next(iter(least.values()))
    print("| way | CPU s | ratio |\n|---|---|---|")
    for way, found in least.items():
        print(f"| {way} | {found:.2f} | {found / first:.2f} |")


if __name__ == "__main__":
    main()
