"""What an agent is asked, remembers and does: instructions, remarks, late and lost reports, short memories, slips."""

import itertools
from dataclasses import replace
from pathlib import Path

import pytest

from lockprobe.agents.prompt import (
    FIELDS,
    conversation,
    example,
)
from lockprobe.foundation.errors import BadFile, BadValue, UserMistake
from lockprobe.interventions.asked_and_done import (
    ASIDES,
    LARGEST_TEMPLATE,
    NUDGE,
    REMARK,
    History,
    Nudge,
    OwnPrompt,
    Warn,
)
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
    with pytest.raises(BadFile, match="a directory"):
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
    assert (Nudge(after=copies).brief(Briefing(), past, None, None).remark == NUDGE) is due


def test_nudge_and_remark_are_as_long_said_at_the_same_steps_and_change_no_blind_agent():
    plain, nudged, remarked = map(played, ("", "nudge?after=2", "remark?after=2"))
    spoken = [[step.step for step in trial.steps if step.remark] for trial in (nudged, remarked)]
    assert spoken[0] == spoken[1] != []
    assert {step.remark for step in nudged.steps} == {"", NUDGE}
    assert {step.remark for step in remarked.steps} == {"", REMARK}
    assert plain.actions == nudged.actions == remarked.actions
    assert abs(len(NUDGE) - len(REMARK)) <= 4


def asides(p, **settings):
    return [step.remark for step in played(f"distract?p={p}", **settings).steps]


def test_irrelevant_sentences_come_at_rate_p_nested_and_leave_reports_as_they_are():
    none, few, many, (first, *always) = map(asides, (0, 0.3, 0.7, 1))
    assert set(none) == {first} == {""}
    assert set(always) <= set(ASIDES)
    assert len(set(always)) > 2
    assert all(a in ("", b) for a, b in zip(few, many, strict=True))
    assert few != many
    for agent in ("human-inspired", "ideal-observer"):
        plain, distracted = (run_trial(agent=agent, p=0.3, condition=c) for c in ("", "distract?p=1"))
        assert [(s.told, s.decision) for s in plain.steps] == [(s.told, s.decision) for s in distracted.steps]


@pytest.mark.parametrize("lag", [1, 2, 5])
def test_every_late_report_is_the_truth_of_some_attempts_ago(lag):
    trial = played(f"delay?lag={lag} + symbolic")
    label = dict(zip(trial.joints, trial.labels, strict=True))
    moved = {True: "moved", False: "did not move"}
    for now, then in zip(trial.steps[lag:], trial.steps, strict=False):
        assert now.told.startswith(f"{label[then.joint]} {moved[then.moved]}.")
        assert now.told_moved == then.moved
    assert {(step.told_moved, step.told) for step in trial.steps[:lag]} == {(None, "")}


def test_nothing_is_told_of_an_attempt_whose_report_is_lost_and_it_is_lost_at_a_larger_dose_too():
    doses = [played(f"drop?p={p}", max_steps=30) for p in (0.0, 0.3, 0.7, 1.0)]
    lost = [{step.step for step in trial.steps if step.told_moved is None} for trial in doses]
    assert all(few <= many for few, many in itertools.pairwise(lost))
    assert [len(steps) for steps in lost][0::3] == [0, 30]
    trial = played("drop?p=1", "random")
    assert {(step.told_moved, step.told_state, step.told) for step in trial.steps} == {(None, None, "")}
    assert {step.decision.claimed for step in trial.steps} == {None}
    assert trial.opening  # the first look is no report


TURNS = tuple(Turn(percept=Percept(text=str(i)), decision=Decision(joint="A")) for i in range(5))


@pytest.mark.parametrize(("last", "left"), [(0, ()), (2, TURNS[3:]), (5, TURNS), (9, TURNS)])
def test_the_newest_exchanges_are_left(last, left):
    assert History(last=last).recall(TURNS, (), None, None) == left


def test_one_step_is_the_experimenter_s_and_all_others_are_the_agent_s():
    trial, plain = (played(condition, seed=2) for condition in ("tremble?p=1&at=3", ""))
    assert [step.step for step in trial.steps if step.chosen is not None] == [3]
    assert trial.actions[:2] == plain.actions[:2]
    assert trial.steps[2].chosen == plain.actions[2]
