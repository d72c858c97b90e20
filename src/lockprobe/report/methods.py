"""The paragraph on the methods of an article: ``methods.tex``, from the rows and settings in ``results.json``."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from lockprobe.foundation.formatting import count, listed
from lockprobe.foundation.spec import PEOPLE
from lockprobe.report.captions import share_intervals_said
from lockprobe.report.format import tex_text
from lockprobe.report.rows import Estimate, Results
from lockprobe.statistics.conditions.modalities import spoken
from lockprobe.statistics.sequential.contrasts import E_PROCESS

_CHAIN = "The interlock of their box is not public; ours is a reconstruction."
_STRATEGY = "{} reconstructs their strategy, whose algorithm is not public."

_EXPLAINED = r" \texttt{lockprobe list interventions} explains their options."

_LABELS: Mapping[str, str] = {
    "trial": "Joints had neutral labels, drawn anew in every trial.",
    "study": "Joints had neutral labels, drawn once for the study.",
}
"""How ``shuffle`` names joints; in panel order otherwise."""

_FACTS: Mapping[str, str] = {
    "model": "model {}",
    "answered by": "answered by {}",
    "host": "on the host {}",
    "sha256": "weights with the SHA-256 {:.12}",
    "quantisation": "quantisation {}",
    "runtime": "run by {}",
    "decoding": "decoding by {}",
    "temperature": "temperature {}",
    "top_p": "top-p {}",
    "effort": "reasoning effort {}",
    "max_tokens": "at most {} tokens a reply",
    "schema": "a {} schema for replies",
    "images": "pictures kept of the {} newest observations",
    "detail": "pictures sent in {} detail",
    "repairs": "a malformed reply asked for again up to {} times",
    "calibration": "calibration {}",
    "prompt": "prompt with the fingerprint {}",
}
"""A fact on record of a model -> how the paragraph says it."""

_LEFT: Mapping[str, str] = {
    "temperature": "temperature",
    "top_p": "top-p",
    "effort": "reasoning effort",
    "max_tokens": "length of a reply",
}
"""What can be left to the provider."""

_TESTS: Mapping[str, str] = {
    "McNemar": "McNemar's exact test",
}
"""Tests of rows, as the paragraph calls them."""

_DETECTED = r"a change counts as detected if \emph{P} is below 0.05 and its 95\,\% interval excludes 0."

_SHOWN: Mapping[str, str] = {"True": "shown", "False": "not shown"}
"""What participants are shown."""


def methods_tex(found: Results) -> str:
    """One paragraph: puzzle, agents, models, design, what is left out, intervals and tests, and the hashes."""
    agents = (_agents(found), _baselines(found), *_models(found), _participants(found))
    design = (_design(found), _left_out(found), _tested(found), _kept(found))
    return " ".join(filter(None, (_system(found), _shown(found), *agents, *design))) + "\n"


def _system(found: Results) -> str:
    box, trial = found.study.get("box", {}), next(iter(found.said("overview", "trial")), "")
    joints = f", with {len(box.get('joints', ()))} joints" if box.get("joints") else ""
    return (
        rf"We used Lockprobe {tex_text(found.lockprobe)}~\cite{{lockprobe}}, which implements the system of Zenkri and "
        rf"Brock~\cite{{zenkri-brock}}. {tex_text(trial)} The box was {_code(box.get('name', ''))}{joints}."
        f"{f' {_CHAIN}' if box.get('name') == 'chain-4' else ''}"
    )


def _shown(found: Results) -> str:
    """How the box was shown, on which plant, and how its joints were called."""
    shown = list(dict.fromkeys(spoken(one.modality) for one in found.design.conditions))
    plant = str(found.study.get("plant", "symbolic"))
    on = "" if plant == "symbolic" else f", on the plant {_code(plant)}"
    labels = _LABELS.get(str(found.study.get("shuffle")), "")
    return (
        f"After each action the box was shown as {tex_text(listed(shown))}{on}. {labels}".strip() if shown else labels
    )


def _agents(found: Results) -> str:
    agents = [str(agent) for agent in found.study.get("agents", ())]
    said = [_code(agent) for agent in agents if agent != PEOPLE]
    many = next((row.value for row in found.where("people", agent=PEOPLE, condition="")), None)
    people = "" if PEOPLE not in agents else count(int(many), "participant") if many else "people"
    models = f"{count(len(said), 'agent')} ({listed(said)})" if said else ""
    ours = [agent for called in found.facts_about("design") for agent in called.split(", ")]
    strategy = f" {_STRATEGY.format(listed([_code(one) for one in ours]))}" if ours else ""
    return f"The box was played by {listed([one for one in (people, models) if one])}.{strategy}"


def _baselines(found: Results) -> str:
    agents = map(str, found.study.get("agents", ()))
    played = {one.agent for one in found.design.players}
    others = [_code(agent) for agent in agents if found.subjects and agent in played and agent not in found.subjects]
    return f"{listed(others)} {'are baselines' if others[1:] else 'is a baseline'}." if others else ""


def _models(found: Results) -> Iterator[str]:
    """What is on record of each language model, in a sentence of its own."""
    for agent in found.study.get("agents", ()):
        facts = found.facts_about(str(agent))
        if "model" in facts:
            said = [_fact(name, facts[name]) for name in _FACTS if name in facts]
            said += ["no seed sent"] * ("repairs" in facts)
            yield f"{_code(str(agent))}: {tex_text(', '.join(said))}."
            for row in found.where("replies_asked_again", agent=str(agent)):
                yield f"{row.count} of its {row.n} replies could not be used and were asked for again."


def _fact(name: str, value: str) -> str:
    """One fact on record of a model."""
    if name in _LEFT and value == "provider default":
        return f"{_LEFT[name]} left to the provider"
    return "no reasoning effort" if (name, value) == ("effort", "not taken") else _FACTS[name].format(value)


def _participants(found: Results) -> str:
    """What participants saw, and how many boxes each of them finished."""
    facts = found.facts_about(PEOPLE)
    said = [f"{name} {_code(facts[name])}" for name in ("design", "view") if name in facts]
    said += [f"{name} {_SHOWN.get(facts[name], facts[name])}" for name in ("history", "feedback") if name in facts]
    each = [int(row.value) for row in found.where("boxes_each", agent=PEOPLE, condition="") if row.value is not None]
    if each:
        low, high = min(each), max(each)
        said.append(f"{count(high, 'box', 'boxes') if low == high else f'{low} to {high} boxes'} finished by each")
    return f"Participants: {', '.join(said)}." if said else ""


def _design(found: Results) -> str:
    study, conditions = found.study, found.design.conditions
    only, trials = set(study.get("strategy_conditions", ())), int(study.get("trials", 0))
    every, further = (
        [_condition(one.name, one.specs) for one in conditions if (one.name in only) == extra]
        for extra in (False, True)
    )
    also = f"; strategies also under {len(further)} further: {listed(further)}" if further else ""
    defined = any(one.specs for one in conditions)
    more = study.get("strategy_trials")
    extent = count(int(study.get("repetitions", 0)), "repetition") + f" of {count(trials, 'trial')}"
    extent += f" ({more} of strategies)" if more else ""
    budget = count(int(study.get("max_steps", 0)), "step")
    return (
        f"There were {count(len(every), 'condition')}: {listed(every)}{also}.{_EXPLAINED * defined} The design has "
        f"{extent} for each agent and condition, with a budget of {budget}. Trials of the same number share their "
        f"random numbers across conditions and agents (seed {study.get('seed')})."
    )


def _condition(name: str, specs: Sequence[str]) -> str:
    """A condition by its name and, where these differ, its interventions."""
    acts = " + ".join(specs)
    return _code(name) if not acts or acts == name else f"{_code(name)} = {_code(acts)}"


def _left_out(found: Results) -> str:
    progress, broken = found.progress, found.get("left_out", of="ended as error")
    errors = int(broken.value) if broken is not None and broken.value else 0
    left = f"; {count(errors, 'trial')} ended as an error and {'are' if errors != 1 else 'is'} in no number"
    return f"{progress.finished} of {progress.planned} planned trials were finished{left if errors else ''}."


def _tested(found: Results) -> str:
    rows = [row for row in found.against_control() if row.p_value is not None]
    if found.progress.every_look:
        return _at_every_look(found, rows)
    tests = list(dict.fromkeys(row.test.removesuffix(", and interval") for row in rows if row.test))
    most = max((row.corrected_for for row in rows), default=1)
    corrected = f", corrected for at most {most} comparisons of a family" if most > 1 else ""
    said = share_intervals_said(map(str, found.study.get("agents", ())), "Intervals of shares")
    said = tex_text(said).replace("Wilson intervals", r"Wilson intervals~\cite{wilson1927}")
    if not tests:
        return said
    by = listed([tex_text(_TESTS.get(one, one)) for one in tests])
    return f"{said} Changes of success were tested by {by}{corrected}; {_DETECTED}"


def _at_every_look(found: Results, rows: Sequence[Estimate]) -> str:
    """What holds at every look, by which method, and how P values come about where there are any."""
    said = tex_text(next(iter(found.said("overview", "every_look")), ""))
    shares = r"Intervals of shares are 95\,\% confidence sequences~\cite{robbins1970}."
    if not any(E_PROCESS in row.test for row in rows):
        return f"{said} {shares}".strip()
    many = max(row.corrected_for for row in rows)
    agents = len({row.agent for row in rows})
    corrected = f", corrected for at most {many} comparisons of a family" if many > 1 else ""
    corrected += " by closed testing with averages of e-values~\\cite{vovk-wang2021}" if many > 1 else ""
    corrected += f"{' and' if many > 1 else ', corrected'} for the number of agents" if agents > 1 else ""
    return (
        f"{said} {shares} "
        r"Those of changes of success are 95\,\% confidence sequences by betting~\cite{waudby-smith-ramdas2024}. Each "
        r"change was tested by an e-process: the wealth of bets against no change, which exceeds 20 at any look with a "
        r"probability of at most 0.05 if there is none~\cite{ville1939}. \emph{P} is 1 divided by the largest wealth "
        rf"so far{corrected}; {_DETECTED} Trials count in blocks of one trial under every condition, in the order of "
        "the plan, up to the first block that is not finished."
    ).strip()


def _kept(found: Results) -> str:
    return (
        rf"The settings (\texttt{{study.json}}) have the hash {_code(found.settings_hash)}, and the records "
        rf"{_code(found.results_hash)}; \texttt{{lockprobe verify}} recomputes every number from the records."
    )


def _code(spec: str) -> str:
    """A spec in typewriter type, which may be broken after its parts."""
    return rf"\texttt{{{tex_text(spec).replace(':', ':' + chr(92) + 'allowbreak{}')}}}"
