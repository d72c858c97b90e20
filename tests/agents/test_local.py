"""The embedded model plays: well-formed replies, exact probabilities, reproducible trials, nothing leaked."""

import asyncio

import forked
import pytest

from lockprobe import load, run_trial
from lockprobe.agents.catalogue import resolve
from lockprobe.agents.local import CONSTANT, UNASKED, LocalModel, LocalSettings
from lockprobe.boxes.families import box
from lockprobe.foundation.errors import BadValue, UserMistake
from lockprobe.studies.options.study_options import StudyOptions
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.records.journal import Journal
from lockprobe.studies.running.runner import Limits, run
from lockprobe.studies.running.trial_setup import play_timed
from lockprobe.trial.trial_json import trial_to_json


@pytest.fixture(scope="module")
def model():
    source = resolve("llm:local?temperature=1")
    source.check()
    return source.make()


SHORT = {"p": 0.4, "trial": 5, "max_steps": 2}


@pytest.fixture(scope="module")
def trial(model):
    return run_trial(agent=model, **SHORT)


def test_the_exact_probability_of_every_joint_is_recorded(trial):
    for step in trial.steps:
        assert len(step.decision.probabilities) == 4
        assert sum(step.decision.probabilities) == pytest.approx(1)
        assert all(0 < chance < 1 for chance in step.decision.probabilities)
        assert (step.decision.claim_probability is None) == (step.step == 1)


def test_the_record_says_what_the_model_was(trial):
    facts = trial.facts
    assert facts["model"] == "SmolLM2-135M-Instruct.Q4_1"
    assert facts["sha256"] == "b179c9523d0e6a0f98a330c7562b682750a6f8c8c15e5bc70ea373728110db53"
    assert (facts["quantisation"], facts["threads"], facts["temperature"]) == ("Q4_1", 1, 1.0)
    assert (facts["decoding"], facts["calibration"]) == ("scored answers", "none")
    assert str(facts["runtime"]).startswith("xllamacpp ")


@pytest.mark.slow
def test_the_same_seed_gives_the_same_record_whatever_was_played_before(model, trial):
    run_trial(agent=model, p=0.0, trial=6, max_steps=2)
    again = run_trial(agent=model, **SHORT)
    assert trial_to_json(again) == trial_to_json(trial)
    script = (
        "from lockprobe import run_trial;"
        "from lockprobe.trial.trial_json import trial_to_json; import sys;"
        f"t = run_trial(agent='llm:local', **{SHORT});"
        "sys.stdout.write(trial_to_json(t).decode())"
    )
    elsewhere = forked.run([], script=script)
    assert elsewhere.stdout == trial_to_json(trial).decode()
    other = run_trial(agent=model, seed=2, **SHORT)
    assert [step.decision for step in other.steps] != [step.decision for step in trial.steps]


@pytest.mark.slow
def test_two_worker_processes_write_the_records_of_one(model, tmp_path):
    planned = study(StudyOptions(agent=["llm:local"], p=[0.4], trials=2, repetitions=1, max_steps=2))
    with Journal.open(tmp_path, planned) as journal:
        run(planned, journal, limits=Limits(workers=2))
    here = [asyncio.run(play_timed(plan, model))[0] for plan in planned.plans("llm:local")]
    written = sorted(load(tmp_path), key=lambda trial: trial.trial)
    assert [trial_to_json(trial) for trial in written] == [trial_to_json(trial) for trial in here]
    assert len(here) == 2


class Recording:
    """An engine that only remembers what it was asked."""

    def __init__(self):
        self.asked = []

    def restart(self, constant):
        self.constant = constant

    def tokens(self, text):
        return (text,)

    def opening(self, text):
        return self.tokens(text)

    def score(self, prompt, options):
        self.asked.append(("".join(prompt), ["".join(option) for option in options]))
        return [1 / len(options)] * len(options)


def asked(**settings):
    engine = Recording()
    trial = run_trial(agent=LocalModel(engine, {}), **settings)
    return engine, trial


def test_the_log_holds_what_was_told_and_what_was_said():
    engine, trial = asked(p=0.5, trial=3, max_steps=4)
    joints, claims = engine.asked[-1], engine.asked[-2]
    assert joints[1] == [f" {label}" for label in trial.listing]
    assert claims[1] == [" moved", " did not move"]
    assert joints[0].startswith(CONSTANT)
    target = trial.labels[0]
    expected = (
        f" The joints are: {', '.join(trial.listing)}. The target joint is: {target}. The given steps are: 4."
        f"\n\nStep log:\nObservation: {trial.opening}\n"
    )
    for step in trial.steps[:3]:
        expected += f"{step.decision.replies[0] if step.step > 1 else ' ' + step.decision.replies[0]}.\n"
        expected += f"Observation: {step.told}\n"
    assert joints[0].removeprefix(CONSTANT) == expected + trial.steps[3].decision.replies[0].removesuffix(
        f" {trial.steps[3].decision.joint}"
    )


@pytest.mark.parametrize("assessment", [True, False])
def test_every_question_continues_the_one_before_by_two_tokens_or_more(assessment):
    """Or the runtime would evaluate a single token, which gives slightly other numbers."""
    engine, _ = asked(p=0.5, trial=3, max_steps=6, assessment=assessment)
    for (before, _), (after, _) in zip(engine.asked, engine.asked[1:], strict=False):
        assert after.startswith(before)
        assert len(after) > len(before) + 5


def test_where_nobody_asks_what_the_last_action_did_it_is_neither_said_nor_scored():
    engine, trial = asked(p=0.5, trial=3, max_steps=4, assessment=False)
    assert engine.constant == UNASKED
    assert len(engine.asked) == len(trial.steps)
    for step, (prompt, options) in zip(trial.steps, engine.asked, strict=True):
        assert options == [f" {label}" for label in trial.listing]
        assert "Last joint" not in prompt
        assert "last joint moved" not in prompt
        assert prompt.startswith(UNASKED)
        assert (step.decision.claimed, step.decision.claim_probability) == (None, None)
        assert step.decision.replies == (f"Next joint: {step.decision.joint}",)


@pytest.mark.slow
def test_a_model_that_is_asked_and_one_that_is_not_leave_each_others_trials_alone(model, trial):
    unasked = run_trial(agent=model, assessment=False, **SHORT)
    assert trial_to_json(run_trial(agent=model, **SHORT)) == trial_to_json(trial)
    assert trial_to_json(run_trial(agent=model, assessment=False, **SHORT)) == trial_to_json(unasked)
    assert unasked.steps[1].decision.claimed is None
    assert unasked.facts["prompt_unasked"] == trial.facts["prompt_unasked"] != trial.facts["prompt"]


def test_the_instruction_leaks_nothing():
    words = ["chain", "slider", "revolute", "prismatic", "left", "right", "order", "open", *box().names]
    assert [word for word in words if word in CONSTANT.lower() + UNASKED.lower()] == []


def test_a_trial_that_outgrows_the_model_is_a_users_mistake():
    class Long(Recording):
        def tokens(self, text):
            return (text,) * 40

    with pytest.raises(BadValue, match=r"^max_steps: got 20, expected a trial that fits this model's 4096 tokens$"):
        run_trial(agent=LocalModel(Long(), {}), p=0.5)


def test_temperature_and_calibration():
    class Leaning(Recording):
        def score(self, prompt, options):
            super().score(prompt, options)
            return [0.4, 0.3, 0.2, 0.1] if len(options) == 4 else [0.5, 0.5]

    def chances(**settings):
        model = LocalModel(Leaning(), {}, LocalSettings(**settings))
        return run_trial(agent=model, max_steps=2).steps[1].decision.probabilities

    assert chances() == pytest.approx((0.4, 0.3, 0.2, 0.1))
    assert chances(temperature=0.5) == pytest.approx([share**2 / 0.3 for share in (0.4, 0.3, 0.2, 0.1)])
    assert chances(calibration="first") == pytest.approx((0.25,) * 4)
    assert chances(temperature=1e-9) == (1, 0, 0, 0)


@pytest.mark.parametrize(
    ("spec", "message"),
    [
        ("llm:local?heat=1", "no option of a local model is called 'heat'; there are: temperature, calibration"),
        ("llm:local?temperature=0", "temperature: got 0.0, expected a number above 0"),
        ("llm:gguf:a.gguf?temperature=inf", "temperature: got inf, expected a number above 0"),
        ("llm:local?temperature=warm", "temperature: got 'warm', expected a number"),
        ("llm:local?calibration=all", "calibration: got 'all', expected one of none, first"),
    ],
)
def test_bad_options_are_named(spec, message):
    with pytest.raises(UserMistake) as mistake:
        resolve(spec)
    assert str(mistake.value) == message


def test_an_instruction_of_its_own_is_refused_and_other_questions_change_nothing(model, trial, tmp_path):
    (tmp_path / "own.txt").write_text("{joints} {target} {reply}")
    with pytest.raises(BadValue, match="prompt cannot be combined with a local model"):
        run_trial(agent=model, condition=f"prompt?file={tmp_path / 'own.txt'}", max_steps=1)
    questions = "flip?p=0.4 + hypothesis?ask=off"
    asked = run_trial(agent=model, condition=questions, trial=SHORT["trial"], max_steps=SHORT["max_steps"])
    assert asked.steps == trial.steps
