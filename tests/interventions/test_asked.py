"""What an agent is asked, remembers and does: instructions, remarks, late and lost reports, short memories, slips."""

from dataclasses import replace
from pathlib import Path

import pytest

from lockprobe.agents.prompt import FIELDS, conversation, example
from lockprobe.foundation.errors import BadFile, BadValue, UserMistake
from lockprobe.interventions.asked_and_done import ASIDES, LARGEST_TEMPLATE, History, Nudge, OwnPrompt, Remark, Warn
from lockprobe.interventions.conditions import interventions_of
from lockprobe.studies.running.single import run_trial
from lockprobe.trial.condition import spec_of
from lockprobe.trial.record import Briefing, Decision, Moment, Percept, Turn

CURT = Path(__file__).with_name("curt.txt")
LEAST = "{joints} {target} {reply}"


def played(condition, agent="round-robin", **settings):
    return run_trial(agent=agent, box="chain-7", condition=condition, **settings)


def written(path, text):
    path.write_text(text, "utf-8")
    return OwnPrompt(file=str(path))


def said(*interventions, shown=None):
    briefing = Briefing()
    for one in interventions:
        briefing = one.brief(briefing, (), None, None)
    return [message.text for message in conversation(replace(shown or example(), briefing=briefing))]


@pytest.mark.parametrize(("rate", "often"), [(None, "sometimes"), (0.4, "with probability 0.4")])
def test_a_warning_stands_in_the_instruction_once_also_where_a_template_has_no_place_for_it(tmp_path, rate, often):
    (first, *others), (plain, *same) = said(Warn(rate=rate)), said()
    assert others == same
    assert first.replace(f" What you are told of your last action is {often} false.", "") == plain != first
    for own in (written(tmp_path / "plain.txt", LEAST), OwnPrompt(file=str(CURT))):
        assert said(own, Warn(rate=rate))[0].count(f"{often} false.") == 1


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (f"{LEAST} {{p}}", "no field of a template is called 'p'; there are: " + ", ".join(FIELDS)),
        (f"{LEAST} {{joints.__class__}}", "no field of a template is called"),
        (f"{LEAST} {{budget:>99999999}}", "no field of a template is called"),
        (f"{LEAST} {{}}", "no field of a template is called"),
        (f"{LEAST} {{", "fields in single braces, and all other braces doubled"),
        ("{joints} {target}", "fields of a template: got 'joints, target', expected at least joints, target, reply"),
        (LEAST + "x" * LARGEST_TEMPLATE, "larger than"),
        (f"{LEAST}\udcff", "not UTF-8"),
    ],
)
def test_a_template_that_cannot_be_used_is_refused_in_one_line(tmp_path, text, expected):
    (tmp_path / "bad.txt").write_bytes(text.encode(errors="surrogateescape"))
    with pytest.raises(UserMistake) as refused:
        OwnPrompt(file=str(tmp_path / "bad.txt"))
    assert expected in str(refused.value)
    assert "\n" not in str(refused.value)
    with pytest.raises(BadFile, match="Is a directory"):
        OwnPrompt(file=str(tmp_path))


def test_the_spec_of_a_template_names_its_content_and_refuses_another(tmp_path):
    one = written(tmp_path / "one.txt", LEAST)
    spec = spec_of(one)
    assert spec.endswith(f"&sha256={one.sha256}")
    assert interventions_of(spec) == (one,)
    (tmp_path / "one.txt").write_text(f"{LEAST}!")
    with pytest.raises(BadValue, match="the hash of its present content"):
        interventions_of(spec)
    assert run_trial(condition=f"prompt?file={CURT}").steps == run_trial().steps


@pytest.mark.parametrize(
    ("chosen", "copies", "due"),
    [("", 2, False), ("ABC", 2, False), ("ABCABC", 2, True), ("ABCDABC", 2, True), ("ABABA", 2, False),
     ("ABCABCA", 2, False), ("ABCABC", 3, False), ("ABCABCABC", 3, True), ("ABCABCDABC", 3, False)],
)  # fmt: skip
def test_a_nudge_is_due_when_a_copy_is_complete(chosen, copies, due):
    nothing = Percept()
    past = (Moment(was=nothing, told=nothing), *(Moment(was=nothing, told=nothing, chosen=c) for c in chosen))
    assert (Nudge(after=copies).brief(Briefing(), past, None, None).remark == Nudge.says) is due


def test_nudge_and_remark_are_as_long_said_at_the_same_steps_and_change_no_blind_agent():
    plain, nudged, remarked = map(played, ("", "nudge?after=2", "remark?after=2"))
    spoken = [[step.step for step in trial.steps if step.remark] for trial in (nudged, remarked)]
    assert spoken[0] == spoken[1] != []
    assert {step.remark for step in nudged.steps} == {"", Nudge.says}
    assert {step.remark for step in remarked.steps} == {"", Remark.says}
    assert plain.actions == nudged.actions == remarked.actions
    assert abs(len(Nudge.says) - len(Remark.says)) <= 4


HITS = {
    "flip": lambda step: step.told_falsely,
    "correction": lambda step: "Correction:" in step.told,
    "drop": lambda step: (step.told_moved, step.told_state, step.told) == (None, None, ""),
    "distract": lambda step: step.remark in ASIDES,
    "tremble": lambda step: step.chosen is not None,
}
"""What shows that an intervention hit a step."""


@pytest.mark.parametrize("name", HITS)
def test_what_is_hit_at_a_smaller_dose_is_hit_at_a_larger_whatever_else_acts(name):

    def hit(spec):
        return {step.step for step in played(spec, max_steps=12, modality="symbolic").steps if HITS[name](step)}

    none, few, many, every = (hit(f"{name}?p={p}") for p in (0, 0.3, 0.7, 1))
    assert none == set() < few < many < every >= {*range(2, 13)}
    assert hit(f"warn + {name}?p=0.3 + nudge?after=3") == few
    after = name == "distract"  # a sentence comes with the report, before the next step
    assert hit(f"{name}?p=1&at=3;5") == {3 + after, 5 + after}


def test_an_irrelevant_sentence_and_a_lost_report_leave_all_else_as_it_is():
    for agent in ("human-inspired", "ideal-observer"):
        plain, distracted = (run_trial(agent=agent, p=0.3, condition=c) for c in ("", "distract?p=1"))
        assert [(s.told, s.decision) for s in plain.steps] == [(s.told, s.decision) for s in distracted.steps]
    lost = played("drop?p=1", "random")
    assert {step.decision.claimed for step in lost.steps} == {None}
    assert lost.opening  # the first look is no report


@pytest.mark.parametrize("lag", [1, 2, 5])
def test_every_late_report_is_the_truth_of_some_attempts_ago(lag):
    trial = played(f"delay?lag={lag} + symbolic")
    label = dict(zip(trial.joints, trial.labels, strict=True))
    moved = {True: "moved", False: "did not move"}
    for now, then in zip(trial.steps[lag:], trial.steps, strict=False):
        assert now.told.startswith(f"{label[then.joint]} {moved[then.moved]}.")
        assert now.told_moved == then.moved
    assert {(step.told_moved, step.told) for step in trial.steps[:lag]} == {(None, "")}


TURNS = tuple(Turn(percept=Percept(text=str(i)), decision=Decision(joint="A")) for i in range(5))


@pytest.mark.parametrize(("last", "left"), [(0, ()), (2, TURNS[3:]), (5, TURNS), (9, TURNS)])
def test_the_newest_exchanges_are_left(last, left):
    assert History(last=last).recall(TURNS, (), None, None) == left
