"""The paper's claims about misreading (Sec. 3.1, Table 1), compared with what a study measured."""

from __future__ import annotations

import math

from lockprobe.analysis.misinterpretation import Misinterpretations
from lockprobe.analysis.proportions import difference, proportion
from lockprobe.analysis.published import MisreadRate
from lockprobe.report.claim_tests import NOT_MEASURED, ClaimFinding, ClaimPattern, borne_out, pattern, verdict_of

__all__ = ["hallucinated", "misread"]


def misread(said: Misinterpretations, paper: MisreadRate) -> ClaimFinding:
    """Misreadings occur, and as often as in the paper."""
    if said.mean_rate is None or said.sd_rate is None:
        return NOT_MEASURED
    if not said.total:
        return _none(said, paper)
    from scipy.stats import ttest_ind_from_stats

    here = f"{100 * said.mean_rate:.1f} % ± {100 * said.sd_rate:.1f} %, {said.total} in all, in {said.affected} of "
    found = ttest_ind_from_stats(
        paper.mean, paper.sd, paper.trials, said.mean_rate, said.sd_rate, said.trials, equal_var=False
    )
    p_value = float(found.pvalue) if math.isfinite(found.pvalue) else None
    return f"{here}{said.trials} trials", verdict_of(p_value), "Welch, on the rates per trial", p_value


def _none(said: Misinterpretations, paper: MisreadRate) -> ClaimFinding:
    """Not one misreading: in how many trials, and could that be chance if as many trials had one as in the paper?"""
    found = difference(proportion(paper.affected, paper.trials), proportion(0, said.trials))
    assert found is not None
    here = f"none in {said.pooled.n} claims of {said.trials} trials, at most {100 * said.misinterpreted.high:.1f} %"
    test = f"Fisher, trials with a misreading, against {paper.affected}/{paper.trials}"
    return here, borne_out(pattern(found.p_value, -1)), test, found.p_value


def hallucinated(said: Misinterpretations, paper: MisreadRate) -> ClaimFinding:
    """Most misreadings are of a joint that is said to have moved though it was reported blocked."""
    if said.mean_rate is None:
        return NOT_MEASURED
    if not said.total:
        return _none(said, paper)
    share = said.hallucinated
    here = f"{share.count} of {share.n} misreadings claim moved after a report of blocked, {100 * share.value:.0f} % "
    here += f"[{100 * share.low:.0f}, {100 * share.high:.0f}]; misread: {_rate(said, 'blocked')} and "
    here += _rate(said, "moved")
    shown: ClaimPattern = "shown" if share.low > 0.5 else "opposite" if share.high < 0.5 else "open"
    return here, borne_out(shown), "95 % interval above or below one half, clustered by trial", None


def _rate(said: Misinterpretations, told: str) -> str:
    found = said.moved_for_blocked if told == "blocked" else said.blocked_for_moved
    return f"{found.count} of {found.n} reports of {told}"
