"""Sentences on a fit: which model describes an agent, how well it predicts, and what its parameters say."""

from __future__ import annotations

import math
from dataclasses import asdict

from lockprobe.fit.result import AgentFit, FitClaim, FitReport, Parameter, RivalFit
from lockprobe.formatting import percent

__all__ = ["CAUTION", "finding", "fit_row"]

CAUTION = (
    "Models are compared only with each other: the best of them may be far from what the agent does, and a model that "
    "predicts choices need not be how they are made."
)
"""What would be wrong to conclude."""

_SAYS = {
    "random": "takes any joint",
    "favourite-places": "prefers some places in the listing",
    "favourite-labels": "prefers some labels",
    "round-robin": "goes through the listing, but for lapses",
    "no-repeat": "avoids or repeats the joint attempted last, whether it moved or not",
    "win-stay-lose-shift": "avoids or repeats the joint attempted last, depending on whether it moved",
    "failure-memory": "avoids, or returns to, what failed, as far as it remembers",
    "goal-and-failures": "weighs the target, what has not been opened, and what failed",
    "softmax-memory": (
        "weighs the target, what has not been opened, what failed, what it did last, and the order of the listing"
    ),
    "human-inspired": "leaves what failed until something has moved, but for lapses",
    "random-map": "does in a situation what it did there first, whatever that was, but for lapses",
}
"""What each model claims of an agent, the rest of a sentence."""

_PULLS = {
    "target": "The target",
    "closed": "A joint that is still where it was",
    "failure": "A joint that has just failed",
    "recent": "The joint attempted last",
    "stay": "The joint attempted last, if it moved,",
    "position": "The joint listed first, beside the one listed last,",
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
        "caution": CAUTION,
    }


def finding(fit: AgentFit) -> str:
    """What is found about an agent: which model, how well it predicts, and what its parameters say."""
    best = fit.rivals[0]
    said = [_nothing(fit, best)]
    if best.predicts:
        unshown = [_UNHEEDED.format(model=best.version)] if fit.needs_no_reports else _unshown(best)
        claims = [_claimed(fit, claim) for claim in fit.claims]
        said = [_best(fit, best), *_close(fit), *_lapse(best), *claims, *unshown]
    return " ".join(filter(None, [*said, _own(fit)]))


def _nothing(fit: AgentFit, best: RivalFit) -> str:
    others = [rival for rival in fit.rivals if rival.predicts]
    if best.parameters and best.held_out is None:
        return (
            f"No model here is shown to predict the choices of {fit.agent} better than chance: with a single cluster "
            "of trials there are no others to predict."
        )
    reached = (
        f"the best of them, {best.version}, gains {_gain(best)} on trials that it was not fitted to"
        if best.parameters
        else "none is better than random by BIC"
    )
    if not others:
        return f"No model here is shown to predict the choices of {fit.agent} better than chance: {reached}."
    return (
        f"That anything predicts the choices of {fit.agent} better than chance is not sure. Of {len(fit.rivals) - 1} "
        f"models {reached}; {' and '.join(f'{rival.version} gains {_gain(rival)}' for rival in others)}, which among "
        "so many may be luck."
    )


def _best(fit: AgentFit, best: RivalFit) -> str:
    """What a model that heeds reports says of the agent is left out where it is not shown that the agent does."""
    assert best.held_out is not None
    says, who = ("", "this model") if fit.needs_no_reports else (f": it {_SAYS[best.model]}", "that")
    return (
        f"{fit.agent} is best described by {best.version}{says}. On trials that it was not fitted to, {who} "
        f"predicts {best.held_out.gain:.2f} bits per choice of the {fit.chance_bits:.2f} that random leaves "
        f"({_bits(best)}); the joint chosen is the likeliest in {percent(best.held_out.hits)} of choices "
        f"(random: {percent(2**-fit.chance_bits)})."
    )


def _close(fit: AgentFit) -> list[str]:
    near = [rival.version for rival in fit.close]
    return [f"Not told apart from it: {', '.join(near)}."] if near else []


_UNHEEDED = (
    "That it heeds reports is not shown: by BIC {model} is no worse where every attempt counts as failed, whatever was "
    "reported. So nothing is said of how reports act on it."
)


def _lapse(best: RivalFit) -> list[str]:
    return [f"It lapses in {_share(one)} of its choices." for one in best.parameters if one.name == "lapse"]


def _claimed(fit: AgentFit, claim: FitClaim) -> str:
    """One claim, and which models that are not told apart from the best say otherwise."""
    if claim.pull is None:
        higher = f"{fit.lead_by_reports:.0f} higher"
        return f"It heeds reports: where every attempt counts as failed instead, BIC is {higher}."
    memory = _memory({one.name: one for one in fit.rivals[0].parameters}) if claim.about == "failure" else ""
    others = list(filter(None, (_otherwise(rival, claim) for rival in fit.close)))
    depends = f" This depends on the model: {'; '.join(others)}." if others else ""
    return f"{_PULLS[claim.about]} is {_odds(claim.pull)} as likely as otherwise{memory}.{depends}"


def _memory(found: dict[str, Parameter]) -> str:
    """How long a failure is remembered."""
    return (
        f"; of that pull {_share(found['decay'])} is left after each further step, and a perceived move wipes out "
        f"{_share(found['reset'])}"
    )


def _otherwise(rival: RivalFit, claim: FitClaim) -> str:
    """What a model says of a pull, unless it is the same."""
    pull = next((one.pull for one in rival.parameters if one.name == claim.about), None)
    if pull is None:
        return f"{rival.version} does without it"
    if not pull.shown:
        return f"by {rival.version} it is not shown"
    if pull.value * claim.direction > 0:
        return ""
    return f"by {rival.version} it is {_odds(pull)}"


def _unshown(best: RivalFit) -> list[str]:
    """Of a memory of failures it is said that it is not shown, too: it is what most ask for."""
    unclear = any(one.name == "failure" and not one.shown for one in best.parameters)
    return ["That failures act on its choices is not shown."] if unclear else []


def _own(fit: AgentFit) -> str:
    if fit.own is None:
        return ""
    return f"Its own recorded probabilities predict {fit.own.gain:.2f} bits: no model can be expected to do better."


def _odds(pull: Parameter) -> str:
    """How many times as likely a pull makes a joint."""
    if pull.low is None or pull.high is None:
        end = pull.high if pull.low is None else pull.low
        return f"{'at most' if pull.low is None else 'at least'} {_times(end or 0.0)} times"
    return f"{_times(pull.value)} times ({_times(pull.low)} to {_times(pull.high)})"


def _times(pull: float) -> str:
    """Below a thousandth and above a thousand the figure says nothing more."""
    odds = math.exp(pull)
    return f"{min(max(odds, 0.001), 1000):.2g}" if 0.001 < odds < 1000 else "0.001" if odds < 1 else "1000"


def _share(one: Parameter) -> str:
    assert one.low is not None
    assert one.high is not None
    return f"{percent(one.value)} ({100 * one.low:.0f} to {percent(one.high)})"


def _gain(rival: RivalFit) -> str:
    assert rival.held_out is not None
    return f"{rival.held_out.gain:.2f} bits per choice ({_bits(rival)})"


def _bits(rival: RivalFit) -> str:
    """With trials held out there are two clusters, and an interval; a third digit where two would show a 0."""
    assert rival.held_out is not None
    low, high = rival.held_out.low or 0.0, rival.held_out.high or 0.0
    digits = 2 if min(abs(low), abs(high)) >= 0.005 else 3
    return f"95 % interval {low:.{digits}f} to {high:.{digits}f}"
