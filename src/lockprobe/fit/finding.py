"""What a fit says of an agent, in plain words, and no more than it bears."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

from lockprobe.fit.result import AgentFit, Parameter, RivalFit

__all__ = ["CLOSE", "Claim", "claims", "finding", "predicts"]

CLOSE = 6.0
"""Difference in BIC below which a second model is not told apart from the first: odds of 20 to 1."""

_PULLS = {
    "target": "The target",
    "closed": "A joint that is still where it was",
    "failure": "A joint that has just failed",
    "recent": "The joint attempted last",
    "stay": "The joint attempted last, if it moved,",
    "position": "The joint listed first, beside the one listed last,",
}
"""What each pull acts on."""

_BY_REPORTS = ("closed", "failure", "stay")
"""Pulls that depend on what was reported."""


class Claim(NamedTuple):
    """What a sentence claims of an agent.

    Attributes:
        about: The pull that acts on it; ``reports`` if it is that they are heeded.
        direction: 1 if the pull makes a joint likelier or reports are heeded, -1 if it makes a joint less likely.
        text: The sentence.
    """

    about: str
    direction: int
    text: str


def finding(fit: AgentFit) -> str:
    """What is found about an agent: which model, how well it predicts, and what its parameters say."""
    best = fit.rivals[0]
    said = [_nothing(fit, best)]
    if predicts(best):
        unshown = [_UNHEEDED.format(model=_name(best))] if _unheeded(fit) else _unshown(best)
        said = [_best(fit, best), *_close(fit), *_lapse(best), *(claim.text for claim in claims(fit)), *unshown]
    return " ".join(filter(None, [*said, _own(fit)]))


def claims(fit: AgentFit) -> list[Claim]:
    """What is claimed to act on an agent: by the model that is best by BIC, and only if it is shown to predict."""
    best = fit.rivals[0]
    if not predicts(best):
        return []
    silent = _BY_REPORTS if _unheeded(fit) else ()
    pulls = [_pull(one) for one in best.parameters]
    return [*_heeded(fit), *(_claim(fit, one) for one in pulls if one.name not in silent and _shown(one))]


def predicts(rival: RivalFit) -> bool:
    """Whether a model is shown to predict trials that it was not fitted to better than chance."""
    return bool(rival.parameters) and rival.held_out is not None and (rival.held_out.low or 0.0) > 0


def _nothing(fit: AgentFit, best: RivalFit) -> str:
    others = [rival for rival in fit.rivals if predicts(rival)]
    if best.parameters and best.held_out is None:
        return (
            f"No model here is shown to predict the choices of {fit.agent} better than chance: with a single cluster "
            "of trials there are no others to predict."
        )
    reached = (
        f"the best of them, {_name(best)}, gains {_gain(best)} on trials that it was not fitted to"
        if best.parameters
        else "none is better than random by BIC"
    )
    if not others:
        return f"No model here is shown to predict the choices of {fit.agent} better than chance: {reached}."
    return (
        f"That anything predicts the choices of {fit.agent} better than chance is not sure. Of {len(fit.rivals) - 1} "
        f"models {reached}; {' and '.join(f'{_name(rival)} gains {_gain(rival)}' for rival in others)}, which among "
        "so many may be luck."
    )


def _best(fit: AgentFit, best: RivalFit) -> str:
    """What a model that heeds reports says of the agent is left out where it is not shown that the agent does."""
    assert best.held_out is not None
    says, who = ("", "this model") if _unheeded(fit) else (f": it {best.says}", "that")
    return (
        f"{fit.agent} is best described by {_name(best)}{says}. On trials that it was not fitted to, {who} "
        f"predicts {best.held_out.gain:.2f} bits per choice of the {fit.chance_bits:.2f} that random leaves "
        f"({_bits(best)}); the joint chosen is the likeliest in {_percent(best.held_out.hits)} of choices "
        f"(random: {_percent(2**-fit.chance_bits)})."
    )


def _near(fit: AgentFit) -> list[RivalFit]:
    """Models that are not told apart from the best."""
    return [rival for rival in fit.rivals[1:] if rival.behind < CLOSE]


def _close(fit: AgentFit) -> list[str]:
    near = [_name(rival) for rival in _near(fit)]
    return [f"Not told apart from it: {', '.join(near)}."] if near else []


_UNHEEDED = (
    "That it heeds reports is not shown: by BIC {model} is no worse where every attempt counts as failed, whatever was "
    "reported. So nothing is said of how reports act on it."
)


def _unheeded(fit: AgentFit) -> bool:
    """Whether the best model heeds reports and does not need them."""
    return fit.lead_by_reports is not None and fit.lead_by_reports < CLOSE


def _heeded(fit: AgentFit) -> list[Claim]:
    if fit.lead_by_reports is None or _unheeded(fit):
        return []
    text = f"It heeds reports: where every attempt counts as failed instead, BIC is {fit.lead_by_reports:.0f} higher."
    return [Claim("reports", 1, text)]


def _lapse(best: RivalFit) -> list[str]:
    return [f"It lapses in {_share(one)} of its choices." for one in best.parameters if one.name == "lapse"]


def _claim(fit: AgentFit, pull: Parameter) -> Claim:
    """What one pull of the best model says, and whether a model says otherwise that is not told apart from it."""
    best, direction = fit.rivals[0], 1 if pull.value > 0 else -1
    memory = _memory({one.name: one for one in best.parameters}) if pull.name == "failure" else ""
    others = list(filter(None, (_otherwise(rival, pull.name, direction) for rival in _near(fit))))
    depends = f" This depends on the model: {'; '.join(others)}." if others else ""
    text = f"{_PULLS[pull.name]} is {_odds(pull.value, pull.low, pull.high)} as likely as otherwise{memory}.{depends}"
    return Claim(pull.name, direction, text)


def _memory(found: dict[str, Parameter]) -> str:
    """How long a failure is remembered."""
    return (
        f"; of that pull {_share(found['decay'])} is left after each further step, and a perceived move wipes out "
        f"{_share(found['reset'])}"
    )


def _otherwise(rival: RivalFit, name: str, direction: int) -> str:
    """What a model says of a pull, unless it is the same."""
    pull = next((_pull(one) for one in rival.parameters if one.name == name), None)
    if pull is None:
        return f"{_name(rival)} does without it"
    if not _shown(pull):
        return f"by {_name(rival)} it is not shown"
    if pull.value * direction > 0:
        return ""
    return f"by {_name(rival)} it is {_odds(pull.value, pull.low, pull.high)}"


def _unshown(best: RivalFit) -> list[str]:
    """Of a memory of failures it is said that it is not shown, too: it is what most ask for."""
    unclear = any(one.name == "failure" and not _shown(one) for one in best.parameters)
    return ["That failures act on its choices is not shown."] if unclear else []


def _pull(one: Parameter) -> Parameter:
    """As a pull towards a joint: ``failure`` is one away from it."""
    if one.name != "failure":
        return one
    return replace(one, value=-one.value, low=_minus(one.high), high=_minus(one.low))


def _own(fit: AgentFit) -> str:
    if fit.own is None:
        return ""
    return f"Its own recorded probabilities predict {fit.own.gain:.2f} bits: no model can be expected to do better."


def _shown(one: Parameter) -> bool:
    """Whether it is a pull whose interval leaves out 0."""
    return one.name in _PULLS and ((one.low is not None and one.low > 0) or (one.high is not None and one.high < 0))


def _odds(value: float, low: float | None, high: float | None) -> str:
    """How many times as likely a pull makes a joint."""
    if low is None or high is None:
        end = high if low is None else low
        return f"{'at most' if low is None else 'at least'} {_times(end or 0.0)} times"
    return f"{_times(value)} times ({_times(low)} to {_times(high)})"


def _times(pull: float) -> str:
    """Below a thousandth and above a thousand the figure says nothing more."""
    odds = math.exp(pull)
    return f"{min(max(odds, 0.001), 1000):.2g}" if 0.001 < odds < 1000 else "0.001" if odds < 1 else "1000"


def _minus(end: float | None) -> float | None:
    return None if end is None else -end


def _share(one: Parameter) -> str:
    assert one.low is not None
    assert one.high is not None
    return f"{_percent(one.value)} ({100 * one.low:.0f} to {_percent(one.high)})"


def _gain(rival: RivalFit) -> str:
    assert rival.held_out is not None
    return f"{rival.held_out.gain:.2f} bits per choice ({_bits(rival)})"


def _bits(rival: RivalFit) -> str:
    """With trials held out there are two clusters, and an interval; a third digit where two would show a 0."""
    assert rival.held_out is not None
    low, high = rival.held_out.low or 0.0, rival.held_out.high or 0.0
    digits = 2 if min(abs(low), abs(high)) >= 0.005 else 3
    return f"95 % interval {low:.{digits}f} to {high:.{digits}f}"


def _name(rival: RivalFit) -> str:
    """Its name with its version."""
    return rival.version


def _percent(value: float) -> str:
    return f"{100 * value:.0f} %"
