"""What an agent's trials cost: tokens as its provider counted them, times the prices that are known of it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from lockprobe.agents.llm.knowledge import Price, facts_of
from lockprobe.call import Usage
from lockprobe.record import Trial

__all__ = ["Money", "money"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Money:
    """What the trials of one agent cost.

    Attributes:
        usage: Over all decisions, and over the replies that could not be used; None where nobody counted any.
        dollars: US dollars in all; None where no price is known.
        per_solved: The same for each solved trial; None where no price is known, or no trial was solved.
        price: The prices used; None where none is known.
        served: Models that answered, as the provider names them, with the decisions of each.
    """

    usage: Usage | None
    dollars: float | None
    per_solved: float | None
    price: Price | None
    served: tuple[tuple[str, int], ...]


def money(trials: Sequence[Trial]) -> Money:
    """Add up the trials of one agent, those that broke among them.

    Args:
        trials: Their facts name the model, if there is one.
    """
    decisions = [step.decision for trial in trials for step in trial.steps]
    counted = [(trial, usage) for trial in trials for usage in _usages(trial)]
    served = Counter(decision.served for decision in decisions if decision.served)
    models = {str(trial.facts["model"]) for trial in trials if "model" in trial.facts}
    price = facts_of(models.pop()).price if len(models) == 1 else None
    dollars = (
        sum(price.of(usage, batch=bool(trial.facts.get("batch"))) for trial, usage in counted)
        if price and counted
        else None
    )
    solved = sum(trial.solved for trial in trials)
    return Money(
        usage=sum((usage for _, usage in counted), Usage()) if counted else None,
        dollars=dollars,
        per_solved=dollars / solved if dollars is not None and solved else None,
        price=price,
        served=tuple(sorted(served.items())),
    )


def _usages(trial: Trial) -> list[Usage]:
    found = [step.decision.usage for step in trial.steps] + ([trial.error.usage] if trial.error else [])
    return [usage for usage in found if usage is not None]
