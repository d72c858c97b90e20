"""Sentences on a fit: which model describes an agent, how well it predicts, and what its parameters say."""

from __future__ import annotations

import math
from dataclasses import asdict

from lockprobe.foundation.formatting import percent, range_of
from lockprobe.simulation.fit.result import AgentFit, FitClaim, FitReport, Parameter, RivalFit

__all__ = ["CAUTION", "finding", "fit_row"]

CAUTION = (
    "Models are compared only with each other: even the best may describe the agent badly, and a model that predicts "
    "choices need not be the mechanism that makes them."
)
"""What a fit does not show."""

_SAYS = {
    "random": "chooses joints at random",
    "favourite-places": "prefers some positions in the list of joints",
    "favourite-labels": "prefers some labels",
    "round-robin": "tries joints in the listed order, except for lapses",
    "no-repeat": "avoids or repeats the last joint, whether it moved or not",
    "win-stay-lose-shift": "avoids or repeats the last joint, depending on whether it moved",
    "failure-memory": "avoids or repeats joints that failed, with a fading memory",
    "goal-and-failures": "weighs the target, unopened joints and failed joints",
    "softmax-memory": "weighs the target, unopened joints, failed joints, the last joint and the listed order",
    "human-inspired": "avoids failed joints until another joint moves, except for lapses",
    "random-map": "repeats its first choice in each situation, except for lapses",
}
"""What each model says about an agent, the predicate of a sentence."""

_PULLS = {
    "target": "The target",
    "closed": "An unopened joint",
    "failure": "A joint that has just failed",
    "recent": "The joint attempted last",
    "stay": "The joint attempted last, if it moved,",
    "position": "The joint listed first, relative to the one listed last,",
}
"""What each pull acts on."""


def fit_row(report: FitReport) -> dict[str, object]:
    """A fit as the JSON object that ``lockprobe fit --json`` writes: its values, with the sentences on them."""
    return {
        "schema": 1,
        "agents": [
            asdict(agent)
            | {
                "rivals": [{"model": one.model, "says": _SAYS[one.model]} | asdict(one) for one in agent.rivals],
                "finding": finding(agent),
            }
            for agent in report.agents
        ],
        "folds": report.folds,
        "unpredicted": dict(report.unpredicted),
        "caution": CAUTION,
    }


def finding(fit: AgentFit) -> str:
    """What is found about an agent: which model, how well it predicts, and what its parameters say."""
    best = fit.rivals[0]
    said = [_nothing(fit, best)]
    if best.predicts:
        said = [_best(fit, best)]
        if near := [rival.version for rival in fit.close]:
            said.append(f"No difference from it was detected for {', '.join(near)}.")
        said += [f"It lapses in {_share(one)} of its choices." for one in best.parameters if one.name == "lapse"]
        said += [_claimed(fit, claim) for claim in fit.claims]
        if fit.needs_no_reports:
            said.append(
                f"No effect of reports on its choices was detected: by BIC, {best.version} is no worse if every "
                "attempt counts as failed, whatever was reported. So the effects of reports are not interpreted."
            )
        elif any(one.name == "failure" and not one.shown for one in best.parameters):  # most readers ask for it
            said.append("No effect of failures on its choices was detected.")
    if fit.own is not None:
        gain = f"{fit.own.gain:.2f} bits per choice, the expected maximum for any model"
        said.append(f"Its recorded probabilities gain {gain}.")
    return " ".join(said)


def _nothing(fit: AgentFit, best: RivalFit) -> str:
    undetected = f"No gain over chance in predicting the choices of {fit.agent} was detected"
    if best.parameters and best.held_out is None:
        return f"{undetected}: a single cluster of trials leaves none to hold out."
    reached = "no model is better than random by BIC"
    if best.parameters:
        reached = f"the best model, {best.version}, gains {_gain(best)} on held-out trials"
    others = [f"{rival.version} gains {_gain(rival)}" for rival in fit.rivals if rival.predicts]
    if not others:
        return f"{undetected}: {reached}."
    return (
        f"Whether a model predicts the choices of {fit.agent} better than chance is uncertain: {reached}. "
        f"{' and '.join(others)}, which may be chance among {len(fit.rivals) - 1} models."
    )


def _best(fit: AgentFit, best: RivalFit) -> str:
    """The best model; what it says about reports is left out where no effect of reports was detected."""
    assert best.held_out is not None
    says = "" if fit.needs_no_reports else f": it {_SAYS[best.model]}"
    return (
        f"{fit.agent} is best described by {best.version}{says}. On held-out trials, this model gains "
        f"{best.held_out.gain:.2f} of the {fit.chance_bits:.2f} bits per choice of a random model ({_bits(best)}); "
        f"the chosen joint has the highest probability in {percent(best.held_out.hits)} of choices "
        f"(random: {percent(2**-fit.chance_bits)})."
    )


def _claimed(fit: AgentFit, claim: FitClaim) -> str:
    """One claim, and which models of equal fit contradict it."""
    if claim.pull is None:
        higher = f"{fit.lead_by_reports:.0f} higher"
        return f"It uses its reports: if every attempt counts as failed instead, BIC is {higher}."
    memory = ""
    if claim.about == "failure":
        found = {one.name: _share(one) for one in fit.rivals[0].parameters if one.name in ("decay", "reset")}
        memory = f"; of this effect {found['decay']} remains after each further step, and a perceived move removes "
        memory += found["reset"]
    others = list(filter(None, (_otherwise(rival, claim) for rival in fit.close)))
    depends = f" This depends on the model: {'; '.join(others)}." if others else ""
    return f"{_PULLS[claim.about]} is {_odds(claim.pull)} as likely as otherwise{memory}.{depends}"


def _otherwise(rival: RivalFit, claim: FitClaim) -> str:
    """The estimate of an effect by another model, unless it agrees."""
    pull = next((one.pull for one in rival.parameters if one.name == claim.about), None)
    if pull is None:
        return f"{rival.version} does not include it"
    if not pull.shown:
        return f"{rival.version} does not detect it"
    if pull.value * claim.direction > 0:
        return ""
    return f"{rival.version} estimates {_odds(pull)}"


def _odds(pull: Parameter) -> str:
    """How many times as likely a pull makes a joint."""
    if pull.low is None or pull.high is None:
        end = pull.high if pull.low is None else pull.low
        return f"{'at most' if pull.low is None else 'at least'} {_times(end or 0.0)} times"
    return f"{_times(pull.value)} times ({_times(pull.low)} to {_times(pull.high)})"


def _times(pull: float) -> str:
    """Below a thousandth and above a thousand the figure says nothing more."""
    odds = min(max(math.exp(pull), 0.001), 1000)
    return "1000" if odds == 1000 else f"{odds:.2g}"


def _share(one: Parameter) -> str:
    assert one.low is not None
    assert one.high is not None
    return f"{percent(one.value)} ({range_of(one.low, one.high)})"


def _gain(rival: RivalFit) -> str:
    assert rival.held_out is not None
    return f"{rival.held_out.gain:.2f} bits per choice ({_bits(rival)})"


def _bits(rival: RivalFit) -> str:
    """With trials held out there are two clusters, and an interval; a third digit where two would show a 0."""
    assert rival.held_out is not None
    low, high = rival.held_out.low or 0.0, rival.held_out.high or 0.0
    digits = 2 if min(abs(low), abs(high)) >= 0.005 else 3
    return f"95 % interval {low:.{digits}f} to {high:.{digits}f}"
