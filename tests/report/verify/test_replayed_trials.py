"""Local models draw again from their recorded probabilities; nothing of another package runs to check its trials."""

import json
import shutil

import pytest
from builders import write_study
from saboteur import Evidence, lines, relabelled, write

from lockprobe import run_study, study
from lockprobe.agents.llm.settings import read_settings
from lockprobe.agents.local import LocalModel
from lockprobe.report.verify.replayed_trials import kind_of
from lockprobe.report.verify.verification import verify
from lockprobe.studies.branch import FORKS, branching, play_forks
from lockprobe.studies.next_choice import write_choices
from lockprobe.studies.records.journal import Journal
from lockprobe.studies.records.read_records import load
from lockprobe.studies.running.trial_setup import play_timed
from lockprobe.trial.trial_name import ForkName, TrialName

LOCAL = "llm:local"


class Engine:
    """A model whose probabilities are those of the lengths of what it reads."""

    def restart(self, constant):
        pass

    def opening(self, constant):
        return [len(constant)]

    def tokens(self, text):
        return [len(text), sum(map(ord, text))]

    def score(self, prompt, candidates):
        raw = [1 + (sum(prompt) * (i + 1) + sum(one)) % 7 for i, one in enumerate(candidates)]
        return [one / sum(raw) for one in raw]


@pytest.fixture(scope="module")
def played(tmp_path_factory):
    import asyncio

    planned = study("flips", agent=[LOCAL], p=[0, 0.4], trials=3, repetitions=1, max_steps=6)
    trials = [
        asyncio.run(play_timed(plan, LocalModel(Engine(), {"model": "x"}, temperature=0.7)))[0]
        for plan in planned.plans(LOCAL)
    ]
    return write_study(tmp_path_factory.mktemp("local") / "out", planned, trials)


@pytest.fixture
def local(played, tmp_path):
    return shutil.copytree(played, tmp_path / "out")


def failing(directory):
    return {check.name: check.failed for check in verify(directory) if not check.holds}


def test_a_study_of_a_local_model_holds_without_its_weights(local):
    assert failing(local) == {}
    (said,) = [check.said for check in verify(local) if check.name == "choices"]
    assert said.endswith("; those of 6 trials of local models follow from their recorded probabilities")


def flipped(step):
    step["decision"]["claimed"] = {"moved": "blocked", "blocked": "moved"}[step["decision"]["claimed"]]


def reworded(step):
    step["decision"]["replies"] = ["Next joint: A"]


def surer(step):
    step["decision"]["claim_probability"] = 1 - step["decision"]["claim_probability"]


def unlikely(step):
    step["decision"]["probabilities"] = step["decision"]["probabilities"][::-1]


@pytest.mark.parametrize("change", [flipped, reworded, surer, unlikely])
def test_a_decision_that_its_probabilities_do_not_give_is_found(local, change):
    files = Evidence(local)
    for record in files.records:
        for step in record["steps"][1:]:
            change(step)
    files.save()
    assert "choices" in failing(local)


def test_a_failure_relabelled_as_an_error_is_found(local):
    files = Evidence(local)
    failures = files.of(LOCAL, "budget")
    for record in failures:
        relabelled(record, steps=3)
    files.save()
    assert len(failing(local)["choices"]) == len(failures) > 0


@pytest.mark.parametrize(
    ("spec", "kind"),
    [
        ("random", "strategy"),
        ("llm:local?temperature=2", "local"),
        ("llm:gguf:/x/y.gguf", "local"),
        ("llm:openai/gpt-4o", "hosted"),
        ("participant:ab12", "outside"),
        ("mcp:codex", "outside"),
        ("python:a:B", "own"),
    ],
)
def test_the_kind_of_an_agent_is_known_by_its_spec(spec, kind):
    assert kind_of(spec) == kind
    assert kind != "hosted" or read_settings(spec)


@pytest.fixture(scope="module")
def forked(tmp_path_factory):
    directory = tmp_path_factory.mktemp("forked") / "out"
    planned = study("flips", agent=["random", "cognitive:careful"], p=[0, 0.4], trials=3, repetitions=1, max_steps=8)
    run_study(planned, directory)
    asked = branching(planned, load(directory), at=["2"], told=["truth", "lie"], times=2)
    with Journal.open(directory / FORKS, planned) as journal:
        play_forks(asked, journal)
    write_choices(directory, asked, {fork.key for fork in load(directory / FORKS)})
    return directory


@pytest.fixture
def with_forks(forked, tmp_path):
    return shutil.copytree(forked, tmp_path / "out")


def edited(directory, change):
    files = Evidence(directory / FORKS)
    change(files)
    files.save()
    return failing(directory)


def test_forks_hold_as_they_were_played(with_forks):
    assert failing(with_forks) == {}


def told_otherwise(files):
    files.records[0]["steps"][3]["told"] = "Nothing."


def chosen_otherwise(files):
    files.records[0]["steps"][3]["decision"]["hypothesis"] = "made up"


def renamed(record, arm, **place):
    """Make a record of a fork one of another arm or of another trial, with the key that it then has."""
    name = TrialName(
        study=record["study"],
        agent=record["agent"],
        condition=record["condition"],
        repetition=record["repetition"],
        trial=place.get("trial", record["trial"]),
    )
    record |= place
    record["fork"] |= {"parent": str(name), "arm": arm}
    record["key"] = str(ForkName(**record["fork"]))


def of_no_trial(files):
    renamed(files.records[0], files.records[0]["fork"]["arm"], trial=9)


def another_arm(files):
    for record in files.records:
        renamed(record, {"truth": "lie", "lie": "truth"}[record["fork"]["arm"]])


def an_arm_that_is_not_there(files):
    renamed(files.records[0], {"truth": "force=nothing", "lie": "hint"}[files.records[0]["fork"]["arm"]])


def another_key(files):
    files.records[0]["key"] = files.records[0]["key"].replace("trial=1", "trial=9")


def test_a_fork_whose_key_is_not_that_of_its_fields_is_no_record(with_forks):
    edit = Evidence(with_forks / FORKS)
    another_key(edit)
    edit.save()
    (check,) = verify(with_forks)
    assert (check.name, check.holds) == ("records", False)
    assert "line 1: trial record, key: got " in check.said


@pytest.mark.parametrize(
    "change", [told_otherwise, chosen_otherwise, of_no_trial, another_arm, an_arm_that_is_not_there]
)
def test_an_edited_fork_is_found(with_forks, change):
    assert "forks" in edited(with_forks, change)


def test_an_edited_next_choice_is_found(with_forks):
    path = with_forks / FORKS / "next_choices.json"
    choices = json.loads(path.read_text("utf-8"))
    key = next(iter(choices))
    path.write_text(json.dumps(choices | {key: [1.0, 0.0, 0.0, 0.0]}), "utf-8")
    assert failing(with_forks)["forks"] == (f"{key}: another next choice than its strategy has",)


def test_a_plant_and_an_intervention_of_the_directory_run_nothing(with_forks, tmp_path, monkeypatch):
    shutil.rmtree(with_forks / FORKS)
    (tmp_path / "stranger.py").write_text("raise SystemExit('this ran')\n")
    monkeypatch.chdir(tmp_path)
    files = Evidence(with_forks)
    files.settings["plant"] = "python:stranger:Plant"
    files.save()
    (luck,) = [check.said for check in verify(with_forks) if check.name == "luck"]
    assert "more need a plant or an intervention that does not ship, or a real box, and are not played" in luck


def test_lines_without_checksums_are_found_in_every_log(with_forks):
    path = with_forks / FORKS / "trials.jsonl"
    write(path, lines(path), checksums=False)
    (check,) = verify(with_forks)
    assert (check.name, check.holds) == ("records", False)
    assert check.said.startswith(f"{path}: line 1: checksum: got 'none'")
