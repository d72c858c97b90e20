"""``lockprobe serve`` and ``withdraw``, as typed."""

import signal
import subprocess
import tomllib
from dataclasses import replace

import forked
import pytest
from builders import make_trial, small_study, write_study
from seated import diary_of, people_study, short, take_part
from stored import timings
from typed import in_process

from lockprobe.cli import build
from lockprobe.cli.serve import EXAMPLES, study_and_people
from lockprobe.foundation.errors import BadFile, BadValue, Conflict, DirectoryBusy, SettingsChanged, UserMistake
from lockprobe.people.experiment import Experiment, read_experiment, read_words
from lockprobe.people.withdrawal import withdrawn
from lockprobe.studies.records.directory import read_study
from lockprobe.studies.records.journal import Journal
from lockprobe.studies.records.read_records import load

FOUR = {"condition": ["flip?p=0.4 + nudge"], "sweep": ["tremble?p=0,0.1,0.2"]}


def settings(people, own, directory):
    """How people take part in a study in this directory, by a file or as before."""
    return study_and_people("flips", {}, [str(people)] if people else [], own, directory)[2]


def test_it_says_where_it_is_and_what_is_kept(tmp_path):
    asked = ["serve", "flips", "--port", 0, "--out", tmp_path / "study"]
    process = forked.start(asked, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    try:
        said = [process.stdout.readline().rstrip() for _ in range(9)]
        assert said[0] == "flips on 8 boxes for people, 160 trials: 40 persons, 4 boxes each"
        assert "?PROLIFIC_PID={{%PROLIFIC_PID%}}&STUDY_ID={{%STUDY_ID%}}&SESSION_ID={{%SESSION_ID%}}" in said[2]
        assert "?preview=" in said[3]
        assert said[4].endswith(str(tmp_path / "study"))
        assert f"--agent participant --agent human-inspired --trials 5 --repetitions 1 --out {tmp_path}" in said[5]
        assert "names nobody as responsible" in said[6]
        assert "--join-code CODE, or require_id in people.toml" in said[7]
        port = said[1].rpartition(":")[2].rstrip("/")
        with pytest.raises(BadValue, match="port: .* in use"):
            in_process("serve", "flips", "--port", port, "--out", tmp_path / "other")
        assert said[8].endswith(f"Hash of the settings: {read_study(tmp_path / 'study').settings_hash}")
    finally:
        process.send_signal(signal.SIGINT)
        rest, errors = process.communicate(timeout=20)
    assert (process.poll(), errors) == (0, "")
    assert rest == "Stopped. The same command resumes; everybody continues where they were.\n"
    assert read_study(tmp_path / "study").agents == ("participant",)


def test_agents_of_a_file_or_of_a_directory_play_beside_people(tmp_path):
    there = write_study(tmp_path / "there", small_study(["random"]), [])
    planned, directory, _ = study_and_people(str(there), {}, [], {}, None)
    assert (planned.agents, directory) == (("random", "participant"), there)
    with pytest.raises(Conflict, match="--trials cannot be combined with the directory"):
        study_and_people(str(there), {"trials": 1}, [], {}, None)
    study = tmp_path / "mine.toml"
    study.write_text('study = "flips"\nagent = ["random"]\np = [0, 0.5]\ntrials = 4\n')
    planned, directory = study_and_people(str(study), {"seed": 9}, [], {}, None)[:2]
    assert (planned.agents, planned.p, planned.trials, planned.seed) == (("random", "participant"), (0.0, 0.5), 32, 9)
    assert directory.name == f"flips-{planned.identity}"
    assert study_and_people("flips", {}, [], {}, tmp_path)[1] == tmp_path


def test_how_people_take_part_is_asked_for_or_stays_as_it_was(tmp_path):
    people = tmp_path / "people.toml"
    people.write_text("feedback = true\ntrials_each = 3\n")
    assert settings(None, {}, tmp_path) == Experiment()
    asked = settings(people, {"trials_each": 5, "language": "en"}, tmp_path)
    assert (asked.feedback, asked.trials_each, asked.language) == (True, 5, "en")
    (tmp_path / "people").mkdir()
    (tmp_path / "people" / "experiment.json").write_text(asked.model_dump_json())
    assert settings(None, {}, tmp_path) == asked
    assert settings(None, {"trials_each": 2}, tmp_path) == asked.model_copy(update={"trials_each": 2})
    assert settings(people, {}, tmp_path) == Experiment(feedback=True, trials_each=3)
    (tmp_path / "people" / "experiment.json").write_text("{")
    with pytest.raises(BadFile, match="not JSON"):
        settings(None, {}, tmp_path)


def test_more_people_than_there_are_trials_for_are_refused_with_what_adds_trials(tmp_path):
    people = tmp_path / "people.toml"
    people.write_text("participants = 24\ntrials_each = 8\n")
    said = "participants: got 24, expected at most 10, whom 80 trials are enough for, 8 for each; --people 24 without"
    with pytest.raises(BadValue, match=said):
        study_and_people("flips", {"p": [0.0, 0.4]}, [str(people)], {}, tmp_path)
    planned = study_and_people("flips", {"p": [0.0, 0.4]}, [str(people), "24"], {}, tmp_path)[0]
    assert (planned.invited, planned.trials) == (192, 96)
    write_study(tmp_path / "study", planned, [make_trial([0, 1], agent="random")])
    with pytest.raises(BadValue, match="got 99, expected at most 96, .*, 2 for each$"):
        study_and_people(str(tmp_path / "study"), {}, ["99"], {}, None)
    with (
        pytest.raises(SettingsChanged, match="trials on each of 8 boxes is 12 there, 5 asked"),
        Journal.open(tmp_path / "study", replace(planned, trials=40)),
    ):
        pass


def test_examples_are_written_to_be_edited_and_never_over_something(tmp_path):
    texts, people = tmp_path / "texts.toml", tmp_path / "people.toml"
    said = in_process("serve", "--write-texts", texts, "--write-people", people).stdout
    assert [line.split(":")[0] for line in said.splitlines()] == ["Written", "Written"]
    assert read_words(str(texts)) == read_words("en")
    assert people.read_bytes() == EXAMPLES["en"].read_bytes()
    in_process("serve", "--write-people", tmp_path / "a.toml", "--texts", "de")
    german = read_experiment(tmp_path / "a.toml")
    assert (german.language, german.checks[0].right) == ("de", "Blau")
    for arguments, said in (
        (("--write-people", people), "is not overwritten"),
        (("--write-texts", texts), "is not overwritten"),
        (("--write-people", tmp_path / "no" / "people.toml"), "cannot be written"),
        (("--write-texts", tmp_path / "x.toml", "--texts", "xx"), "no language is called"),
    ):
        with pytest.raises(UserMistake, match=said):
            build(["serve"])(["serve", *map(str, arguments)], standalone_mode=False)


@pytest.mark.parametrize("language", EXAMPLES)
def test_the_example_has_every_setting_as_it_is_by_default(language):
    """The German one says the same in German."""
    given = tomllib.loads(EXAMPLES[language].read_text("utf-8"))
    example, default = read_experiment(EXAMPLES[language]), Experiment(language=language)
    assert all(check.after <= 1 for check in example.checks)  # where everybody plays one box, too
    named = set(given) | {"trials_each", "participants"}  # which stand there as remarks
    assert named == set(Experiment.model_fields)
    assert {name: getattr(example, name) for name in named - {"checks", "questions"}} == {
        name: getattr(default, name) for name in named - {"checks", "questions"}
    }
    assert [one.name for one in example.questions] == ["age", "strategy", "false_reports"]


@pytest.mark.parametrize(
    ("what", "people", "asked", "found"),
    [
        ("flips", 40, {}, (4, 40, 1)),
        ("flips", 40, {"p": [0.0, 0.4], "repetitions": 3}, (2, 16, 3)),
        ("flips", 12, FOUR, (4, 16, 1)),
        ("flips", 2, {**FOUR, "box": "chain-4"}, (4, 4, 1)),
        ("flips", 12, {**FOUR, "p": [0.0, 0.4]}, (5, 16, 1)),
        ("mine.toml", 12, {}, (2, 16, 1)),
        ("why", 12, {}, (7, 16, 1)),
    ],
)
def test_a_number_of_people_is_enough_for_every_condition_and_the_same_command_goes_on(
    tmp_path, monkeypatch, what, people, asked, found
):
    monkeypatch.chdir(tmp_path)
    conditions = '[[condition]]\nname = "plain"\nspec = "truth"\n[[condition]]\nspec = "flip?p=0.4 + nudge"\n'
    (tmp_path / "mine.toml").write_text(f'study = "flips"\n{conditions}')
    planned, directory, experiment = study_and_people(what, asked, [str(people)], {}, None)
    assert (len(planned.conditions), planned.trials, planned.repetitions) == found
    assert experiment.participants == people
    assert study_and_people(what, asked, [str(people)], {}, None)[1] == directory


TAKEN_BACK = people_study(p=(0.0,), plant="fast-twin?width=64&height=64", modalities=("rgb",), max_steps=2)


def withdraw(directory, participant):
    build(["withdraw"])(["withdraw", str(directory), participant], standalone_mode=False)


def test_no_byte_of_a_participant_stays(tmp_path):
    (stays,) = take_part(tmp_path, TAKEN_BACK, short(), "random", platform={"PROLIFIC_PID": "pid76"})
    kept = {path.name for path in (tmp_path / "pictures").iterdir()}
    (leaves,) = take_part(tmp_path, TAKEN_BACK, short(), "random", platform={"PROLIFIC_PID": "pid77"})
    assert "\n            boxes given: 2 under rgb\n" in in_process("status", tmp_path).stdout
    with Journal.open(tmp_path, TAKEN_BACK), pytest.raises(DirectoryBusy, match="with Ctrl-C$"):
        withdraw(tmp_path, "pid77")  # a server runs
    with pytest.raises(BadValue, match="the ID of one participant"):
        withdraw(tmp_path, "nobody")
    token = diary_of(tmp_path, leaves.participant)[0].token
    withdraw(tmp_path, "pid77")
    for path in (path for path in tmp_path.rglob("*") if path.is_file()):
        assert leaves.participant not in path.name
        assert not any(word.encode() in path.read_bytes() for word in (leaves.participant, token, "pid77"))
    assert {path.name for path in (tmp_path / "pictures").iterdir()} == kept
    assert [trial.agent for trial in load(tmp_path)] == [f"participant:{stays.participant}"]
    assert timings(tmp_path, "key") == [trial.key for trial in load(tmp_path)]
    withdraw(tmp_path, stays.participant)
    assert (load(tmp_path), list((tmp_path / "pictures").iterdir()), withdrawn(tmp_path)) == ([], [], 2)
