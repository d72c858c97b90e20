"""What a fit says of an agent, in plain words, and no more than it bears."""

from __future__ import annotations

import math

from lockprobe.fit.result import AgentFit, Parameter, RivalFit

__all__ = ["finding", "predicts"]

CLOSE = 6.0
"""Difference in BIC below which a second model is not told apart from the first: odds of 20 to 1."""

_PULLS = {
    "target": "The target",
    "closed": "A joint that is still where it was",
    "recent": "The joint attempted last",
    "stay": "The joint attempted last, if it moved,",
    "position": "The joint listed first, beside the one listed last,",
}
"""What each pull acts on. Failures have a sentence of their own."""


def finding(fit: AgentFit) -> str:
    """What is found about an agent: which model, how well it predicts, and what its parameters say."""
    best = fit.rivals[0]
    said = [_best(fit, best), *_close(fit), *_parts(best), _memory(fit)] if predicts(best) else [_nothing(fit, best)]
    return " ".join(filter(None, [*said, _own(fit)]))


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
    assert best.held_out is not None
    return (
        f"{fit.agent} is best described by {_name(best)}: it {best.says}. On trials that it was not fitted to, that "
        f"predicts {best.held_out.gain:.2f} bits per choice of the {fit.chance_bits:.2f} that random leaves "
        f"({_bits(best)}); the joint chosen is the likeliest in {_percent(best.held_out.hits)} of choices "
        f"(random: {_percent(2**-fit.chance_bits)})."
    )


def _close(fit: AgentFit) -> list[str]:
    near = [_name(rival) for rival in fit.rivals[1:] if rival.behind < CLOSE]
    return [f"Not told apart from it: {', '.join(near)}."] if near else []


def _parts(best: RivalFit) -> list[str]:
    """What its parameters say, as far as they are shown to be more than nothing."""
    return [
        f"It lapses in {_share(one)} of its choices."
        if one.name == "lapse"
        else f"{_PULLS[one.name]} is {_odds(one.value, one.low, one.high)} as likely as otherwise."
        for one in best.parameters
        if one.name == "lapse" or (one.name in _PULLS and _shown(one))
    ]


def _memory(fit: AgentFit) -> str:
    """Whether and how failures are remembered, by the best model that has such a memory and predicts."""
    for rival in fit.rivals:
        found = {one.name: one for one in rival.parameters}
        if "failure" not in found or not predicts(rival):
            continue
        failure = found["failure"]
        if not _shown(failure):
            return f"That it remembers failures is not shown ({_name(rival)})."
        odds = _odds(-failure.value, _minus(failure.high), _minus(failure.low))
        return (
            f"A joint that has just failed is {odds} as likely as otherwise; of that pull {_share(found['decay'])} "
            f"is left after each further step, and a perceived move wipes out {_share(found['reset'])} "
            f"({_name(rival)})."
        )
    return ""


def _own(fit: AgentFit) -> str:
    if fit.own is None:
        return ""
    return f"Its own recorded probabilities predict {fit.own.gain:.2f} bits: no model can be expected to do better."


def _shown(one: Parameter) -> bool:
    """Whether its interval leaves out 0."""
    return (one.low is not None and one.low > 0) or (one.high is not None and one.high < 0)


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
