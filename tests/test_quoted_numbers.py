"""The numbers that the README and the documentation quote are those that the code gives.

What can be computed exactly is computed again: each quotation below is a sentence, or a row of a table, with braces where
its numbers stand.
"""

import re
from dataclasses import replace
from functools import cache
from itertools import permutations
from pathlib import Path
from statistics import fmean

import pytest
from scipy.stats import binom

from lockprobe.boxes.families import box
from lockprobe.boxes.layouts import permuted
from lockprobe.boxes.solve import difficulty, optimum
from lockprobe.interventions.flip import DEFAULT
from lockprobe.simulation.exact import propagate
from lockprobe.simulation.kernel import population
from lockprobe.statistics.loops.chance import chance_level
from lockprobe.statistics.proportions import proportion
from lockprobe.studies.power import Clusters, power

ROOT = Path(__file__).parents[1]
DIFFICULT = ("chain-4", "fork", "reset", "gray-code")
NEAREST = "human-inspired:proximity"
READINGS = ("re-observed", "integrated", "memoryless", "latched")


@cache
def course(agent="human-inspired", p=0.0, flip=DEFAULT):
    return propagate(agent, "chain-4", p=p, flip=flip)


def success(agent, p=0.0, flip=DEFAULT, form=".3f"):
    return f"{course(agent, p, flip).success:{form}}"


def pace(agent, steps=".1f"):
    """Mean steps, 80 % by, all by."""
    found = course(agent)
    return [f"{found.steps:{steps}}", found.by(0.8), found.by(1)]


def dealt_steps(agent):
    """Mean steps over all deals of the joints to the panel."""
    known = box("chain-4")
    spots = [joint.place for joint in known.joints]
    deals = [permuted(known, order) for order in permutations(range(4))]
    panels = [
        replace(deal, joints=tuple(replace(joint, place=spot) for joint, spot in zip(deal.joints, spots, strict=True)))
        for deal in deals
    ]
    return f"{fmean(propagate(agent, panel).steps for panel in panels):.1f}"


def blind(name):
    found = difficulty(box(name))
    return [f"{found.random_success:.3f}", f"{found.random_no_repeat_success:.3f}"]


def best_of(several, trials, share):
    """The mean of the greatest of so many shares of equal probability."""
    below = binom.cdf(range(-1, trials + 1), trials, share) ** several
    return sum(count * (below[count + 1] - below[count]) for count in range(trials + 1)) / trials


def solved_of_300(agent, p):
    """How many of three repetitions of 100 trials are solved."""
    parts = (population(agent, p=p, modality="symbolic?tell=state", repetition=i, trials=100) for i in (1, 2, 3))
    return sum(int(part.solved.sum()) for part in parts)


def hardness(key, form=""):
    return [f"{getattr(difficulty(box(name)), key):{form}}" for name in DIFFICULT]


def doubter_is_done_by():
    """The last step at which it solves the box in any reading. It acts on its reports alone, so every course that is
    possible at some p is possible at 0.4, which a table below has too."""
    return max(course("ideal-observer?noise=aware", 0.4, flip).by(1) for flip in READINGS)


def widest_gap():
    """The greatest difference in success between the default and memoryless state noise, over four agents."""
    agents = ("human-inspired", *(f"cognitive:{name}" for name in ("careful", "perseverant", "insistent")))
    rates = (0.1, 0.2, 0.3, 0.4)
    return max(abs(course(one, p).success - course(one, p, "memoryless").success) for one in agents for p in rates)


def power_of_forty(boxes):
    """The least and the greatest power of forty people within persons, by assumed spread, for success of 0.4 and 0.6."""
    models = [Clusters(success=(0.4, 0.6), each=boxes, sd=of, effect_sd=of / 2) for of in (0.5, 1.0, 1.5)]
    rates = [one["2"].measured[0].power for one in power(models, [40])]
    return min(rates), max(rates)


SENTENCES = [
    *(("docs/limits.md", "`human-inspired` solves `chain-4` with probability {:.3f} with either",
       lambda modality=modality: [propagate(p=0.4, modality=modality).success])
      for modality in ("symbolic", "symbolic?tell=state")),
    ("docs/limits.md", "and the probability is {}. Without false reports it is {} (exact:",
     lambda: [success("human-inspired", 0.4, "memoryless"), success("human-inspired", form=".0f")]),
    ("docs/readings.md", "is {} without false reports", lambda: [success("cognitive:perseverant", form=".2f")]),
    ("README.md", "solves the default box, `chain-4`, in 20 steps with probability {}.", lambda: [success("random")]),
    ("README.md", "reference curve: 80 % by step {}, all by step 20.", lambda: [course().by(0.8)]),
    ("README.md", 'holds an "action loop" with probability {:.4f}.', lambda: [chance_level(20).probability]),
    ("docs/limits.md", "holds an action loop with probability {:.4f}.", lambda: [chance_level(20).probability]),
    ("docs/teaching.md", "The truth is 0.4, and the best of seven is {:.2f} on average.", lambda: [best_of(7, 30, 0.4)]),
    ("docs/teaching.md", "The answers are {}, {} and {}. An agent that never picks the same joint twice in a row reaches {}",
     lambda: [*(blind(name)[0] for name in ("chain-4", "fork", "gray-code")), success("random-no-repeat")]),
    ("docs/modalities.md", "needs {} steps on average on the fixed panel and {} on dealt panels",
     lambda: [pace(NEAREST)[0], dealt_steps(NEAREST)]),
    ("docs/statistics.md", "within 20 steps {} if it is random, {} without immediate repeats, and {} if it goes round",
     lambda: [success("random"), success("random-no-repeat"), success("round-robin", form="g")]),
    ("docs/models.md", "which solve {:.0f} % of such boxes ({:.0f} % without immediate repeats)",
     lambda: [100 * course("random").success, 100 * course("random-no-repeat").success]),
    ("docs/agents.md", "(8 of 10 has a 95 % interval of {:.2f} to {:.2f})",
     lambda: [proportion(8, 10).low, proportion(8, 10).high]),
    ("docs/agents.md", "is a chain needs {} steps (80 % by step {}, all by {})",
     lambda: pace("ideal-observer?noise=naive&prior=chains")),
    ("docs/python.md", "course.by(1) # {} steps, 80 % by step {}, all by step {}", lambda: pace("human-inspired")),
    *((page, f"{said} 0 to {{:.3f}} %", lambda: [100 * proportion(0, 30_000).high]) for page, said in (
        ("robot/docs/twin.md", "none leaked or jammed (95 % interval"),
        ("benchmarks/README.md", "For 0 of 30 000 pushes the 95 % interval is"))),
    ("docs/why.md", "goes from {} to {} of 300 trials solved, and `cognitive:perseverant` from {} to {}.",
     lambda: [solved_of_300(f"cognitive:{name}", p) for name in ("loop-breaker", "perseverant") for p in (0, 0.4)]),
    ("robot/docs/twin.md", "of 800 ({:.1f} to 100 %, 95 % interval)", lambda: [100 * proportion(800, 800).low]),
]  # fmt: skip
"""File, what is quoted, and its numbers."""

LONG = [
    ("docs/readings.md", "differs by at most {:.2f} at flip rates of 0.1 to 0.4", lambda: [widest_gap()]),
    ("docs/limits.md", "all four readings, 0.5 among them", lambda: [][:doubter_is_done_by() > 20]),
    ("docs/agents.md", "solves the box at *every* flip rate, within {} steps", lambda: [doubter_is_done_by()]),
    ("docs/participants.md", "forty detect it in {:.2f} to {:.2f} of studies, and in {:.2f} to {:.2f} with four boxes",
     lambda: [end for boxes in (1, 4) for end in power_of_forty(boxes)]),
    ("docs/agents.md", "| `per-configuration` | … | {} | {} | {} % by 20 |",
     lambda: [*pace("human-inspired:per-configuration")[:2],
              f"{100 * course('human-inspired:per-configuration').success:.0f}"]),
    *(("docs/agents.md", f"| `noise={noise}` | `{flip}`… | {{}} | {{}} | {{}} | {{}} |",
       lambda noise=noise, flip=flip: [
           f"{one.success:.2f}, {one.steps:.1f}"
           for one in (course(f"ideal-observer?noise={noise}", p, flip) for p in (0, 0.2, 0.4, 0.6))])
      for noise, flip in (("naive", "re-observed"), ("naive", "integrated"), ("aware", "re-observed"))),
]  # fmt: skip
"""The same, whose numbers take seconds."""

ROWS = [
    *(("docs/agents.md", f"| `{name}` … | {{}} | {{}} | {{}} |", lambda name=name, form=form: pace(f"human-inspired:{name}", form))
      for name, form in (("target-first", ".1f"), ("target-last", ".1f"), ("target-any", ".1f"), ("proximity", ".1f"),
                         ("target-first-per-configuration", ".2f"))),
    *(("docs/boxes.md", f"| `{begins} … | {{}}{of} | {{}} | {{}} |", lambda name=name: [optimum(box(name)), *blind(name)])
      for name, begins, of in (
          ("chain-4", "chain-2`", " for `chain-4`"), ("bichain-4", "bichain-2`", " for `bichain-4`"),
          ("gray-code", "gray-code`,", " for four joints"),
          *((name, f"{name}` |", "") for name in ("fork", "converge", "reset", "branched")))),
    *(("docs/boxes.md", f"| `{name}-3`, `-4` | … | {{}} | {{}} | {{}} |",
       lambda name=name: [optimum(box(f"{name}-3")),
                          *(", ".join(pair) for pair in zip(blind(f"{name}-3"), blind(f"{name}-4"), strict=True))])
      for name in ("common-cause", "common-effect")),
    *(("docs/boxes.md", f"| `{key}` | … | {{}} | {{}} | {{}} | {{}} |", lambda key=key, form=form: hardness(key, form))
      for key, form in (("optimum", ""), ("optimal_plans", ""), ("cycle_success", ".3g"))),
    *(("docs/statistics.md", f"| {steps} | {{:.3f}} | {{:.3f}} |",
       lambda steps=steps: [chance_level(steps, null=null).probability for null in ("uniform", "no-repeat")])
      for steps in (6, 10, 15, 20)),
    *(("docs/readings.md", f"| {inverts} inverted | {{}} | {{}} |",
       lambda kinds=kinds: [success("cognitive:perseverant", 0.4, kind, ".2f") for kind in kinds])
      for inverts, kinds in (("position", ("memoryless", "latched")), ("outcome", ("re-observed", "integrated")))),
]  # fmt: skip
"""The same of rows of tables, where three dots stand for any text."""


def text_of(name):
    """On one line, as people read it, with a plain minus."""
    return " ".join((ROOT / name).read_text("utf-8").split()).replace("\N{MINUS SIGN}", "-")


@pytest.mark.parametrize(
    ("name", "quotation", "numbers"),
    [
        *(pytest.param(*case, id=case[1][:40]) for case in SENTENCES + ROWS),
        *(pytest.param(*case, id=case[1][:40], marks=pytest.mark.slow) for case in LONG),
    ],
)
def test_a_quotation_holds(name, quotation, numbers):
    said = quotation.format(*numbers())
    if quotation.startswith("|"):
        row = re.escape(said).replace("…", ".*")
        assert re.search(f"^{row}$", (ROOT / name).read_text("utf-8"), re.MULTILINE), said
    else:
        assert said in text_of(name)


def test_no_share_in_the_readme_is_left_unheld():
    """A percentage is computed again above, or it is of the played studies that are named beside it."""
    text = text_of("README.md")
    for name, quotation, numbers in SENTENCES:
        if name == "README.md":
            text = text.replace(quotation.format(*numbers()), "")
    played = text[text.index("> False reports raise") : text.index("The sign depends on")]
    assert re.findall(r"[\d.]+ %", text.replace(played, "")) == []
