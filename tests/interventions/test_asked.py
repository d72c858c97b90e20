"""What an agent is asked, remembers and does: instructions, remarks, late and lost reports, short memories, slips."""

import itertools
import os
import re
from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from provider_server import here, truthful, words
from scipy.stats import binomtest

from lockprobe.agents.policy import Policy, Told
from lockprobe.agents.prompt import (
    FIELDS,
    INSTRUCTIONS,
    conversation,
    example,
    instructions,
    repair,
    reply_schema,
)
from lockprobe.agents.reply import parse_reply
from lockprobe.foundation.errors import BadFile, BadValue, ReplyFault, SettingsChanged, UserMistake
from lockprobe.interventions.asked import (
    ASIDES,
    LARGEST_TEMPLATE,
    NUDGE,
    REMARK,
    Hypothesis,
    OwnPrompt,
    Warn,
    loops_completed,
)
from lockprobe.interventions.catalogue import interventions_of
from lockprobe.interventions.done import History, Tremble
from lockprobe.simulation.exact import propagate
from lockprobe.statistics.misinterpretation import claims
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.running.runner import run_study
from lockprobe.studies.running.single import run_trial
from lockprobe.trial.briefing import Briefing
from lockprobe.trial.condition import spec_of
from lockprobe.trial.record import Decision, Moment, Percept, Situation, Task, Turn
from lockprobe.trial.trial_json import trial_from_json, trial_to_json

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


@pytest.mark.parametrize("shown", [example(), example(1), example(2), example(assessment=False)])
def test_the_usual_instruction_as_a_file_is_the_usual_instruction_and_documented(tmp_path, shown):
    assert said(written(tmp_path / "usual.txt", INSTRUCTIONS), shown=shown) == said(shown=shown)
    assert f"```text\n{INSTRUCTIONS}\n```" in (CURT.parents[2] / "docs" / "interventions.md").read_text("utf-8")


def test_fields_are_filled_in_and_nothing_else_changes(tmp_path):
    first, *others = said(OwnPrompt(file=str(CURT)))
    assert first.startswith("Open the box. Its 2 joints (B, A) lock each other, 0 and 1. Move A in 20 steps.\nThen you")
    assert '{"last_action": "moved" or' in first
    assert others == said()[1:]
    braces = said(written(tmp_path / "braces.txt", f"{LEAST} {{{{so}}}}"))[0]
    assert braces.startswith("B, A A Reply with")
    assert "{so}" in braces


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


@pytest.fixture
def provider(monkeypatch):
    for name in os.environ:
        if name.endswith(("_API_KEY", "_BASE_URL")):
            monkeypatch.delenv(name)
    with here(truthful, keep=True) as server:
        monkeypatch.setenv("FAKE_BASE_URL", server.url)
        monkeypatch.setenv("FAKE_API_KEY", "sk-private-0123456789")
        yield server


def test_two_prompts_are_two_conditions_of_one_study_on_the_wire_and_in_the_record(tmp_path, provider):
    files, texts = {}, {"curt": f"Open it. {LEAST}", "kind": f"Please open the box. {LEAST}"}
    for name, text in texts.items():
        files[name] = written(tmp_path / f"{name}.txt", text)
    asked = {"agent": "llm:openai-api/fake/model", "trials": 1, "repetitions": 1}
    asked["condition"] = [*(f"prompt?file={one.file}" for one in files.values()), "hypothesis?ask=after"]
    planned = study("flips", **asked)
    trials = run_study(planned, tmp_path / "study")
    first = min(len(request["messages"]) for request in provider.requests)
    begun = [request for request in provider.requests if len(request["messages"]) == first]
    openings = sorted(words(request["messages"][0]).split(".")[0] for request in begun)
    usual = "You are trying to open a lockbox, a panel with 4 joints"
    assert openings == ["Open it", "Please open the box", usual, usual]
    forms = [list(request["response_format"]["json_schema"]["schema"]["properties"]) for request in begun]
    assert forms.count(["last_action", "joint", "hypothesis"]) == 1
    recorded = [one for trial in trials for one in trial.interventions if one["intervention"] == "OwnPrompt"]
    assert {one["file"]: (one["text"], one["sha256"]) for one in recorded} == {
        one.file: (text, one.sha256) for one, text in zip(files.values(), texts.values(), strict=True)
    }
    assert len({trial.actions for trial in trials}) == 1  # this provider heeds no instruction
    for trial in trials:
        assert trial_from_json(trial_to_json(trial)) == trial
    written(tmp_path / "kind.txt", f"Kindly open the box. {LEAST}")
    assert study("flips", **asked).identity != planned.identity
    with pytest.raises(SettingsChanged, match="kind.txt"):
        run_study(study("flips", **asked), tmp_path / "study")


@pytest.mark.parametrize(
    ("ask", "keys", "kept"),
    [
        ("before", ["last_action", "hypothesis", "joint"], "a chain"),
        ("after", ["last_action", "joint", "hypothesis"], "a chain"),
        ("off", ["last_action", "joint"], ""),
    ],
)
def test_form_instruction_and_repair_ask_for_a_hypothesis_in_the_same_order(ask, keys, kept):
    situation = replace(example(), briefing=Hypothesis(ask=ask).brief(Briefing(), (), None, None))
    assert (situation == example()) == (ask == "before")
    schema = reply_schema(situation)
    assert list(schema["properties"]) == schema["required"] == keys
    for text in (conversation(situation)[0].text, repair(ReplyFault("why"), situation)):
        assert sorted(keys, key=lambda key: text.find(f'"{key}"')) == keys
        assert ('"hypothesis"' in text) == (ask != "off")
    reply = '{"last_action": "moved", "hypothesis": "a chain", "joint": "B"}'
    assert parse_reply(reply, situation).hypothesis == kept
    plain = instructions(example().task, positions=True, briefing=Briefing())
    if ask == "off":
        without = plain.replace('"hypothesis": a short sentence on how the box works or "", ', "")
        assert instructions(example().task, positions=True, briefing=situation.briefing) == without


@pytest.mark.parametrize(
    ("chosen", "copies", "due"),
    [("", 2, False), ("ABC", 2, False), ("ABCABC", 2, True), ("ABCDABC", 2, True), ("ABABA", 2, False),
     ("ABCABCA", 2, False), ("ABCABC", 3, False), ("ABCABCABC", 3, True), ("ABCABCDABC", 3, False)],
)  # fmt: skip
def test_a_nudge_is_due_when_a_copy_is_complete(chosen, copies, due):
    nothing = Percept()
    past = (Moment(was=nothing, told=nothing), *(Moment(was=nothing, told=nothing, chosen=c) for c in chosen))
    assert loops_completed(past, copies) is due


def test_nudge_and_remark_are_as_long_said_at_the_same_steps_and_change_no_blind_agent():
    plain, nudged, remarked, always = map(played, ("", "nudge?after=2", "remark?after=2", "remark?after=0"))
    spoken = [[step.step for step in trial.steps if step.remark] for trial in (nudged, remarked)]
    assert spoken[0] == spoken[1] != []
    assert {step.remark for step in nudged.steps} == {"", NUDGE}
    assert {step.remark for step in remarked.steps} == {"", REMARK}
    assert plain.actions == nudged.actions == remarked.actions
    assert [step.remark for step in always.steps] == ["", *[REMARK] * (len(always.steps) - 1)]
    assert abs(len(NUDGE) - len(REMARK)) <= 4


def test_a_language_model_reads_a_remark_beside_the_report_and_has_it_in_its_past():
    task = Task(joints=("A", "B"), target="A", budget=20)
    told = Percept(joint="B", outcome="moved", positions=(False, True), text="B moved.")
    turn = Turn(
        percept=Percept(positions=(False, False), text="At 1: none."), decision=Decision(joint="B", replies=("r",))
    )
    now = Situation(task=task, past=(turn,), percept=told, briefing=Briefing(remark=NUDGE))
    assert conversation(now)[-1].text == f"B moved. {NUDGE}"
    later = replace(now, past=(turn, Turn(percept=told, decision=turn.decision, remark=NUDGE)), briefing=Briefing())
    assert [message.text for message in conversation(later)][2::2] == [f"B moved. {NUDGE}", "B moved."]


def asides(p, **settings):
    return [step.remark for step in played(f"distract?p={p}", **settings).steps]


def test_irrelevant_sentences_come_at_rate_p_nested_and_leave_reports_as_they_are():
    none, few, many, (first, *always) = map(asides, (0, 0.3, 0.7, 1))
    assert set(none) == {first} == {""}
    assert set(always) <= set(ASIDES)
    assert len(set(always)) > 2
    assert all(a in ("", b) for a, b in zip(few, many, strict=True))
    assert few != many
    steps = [remark for trial in range(1, 101) for remark in asides(0.3, trial=trial)[1:]]
    assert binomtest(sum(map(bool, steps)), len(steps), 0.3).pvalue > 0.001
    for agent in ("human-inspired", "ideal-observer"):
        plain, distracted = (run_trial(agent=agent, p=0.3, condition=c) for c in ("", "distract?p=1"))
        assert [(s.told, s.decision) for s in plain.steps] == [(s.told, s.decision) for s in distracted.steps]


@pytest.mark.parametrize("aside", ASIDES)
def test_no_sentence_speaks_of_what_moved_or_names_a_joint(aside):
    assert not re.search(r"mov|lock|block|position|attempt|false|true|loop|repeat|\b[A-H]\b", aside)


@pytest.mark.parametrize("lag", [1, 2, 5])
def test_every_late_report_is_the_truth_of_some_attempts_ago(lag):
    trial = played(f"delay?lag={lag} + symbolic")
    label = dict(zip(trial.joints, trial.labels, strict=True))
    moved = {True: "moved", False: "did not move"}
    for now, then in zip(trial.steps[lag:], trial.steps, strict=False):
        assert now.told.startswith(f"{label[then.joint]} {moved[then.moved]}.")
        assert now.told_moved == then.moved
    assert {(step.told_moved, step.told) for step in trial.steps[:lag]} == {(None, "")}


def test_a_delay_forgets_what_was_before_it_and_keeps_what_comes_after():
    plain, before, after = (
        played(spec, modality="symbolic")
        for spec in ("delay?lag=1", "flip?p=1 + delay?lag=1", "delay?lag=1 + flip?p=1")
    )
    assert [step.told for step in before.steps] == [step.told for step in plain.steps]
    told = [step.told_moved for step in plain.steps[1:]]
    assert [step.told_moved for step in after.steps[1:]] == [not moved for moved in told]


def test_nothing_is_told_of_an_attempt_whose_report_is_lost_and_it_is_lost_at_a_larger_dose_too():
    doses = [played(f"drop?p={p}", max_steps=30) for p in (0.0, 0.3, 0.7, 1.0)]
    lost = [{step.step for step in trial.steps if step.told_moved is None} for trial in doses]
    assert all(few <= many for few, many in itertools.pairwise(lost))
    assert [len(steps) for steps in lost][0::3] == [0, 30]
    trial = played("drop?p=1", "random")
    assert {(step.told_moved, step.told_state, step.told) for step in trial.steps} == {(None, None, "")}
    assert {step.decision.claimed for step in trial.steps} == {None}
    assert trial.opening  # the first look is no report


def test_a_strategy_learns_nothing_of_an_attempt_that_was_not_reported_and_cannot_misread_it():
    trial = run_trial(agent="human-inspired", condition="drop?p=1")
    assert set(trial.actions) == {trial.target}
    trial = run_trial(agent="human-inspired", condition="drop?p=0.5", seed=1)
    told = sum(step.told_moved is not None for step in trial.steps[:-1])
    assert len(claims(trial)) == told < len(trial.steps) - 1
    assert not any(step.told_falsely for step in trial.steps)
    assert not trial.ordinary


TURNS = tuple(Turn(percept=Percept(text=str(i)), decision=Decision(joint="A")) for i in range(5))


@pytest.mark.parametrize(("last", "left"), [(0, ()), (2, TURNS[3:]), (5, TURNS), (9, TURNS)])
def test_the_newest_exchanges_are_left(last, left):
    assert History(last=last).recall(TURNS, None, None) == left


class Windowed(Policy[tuple[Told, ...]]):
    """Does what its last two reports say, and nothing else."""

    def begin(self, view):
        return ()

    def remember(self, view, memory, told):
        return (*memory, told)[-2:]

    def probabilities(self, view, memory):
        said = sum((3 * told.joint + 5 * told.moved + 7 * (told.shifted or 0)) for told in memory)
        weights = [1 + (said * (j + 2)) % 5 for j in range(view.joints)]
        return tuple(weight / sum(weights) for weight in weights)


@pytest.mark.parametrize(
    ("agent", "last", "same"),
    [
        ("random-no-repeat", 1, True), ("random", 0, True), (Windowed(), 2, True), (Windowed(), 3, True),
        ("human-inspired", 1, False),
    ],
)  # fmt: skip
def test_a_policy_of_a_shorter_memory_plays_byte_for_byte_as_before(agent, last, same):
    for seed in (1, 2, 3, 4, 5) if same else (2,):
        plain, short = (run_trial(agent=agent, p=0.2, seed=seed, condition=c) for c in ("", f"history?last={last}"))
        assert (plain.steps == short.steps) == same


def test_a_hand_that_slips_attempts_another_joint_and_is_truthfully_reported():
    trial = played("tremble?p=1 + symbolic", "random")
    label = dict(zip(trial.joints, trial.labels, strict=True))
    for step in trial.steps:
        assert step.chosen not in (None, step.joint)
        assert label[step.chosen] == step.decision.joint
        assert step.told.startswith(label[step.joint])
        assert step.told_moved == step.moved
    task, rng = Task(joints=("A", "B", "C", "D"), target="D", budget=20), np.random.default_rng(1)
    found = Counter(Tremble(p=1).act("B", (), task, rng) for _ in range(3000))
    assert set(found) == {"A", "C", "D"}
    assert all(binomtest(n, 3000, 1 / 3).pvalue > 0.001 for n in found.values())


def test_a_slip_is_a_lapse_of_the_agent_s_hand():
    """A lapse takes any of four joints, a slip any of the three others: a slip of 0.3 is a lapse of 0.4."""
    exact = propagate("human-inspired?lapse=0.4", p=0.0).success
    trials = [run_trial(agent="human-inspired", condition="tremble?p=0.3", trial=t) for t in range(1, 301)]
    assert binomtest(sum(trial.solved for trial in trials), 300, exact).pvalue > 0.001


def test_one_step_is_the_experimenter_s_and_all_others_are_the_agent_s():
    trial, plain = (played(condition, seed=2) for condition in ("force?at=3", ""))
    assert [step.step for step in trial.steps if step.chosen is not None] == [3]
    assert trial.actions[:2] == plain.actions[:2]
    assert trial.steps[2].chosen == plain.actions[2]
    with pytest.raises(BadValue, match="joint: got 'door', expected one of A, D, C, B"):
        run_trial(agent="round-robin", condition="force?at=2&joint=door", modality="symbolic")
