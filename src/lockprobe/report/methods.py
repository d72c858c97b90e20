"""The paragraph on the methods of an article, in words that can stand in it, from the rows and settings of results."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping

from lockprobe.foundation.formatting import count, listed
from lockprobe.foundation.spec import PEOPLE, Spec
from lockprobe.report.format import tex_text
from lockprobe.report.prose import false_reports, share_intervals_said
from lockprobe.report.rows import Condition, Estimate, Results
from lockprobe.statistics.conditions.modalities import spoken
from lockprobe.statistics.sequential.contrasts import E_PROCESS

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
    "prompt": "prompt with the fingerprint {}",
}
"""A fact on record of a model -> how the paragraph says it."""

_LEFT = {
    "temperature": "temperature",
    "top_p": "top-p",
    "effort": "reasoning effort",
    "max_tokens": "length of a reply",
}
"""What can be left to the provider."""

_WORDS: Mapping[str, str] = {
    "correction": "reports in two statements",
    "delay": "late reports",
    "drop": "missing reports",
    "phantom": "reports of a false position elsewhere",
    "yoked": "false reports at other steps",
    "distract": "an irrelevant sentence with the report",
    "nudge": "a sentence against repetition",
    "remark": "a sentence without information",
    "warn": "a warning of false reports",
    "history": "a shortened memory",
    "force": "forced attempts",
    "tremble": "attempts at other joints",
}
"""An intervention -> what it is in an article."""

_RATES = 4
"""Flip rates beyond which they are counted."""

_DETECTED = r"a change counts as detected if \emph{P} is below 0.05 and its 95\,\% interval excludes 0."


def spec_in_words(spec: str) -> str:
    """A spec as an article can say it.

    >>> spec_in_words("flip?p=0.4&others=kept"), spec_in_words("drop?p=0.3"), spec_in_words("history?last=3")
    ('false reports that stay at rate 0.4', 'missing reports at rate 0.3', 'a shortened memory (last 3)')
    """
    parsed = Spec.parse(spec, "condition")
    rate = f" at rate {parsed.options['p']}" if "p" in parsed.options else ""
    if parsed.full_name == "flip":
        return f"{_reading(parsed)}{rate}"
    others = parsed.without(["p"]).options.items()
    options = ", ".join(f"{name.replace('_', ' ')} {value}" for name, value in others)
    return f"{_WORDS.get(parsed.full_name, parsed.full_name)}{rate}{f' ({options})' * bool(options)}"


def _reading(flip: Spec) -> str:
    """What a false report is; empty for what is no flip."""
    if flip.full_name != "flip":
        return ""
    return false_reports("&".join(f"{name}={value}" for name, value in flip.without(["p"]).options.items()))


def condition_in_words(one: Condition, *, explained: bool = False) -> str:
    """What acts under a condition, or the experimenter's name for it, ``explained`` by what acts."""
    acts = " and ".join(map(spec_in_words, one.specs)) or "truth"
    named = one.specs and not set("?+") & set(one.name) and one.name not in one.specs
    return acts if not named else f"{one.name} ({acts.replace(' (', ', ').replace(')', '')})" if explained else one.name


def methods_tex(found: Results) -> str:
    """Puzzle, agents, models, design, what is left out, intervals and tests, and the hashes."""
    parts = (_system, _agents, _models, _participants, _design, _tested)
    said = (sentence for part in parts for sentence in part(found))
    hashes = (rf"\texttt{{{tex_text(one)}}}" for one in (found.settings_hash, found.results_hash))
    kept = "The settings of the study have the hash {}, its records {}.".format(*hashes)
    return " ".join((*said, kept)) + "\n"


def _system(found: Results) -> Iterator[str]:
    boxes, study = found.boxes, found.study
    yield (
        rf"We used Lockprobe {tex_text(found.lockprobe)}~\cite{{lockprobe}}, which implements the system of Zenkri and "
        r"Brock~\cite{zenkri-brock}."
    )
    yield f"An agent has {count(int(study.get('max_steps', 0)), 'step')} to open a box whose joints lock each other."
    names = [_name(str(box.get("name", ""))) for box in boxes]
    sizes = sorted({len(box.get("joints", ())) for box in boxes})
    of = f"with {' to '.join(map(str, sizes))} joint{'s' * (sizes[-1] != 1)}"
    yield f"The box was {names[0]}, {of}." if len(boxes) == 1 else f"The {len(boxes)} boxes were {listed(names)}, {of}."
    if any(box.get("name") == "chain-4" for box in boxes):
        yield "The interlock of their box is not public; ours is a reconstruction."
    shown = listed(list(dict.fromkeys(spoken(one.modality) for one in found.design.conditions)), "or")
    plant = str(study.get("plant", "symbolic"))
    on = "" if plant == "symbolic" else f", on the plant {spec_in_words(plant)}"
    yield f"After each action it was shown as {tex_text(f'{shown}{on}')}."
    yield from filter(None, [_LABELS.get(str(study.get("shuffle")), "")])


def _played_by(found: Results) -> dict[str, str]:
    """The agents, without the options of their specs where these tell none apart."""
    agents = [str(agent) for agent in found.study.get("agents", ()) if agent != PEOPLE]
    short = Counter(agent.partition("?")[0] for agent in agents)
    return {agent: _name(head if short[head := agent.partition("?")[0]] == 1 else agent) for agent in agents}


def _agents(found: Results) -> Iterator[str]:
    called = _played_by(found)
    many = next((row.value for row in found.where("people", agent=PEOPLE, condition="", of="") if row.value), None)
    by = [count(int(many), "participant") if many else "people"] * (PEOPLE in found.study.get("agents", ()))
    by += [f"{count(len(called), 'agent')} ({listed([*called.values()])})"] if called else []
    yield f"The box was played by {listed(by)}."
    ours = [called[one] for names in found.facts_about("design") for one in names.split(", ") if one in called]
    played = {one.agent for one in found.design.players}
    others = [name for agent, name in called.items() if agent in played and agent not in found.subjects]
    said = [f"{listed(ours)} reconstructs their strategy, whose algorithm is not public"] if ours else []
    said += [f"{listed(others)} {'are baselines' if others[1:] else 'is a baseline'}"] if others else []
    if said:
        yield f"Of these, {'; '.join(said)}."


def _models(found: Results) -> Iterator[str]:
    """What is on record of each language model, in a sentence of its own."""
    for agent, called in _played_by(found).items():
        facts = found.facts_about(agent)
        if "model" in facts:
            known = {one: form.format(facts[one]) for one, form in _FACTS.items() if one in facts}
            known |= {
                one: f"{_LEFT[one]} left to the provider" for one in _LEFT if facts.get(one) == "provider default"
            }
            known |= {"effort": "no reasoning effort"} if facts.get("effort") == "not taken" else {}
            said = [*known.values(), *["no seed sent"] * ("repairs" in facts)]
            yield f"{called}: {tex_text(', '.join(said))}."
            for row in found.where("replies", agent=agent, of="asked again"):
                yield f"{row.count} of its {row.n} replies could not be used and were asked for again."


def _participants(found: Results) -> Iterator[str]:
    """What participants saw, and how many boxes each of them finished."""
    facts, shown = found.facts_about(PEOPLE), {"True": "shown", "False": "not shown"}
    names = ("view", "history", "feedback")
    said = [f"{name} {tex_text(shown.get(facts[name], facts[name]))}" for name in names if name in facts]
    each = [found.get("boxes", agent=PEOPLE, condition="", of=f"{end} of a person") for end in ("fewest", "most")]
    if boxes := [int(row.value) for row in each if row and row.value is not None]:
        low, high = min(boxes), max(boxes)
        said.append(f"{count(high, 'box', 'boxes') if low == high else f'{low} to {high} boxes'} finished by each")
    if said:
        yield f"Participants: {', '.join(said)}."


def _design(found: Results) -> Iterator[str]:
    study, conditions = found.study, found.design.conditions
    only = set(study.get("strategy_conditions", ()))
    every = [one for one in conditions if one.name not in only]
    further = [one for one in conditions if one.name in only]
    ways = len({one.modality for one in conditions})
    each = ", for each way of showing the box" if ways > 1 and not len(conditions) % ways else ""
    also = f"; strategies also under {len(further)} further: {_conditions(further)}" if further else ""
    yield f"There were {count(len(every), 'condition')}: {_conditions(every)}{each}{also}."
    if kind := "; ".join(found.said("readings", "what")):
        yield tex_text(kind)
    more = f" ({study['strategy_trials']} of strategies)" if study.get("strategy_trials") else ""
    yield (
        f"The design has {count(int(study.get('repetitions', 0)), 'repetition')} of "
        f"{count(int(study.get('trials', 0)), 'trial')}{more} for each agent and condition. Trials of the same number "
        f"share their random numbers across conditions and agents (seed {study.get('seed')})."
    )
    broken = found.get("left_out", of="ended as error")
    errors = int(broken.value) if broken is not None and broken.value else 0
    left = f"; {count(errors, 'trial')} ended as an error" if errors else ""
    yield f"{found.progress.finished} of {found.progress.planned} planned trials were finished{left}."


def _conditions(conditions: Iterable[Condition]) -> str:
    """All conditions in words: the flip rates of one kind of false reports together, each way to show the box once."""
    rates: dict[str, list[float]] = {}
    for one in conditions:
        words, specs = condition_in_words(one, explained=True), [Spec.parse(spec, "condition") for spec in one.specs]
        if len(specs) == 1 and words == f"{_reading(specs[0])} at rate {(p := specs[0].options.get('p', ''))}":
            rates.setdefault(_reading(specs[0]), []).append(float(p))
        else:
            rates.setdefault("the truth" if words == "truth" else words, [])
    said = list[str]()
    for words, own in ((words, sorted({*own})) for words, own in rates.items()):
        few = f" at rate{'s' * (len(own) > 1)} {listed([f'{one:g}' for one in own])}" if own else ""
        said.append(words + (f" at {len(own)} rates from {own[0]:g} to {own[-1]:g}" if len(own) > _RATES else few))
    return tex_text(listed(said))


def _tested(found: Results) -> Iterator[str]:
    rows = [row for row in found.against_control() if row.p_value is not None]
    if found.progress.every_look:
        yield from _at_every_look(found, rows)
        return
    boxes = len(found.boxes)
    said = share_intervals_said(map(str, found.study.get("agents", ())), "Intervals of shares", boxes=boxes)
    yield tex_text(said).replace("Wilson intervals", r"Wilson intervals~\cite{wilson1927}")
    if tests := dict.fromkeys(row.test.removesuffix(", and interval") for row in rows if row.test):
        by = listed([tex_text({"McNemar": "McNemar's exact test"}.get(one, one)) for one in tests])
        most = max(row.corrected_for for row in rows)
        corrected = f", corrected for at most {most} comparisons of a family" if most > 1 else ""
        yield f"Changes of success were tested by {by}{corrected}; {_DETECTED}"


def _at_every_look(found: Results, rows: list[Estimate]) -> Iterator[str]:
    """What holds at every look, by which method, and how P values come about where there are any."""
    yield from map(tex_text, found.said("overview", "every_look")[:1])
    yield r"Intervals of shares are 95\,\% confidence sequences~\cite{robbins1970}."
    if any(E_PROCESS in row.test for row in rows):
        many, agents = max(row.corrected_for for row in rows), len({row.agent for row in rows})
        corrected = f", corrected for at most {many} comparisons of a family" if many > 1 else ""
        corrected += " by closed testing with averages of e-values~\\cite{vovk-wang2021}" if many > 1 else ""
        corrected += f"{' and' if many > 1 else ', corrected'} for the number of agents" if agents > 1 else ""
        yield (
            r"Those of changes of success are 95\,\% confidence sequences by betting~\cite{waudby-smith-ramdas2024}. "
            r"Each change was tested by an e-process: the wealth of bets against no change, which exceeds 20 at any "
            r"look with a probability of at most 0.05 if there is none~\cite{ville1939}. \emph{P} is 1 divided by the "
            rf"largest wealth so far{corrected}; {_DETECTED} Trials count in blocks of one trial under every "
            "condition, in the order of the plan, up to the first block that is not finished."
        )


def _name(agent: str) -> str:
    """A name that may be broken after its parts."""
    return tex_text(agent).replace(":", r":\allowbreak{}").replace("/", r"/\allowbreak{}")
