"""``lockprobe power --until``: what a study that stops when it is decided plays, beside one of fixed size."""

from __future__ import annotations

import json as json_
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich.markup import escape

from lockprobe.cli.printing import new_table, plain_console, print_table, time_left
from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.formatting import percent
from lockprobe.foundation.terminal_text import printable
from lockprobe.studies.options.study_options import read_options_file

if TYPE_CHECKING:
    from lockprobe.simulation.power.flip_rates import Needed
    from lockprobe.simulation.power.until import QuestionPower, UntilPower
    from lockprobe.studies.costs.expected_trials import Spread
    from lockprobe.studies.study import Study

__all__ = ["WHY_BLOCKS", "assumption", "power_until", "stops"]

WHY_BLOCKS = (50, 150, 300, 600)
"""Blocks at which a study of controls of fixed size is measured."""


@dataclass(frozen=True, slots=True, kw_only=True)
class _Row:
    """What is known of one agent under one effect.

    Attributes:
        effect: Name of the effect; empty if only one is asked for.
        until: What a study plays that stops when it is decided.
        fixed: Question -> trials per condition of a study of fixed size; None if they are more than were measured,
            and no entry where nothing is to be shown.
        right: Of a study of controls with a stated effect, the blocks with which one of fixed size finds its reason.
    """

    effect: str
    until: UntilPower
    fixed: Mapping[str, int | None]
    right: Needed | None = None

    @property
    def fixed_trials(self) -> int | None:
        """Trials of a study of fixed size that is large enough for every question; None if it is not known."""
        if self.right is not None:
            return None if self.right.trials is None else self.right.trials * len(self.until.played)
        known = [self.fixed.get(one.name) for one in self.until.questions]
        sizes = [one for one in known if one is not None]
        return max(sizes) * len(self.until.played) if known and len(sizes) == len(known) else None


def stops(what: str | None, asked: Mapping[str, Any]) -> bool:
    """Whether the study that is asked for stops when it is decided."""
    if asked.keys() & {"until", "most"}:
        return True
    return what is not None and what.endswith(".toml") and read_options_file(Path(what)).until is not None


def power_until(
    what: str | None,
    asked: Mapping[str, Any],
    success: Sequence[float] | None,
    shared: float,
    simulated: Mapping[str, Any],
    *,
    json: bool,
) -> None:
    """Simulate and print it.

    Args:
        what: ``why``, a study file, or nothing.
        asked: The options of the study.
        success: Success under each condition, if it is stated.
        shared: Share of the blocks of luck in which one number decides.
        simulated: ``target``, ``studies``, ``workers`` and ``sizes``, at which the study of fixed size is measured.
        json: Whether to print JSON.
    """
    from lockprobe.simulation.power.flip_rates import default_worlds
    from lockprobe.simulation.power.worlds import P
    from lockprobe.studies.options.studyfile import study

    if what is not None and what != "why" and not what.endswith(".toml"):
        raise BadValue("power", what, "why, a study file ending in .toml, or nothing")
    plays = "agent" in asked or (what or "").endswith(".toml")
    beside = asked.keys() - {"p", "seed", "until", "most"}
    if success is None and beside and not plays:
        raise BadValue("--success", None, "success under each condition, or --agent with a strategy to be played")
    if what is None and not beside:
        asked = {"p": list(P), **asked}
    planned = study(what or "flips", **asked) if plays else study(what or "flips", **{"agent": "random", **asked})
    if success is None and not plays:
        if what is None and tuple(planned.p) != P:
            raise BadValue("--success", None, "success at each flip rate: --p needs it")
        from lockprobe.simulation.power.why import STATED

        paper = default_worlds()[0].success
        flips = {"a rise and fall like the paper's": paper, "no effect": (paper[0],) * len(paper)}
        stated: dict[str, Sequence[float] | None] = {**(STATED if what == "why" else flips)}
    else:
        stated = {"": success}
    rows = [one for effect, shares in stated.items() for one in _rows(planned, effect, shares, shared, simulated)]
    if json:
        head = {"target": simulated["target"], "studies": simulated["studies"], "shared": shared}
        until = {"until": str(rows[0].until.until), "most": rows[0].until.most}
        print(json_.dumps(head | until | {"agents": [_facts(one) for one in rows]}, indent=1))
        return
    for row in rows:
        _print(row, simulated)
    _explain(rows, simulated["target"], None if success is None and plays else shared)


def _rows(
    planned: Study, effect: str, success: Sequence[float] | None, shared: float, simulated: Mapping[str, Any]
) -> list[_Row]:
    from lockprobe.simulation.power.conditions import condition_power, families_of, played_pools
    from lockprobe.simulation.power.flip_rates import TRIALS
    from lockprobe.simulation.power.until import until_power

    target, studies, workers = (simulated[name] for name in ("target", "studies", "workers"))
    blocks = () if success is not None else played_pools(planned, workers=workers, progress=time_left("blocks"))
    found = until_power(
        planned,
        success=success,
        shared=shared,
        target=target,
        studies=studies,
        pools=blocks,
        workers=workers,
        progress=time_left("studies"),
    )
    fixed: dict[str, dict[str, int | None]] = {}
    asked = {one.name for found_of in found for one in found_of.questions}
    if planned.until and planned.until.rule == "decided" and "total" not in asked and any(families_of(planned)):
        measured = condition_power(
            planned,
            success=success,
            shared=shared,
            trials=simulated["sizes"] or TRIALS,
            target=target,
            studies=studies,
            pool=blocks,
            workers=workers,
            progress=time_left("studies of fixed size"),
        )
        for one in measured:
            fixed.setdefault(one.agent, {})[one.condition] = one.needed.trials
    right = _right(success, simulated, planned.seed) if "total" in asked and success is not None else None
    return [_Row(effect=effect, until=one, fixed=_fixed(one, fixed.get(one.agent, {})), right=right) for one in found]


def _right(success: Sequence[float], simulated: Mapping[str, Any], seed: int) -> Needed | None:
    """The blocks with which a study of controls of fixed size finds the reason for a stated effect."""
    from lockprobe.simulation.power.why import blocks_needed
    from lockprobe.statistics.why.arms import ARMS

    if len(success) != len(ARMS):
        return None
    return blocks_needed(
        success,
        blocks=simulated["sizes"] or WHY_BLOCKS,
        target=simulated["target"],
        studies=simulated["studies"],
        seed=seed,
    )


def _fixed(found: UntilPower, measured: Mapping[str, int | None]) -> dict[str, int | None]:
    """Trials per condition of a study of fixed size: for an effect as measured, else by the approximation."""
    known: dict[str, int | None] = {}
    for one in found.questions:
        if one.fixed is not None:
            known[one.name] = one.fixed
        elif one.name in measured:
            known[one.name] = measured[one.name]
    return known


def _print(row: _Row, simulated: Mapping[str, Any]) -> None:
    found, console = row.until, plain_console()
    effect = f": {row.effect}" if row.effect else ""
    until = "decided" if found.until.rule == "decided" else f"{found.until} points"
    console.print(f"\n[bold]{escape(found.agent)}{effect}[/bold], until {until}, at most {found.most} per condition")
    table = new_table("condition", "success", "trials", "95 % of studies")
    for label, trials in found.played.items():
        table.add_row(escape(printable(label)), percent(found.success[label]), _mean(trials), _range(trials))
    table.add_row("[bold]in all[/bold]", "", f"[bold]{_mean(found.trials)}[/bold]", _range(found.trials))
    if found.steps is not None:
        table.add_row("their steps", "", _mean(found.steps), _range(found.steps))
    print_table(table)
    print_table(_questions(row))
    share = found.decided
    console.print(
        f"Everything is decided within the most in {percent(share.value)} of studies "
        f"\\[{percent(share.low)}, {percent(share.high)}]. {_against_fixed(row, simulated['target'])}"
    )


def _against_fixed(row: _Row, target: float) -> str:
    """What is saved against a study of fixed size that is large enough for every question, or costs more."""
    if (fixed := row.fixed_trials) is None:
        return ""
    power, found = "", row.until
    if row.right is not None:
        power = f" to name the reason in {percent(target)} of studies"
    elif found.until.rule == "decided":
        power = f" for a power of {target:g} in each question"
    said = (
        f"A study of fixed size needs {'at most ' * (row.right is not None and row.right.below)}{fixed:,} trials{power}"
    )
    if found.decided.value < target:
        return f"{said}; this one is open too often for a comparison (--most allows more)."
    saved = 1 - found.trials.mean / fixed
    return f"{said}; this one plays {percent(abs(saved))} {'less' if saved >= 0 else 'more'} in the mean."


def _questions(row: _Row) -> Any:
    """How often each question is decided, and what a study of fixed size needs for it."""
    until = row.until.until
    small = f"smaller than {100 * until.points:g} points"
    verdicts = ["an effect", small, "open"] if until.rule == "decided" else [f"known to {until}", "open"]
    table = new_table("question", "difference", *verdicts, "fixed size")
    for one in row.until.questions:
        shares = (one.effect, one.small, one.open) if until.rule == "decided" else (one.narrow, one.open)
        table.add_row(
            escape(printable(one.name)),
            f"{100 * one.difference:+.1f}",
            *(f"{share:.2f}" for share in shares),
            _of_fixed(row, one),
        )
    return table


def _of_fixed(row: _Row, one: QuestionPower) -> str:
    if one.name not in row.fixed:
        return "-"
    return "more" if (size := row.fixed[one.name]) is None else f"{size}"


def _explain(rows: Sequence[_Row], target: float, shared: float | None) -> None:
    console = plain_console()
    first = rows[0].until.until
    if first.rule == "decided":
        fixed = (
            f"Fixed size: trials per condition that give the test of the report a power of {target:g}; for a "
            f"difference below {100 * first.points:g} points, that show it to be smaller (two one-sided tests, normal "
            "approximation). 'more': than the largest number measured (--trials)."
        )
    else:
        fixed = "Fixed size: trials per condition for an interval as narrow, by the normal approximation."
    console.print(f"\n{fixed}")
    console.print(
        "Conditions are played until no open question needs them, with a look after every five blocks. Shares are of "
        "simulated studies."
    )
    if any(row.until.steps is not None for row in rows):
        console.print("Steps are the calls that a model makes which plays like this agent.")
    console.print(assumption(shared))


def assumption(shared: float | None) -> str:
    """What simulated studies of conditions assume of luck; ``shared`` is None for blocks that the agent has played."""
    if shared is None:
        return "Assumption: the agent goes on as in the blocks of luck that it has played here."
    alike = f"{100 * shared:g} % of the trials are decided by one number" if shared else "trials share no luck"
    return f"Assumption: {alike} under different conditions (--shared); a sampled model shares none."


def _mean(found: Spread) -> str:
    return f"{found.mean:,.0f}"


def _range(found: Spread) -> str:
    return f"{found.low:,.0f} to {found.high:,.0f}"


def _facts(row: _Row) -> dict[str, object]:
    found = row.until
    return {
        "agent": found.agent,
        "effect": row.effect,
        "most_trials": found.most_trials,
        "trials": asdict(found.trials),
        "steps": None if found.steps is None else asdict(found.steps),
        "conditions": [
            {"condition": label, "success": found.success[label], "trials": asdict(trials)}
            for label, trials in found.played.items()
        ],
        "decided": {"share": found.decided.value, "low": found.decided.low, "high": found.decided.high},
        "questions": [asdict(one) | {"open": one.open, "fixed": row.fixed.get(one.name)} for one in found.questions],
        "fixed_trials": row.fixed_trials,
    }
