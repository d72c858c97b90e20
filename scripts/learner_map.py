"""Writes docs/learner-map.json and its picture: success of learners by training, temperature and flip rate.

Ten training seeds, eight checkpoints, two temperatures, seven flip rates: 2000 trials each on chain-4, whose joints are
dealt anew in every trial, told where the joints stand. It takes about 20 minutes on one core; with ``--draw`` it only
draws the picture.
"""

import json
import sys
from concurrent.futures import ProcessPoolExecutor
from itertools import product
from multiprocessing import get_context
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from scipy.stats import t

from lockprobe.agents.network.boxes import copies
from lockprobe.agents.network.training import TrainingSettings, play, success, train
from lockprobe.boxes.families import box
from lockprobe.foundation.seeds import generator
from lockprobe.statistics.inference.ushape import two_lines
from lockprobe.statistics.loops import onset_batch

CHECKPOINTS = (1, 2, 5, 10, 20, 40, 160, 900)
TEMPERATURES = (0.0, 1.0)
RATES = (0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6)
SEEDS = range(1, 11)
TRIALS = 2000
OUT = Path(__file__).parent.parent / "docs" / "learner-map.json"


def rows(seed: int) -> list[dict[str, object]]:
    """The cells of one training seed."""
    found = []
    for updates, network in enumerate(train(TrainingSettings(updates=CHECKPOINTS[-1], seed=seed)), 1):
        if updates not in CHECKPOINTS:
            continue
        for temperature in TEMPERATURES:
            boxes = copies(box("chain-4"), TRIALS, generator(seed, "map"))
            courses = [play(network, boxes, p=p, temperature=temperature, seed=seed) for p in RATES]
            solved = [course.solved for course in courses]
            onset = [onset_batch(np.where(course.actions < 0, 0, course.actions)) for course in courses]
            looped = [(first > 0) & (first <= course.steps) for first, course in zip(onset, courses, strict=True)]
            shape = two_lines(np.repeat(RATES, TRIALS), np.concatenate(solved), np.tile(np.arange(TRIALS), len(RATES)))
            found.append(
                {
                    "seed": seed,
                    "updates": updates,
                    "temperature": temperature,
                    "unseen": success(network, temperature=temperature),
                    "success": [float(one.mean()) for one in solved],
                    "loop_rate": [float(one.mean()) for one in looped],
                    "shape": shape.direction,
                }
            )
        print(f"seed {seed}: {updates} updates", file=sys.stderr)
    return found


def draw() -> None:
    """Success by flip rate: a line for each checkpoint, mean of the seeds with Student's 95 % interval."""
    cells = json.loads(OUT.read_text())["cells"]
    figure, panels = plt.subplots(1, 2, figsize=(7.2, 3.2), sharey=True, layout="constrained")
    colours = plt.get_cmap("viridis")(np.linspace(0.0, 0.9, len(CHECKPOINTS)))
    for axes, temperature, title in zip(panels, TEMPERATURES, ("greedy (temperature 0)", "sampled (1)"), strict=True):
        for updates, colour in zip(CHECKPOINTS, colours, strict=True):
            own = [cell for cell in cells if (cell["updates"], cell["temperature"]) == (updates, temperature)]
            success = np.array([cell["success"] for cell in own])
            reach = t.ppf(0.975, len(own) - 1) * success.std(axis=0, ddof=1) / len(own) ** 0.5
            mean = success.mean(axis=0)
            axes.plot(RATES, mean, color=colour, label=f"{updates}")
            axes.fill_between(RATES, mean - reach, mean + reach, color=colour, alpha=0.2, linewidth=0)
        axes.set_title(title, fontsize=10)
        axes.set_xlabel("flip rate $p$")
        axes.set_ylim(0, 1.02)
    panels[0].set_ylabel("success on chain-4")
    figure.legend(*panels[0].get_legend_handles_labels(), title="updates", loc="outside right center", fontsize=9)
    figure.savefig(OUT.with_suffix(".png"), dpi=150, metadata={"Software": None})


def main() -> None:
    """Train, play, write and draw."""
    if "--draw" in sys.argv:
        draw()
        return
    with ProcessPoolExecutor(int(sys.argv[1]) if sys.argv[1:] else 1, mp_context=get_context("spawn")) as pool:
        cells = [row for part in pool.map(rows, SEEDS) for row in part]
    assert len(cells) == len(list(product(SEEDS, CHECKPOINTS, TEMPERATURES)))
    OUT.write_text(json.dumps({"trials": TRIALS, "rates": RATES, "cells": cells}) + "\n")
    draw()


if __name__ == "__main__":
    main()
