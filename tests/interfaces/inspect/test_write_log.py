"""Exported trials are an Inspect log like that of an eval, and come back as they were."""

import hashlib
import statistics

import pytest
from builders import SOLUTION, make_trial, play_study, small_study
from inspected import IN_EVALS, evaluated
from provider_server import completion, truthful, words

from lockprobe.foundation.errors import BadFile, BadValue

writing = pytest.importorskip("lockprobe.interfaces.inspect.write_log")

from inspect_ai.log import read_eval_log  # noqa: E402

from lockprobe.interfaces.inspect.read_log import read_log, trials_in  # noqa: E402

STUDY = small_study()


@pytest.fixture(scope="module")
def trials():
    return play_study(STUDY)


@pytest.mark.parametrize("name", ["all.eval", "all.json"])
def test_trials_come_back_as_they_were(tmp_path, trials, name):
    seconds = {trials[0].key: 1.5}
    assert writing.write_logs(trials, STUDY, tmp_path / name, seconds=seconds) == [tmp_path / name]
    source = read_log(tmp_path / name)
    assert list(source.trials) == trials
    assert (source.study, source.unfinished, source.seconds) == (STUDY, frozenset(), seconds)


def test_a_directory_gets_one_log_of_each_agent(tmp_path, trials):
    files = writing.write_logs(trials, STUDY, tmp_path / "logs")
    assert [file.name for file in files] == ["flips_random.eval", "flips_human-inspired.eval"]
    logs = [read_eval_log(str(file)) for file in files]
    assert [log.eval.model for log in logs] == ["random", "human-inspired"]
    assert "flip?p=0.3/rep=2/trial=4" in {sample.id for sample in logs[0].samples}
    assert {trial.key: trial for trial in trials_in(tmp_path / "logs")} == {trial.key: trial for trial in trials}


def test_metrics_are_means_over_trials_and_over_those_of_a_condition(trials):
    of_one = [trial for trial in trials if trial.agent == "random"]
    results = writing.log_of(of_one, STUDY).results
    (success,) = (score for score in results.scores if score.name == "success")
    assert success.metrics["mean"].value == statistics.mean(trial.solved for trial in of_one)
    for condition in STUDY.conditions:
        share = statistics.mean(trial.solved for trial in of_one if trial.condition == condition.label)
        assert success.metrics[f"grouped_{condition.label}"].value == share
    sums = [sum(t.solved - success.metrics["mean"].value for t in of_one if t.repetition == r) for r in (1, 2)]
    assert success.metrics["stderr"].value == pytest.approx((2 * sum(s**2 for s in sums)) ** 0.5 / len(of_one))


def test_an_error_is_never_counted_as_a_failure_to_solve():
    trials = [make_trial(SOLUTION), make_trial([0, 0], trial=2, broken="reply"), make_trial([0], trial=3, budget=1)]
    (success, *_) = writing.log_of(trials, small_study(["random"], p=[0.0], repetitions=1)).results.scores
    assert (success.metrics["mean"].value, success.scored_samples, success.unscored_samples) == (0.5, 2, 1)


def test_every_message_is_told_apart(trials):
    log = writing.log_of(trials, STUDY)
    ids = [message.id for sample in log.samples for message in sample.messages]
    assert len(set(ids)) == len(ids)
    for sample, trial in zip(log.samples, trials, strict=True):
        calls = [event for event in sample.events if event.event == "model"]
        assert len(calls) == len(trial.steps)
        said = [message.id for message in sample.messages]
        asked = [[message.id for message in (*call.input, call.output.message)] for call in calls]
        assert asked == [said[: 2 * step.step] for step in trial.steps]


def stumbling(request):
    """Replies in turn, and once in a while, by what was told, with something else first."""
    told = words(request["messages"][-1])
    if told.startswith("You attempted A"):
        return completion("no idea")
    shorter = request["messages"][:-2] if told.startswith("That reply") else request["messages"]
    return truthful({**request, "messages": shorter})


@IN_EVALS
@pytest.mark.parametrize("ending", [".eval", ".json"])
def test_a_call_holds_the_whole_conversation_that_was_sent(tmp_path, monkeypatch, ending):
    from lockprobe.interfaces.inspect.tasks import flips

    played, server = evaluated(tmp_path, monkeypatch, flips(p=0.3, trials=3, repetitions=1), stumbling)
    source = read_log(played.location)
    (path,) = writing.write_logs(source.trials, source.study, tmp_path / f"out{ending}")
    exported = read_eval_log(str(path), resolve_attachments=True)
    calls = [event for sample in exported.samples for event in sample.events if event.event == "model"]
    told = sorted([(m.role, m.text) for m in call.input] for call in calls)
    assert told == sorted([(m["role"], words(m)) for m in request["messages"]] for request in server.requests)
    assert any(len(step.decision.replies) == 2 for trial in source.trials for step in trial.steps)


def test_the_same_trials_have_the_same_names(trials):
    first, again = (writing.log_of(trials, STUDY).eval for _ in range(2))
    assert (first.eval_id, first.task_id, first.run_id) == (again.eval_id, again.task_id, again.run_id)


def test_nothing_to_write_and_nowhere_to_write_are_said(tmp_path, trials):
    with pytest.raises(BadValue, match="at least one"):
        writing.write_logs([], STUDY, tmp_path / "x.eval")
    (tmp_path / "file").write_text("")
    with pytest.raises(BadFile, match="cannot be written"):
        writing.write_logs(trials, STUDY, tmp_path / "file" / "x.eval")


def test_pictures_come_back_those_that_nobody_was_shown_too(tmp_path):
    from lockprobe.trial.pictures.picture import Picture

    files = [Picture(kind="rgb", png=bytes([i]) * 50) for i in range(4)]
    for file in files:
        (tmp_path / file.name).write_bytes(file.png)
    names = [{"rgb": files[0].name, "depth16": files[1].name}, {"rgb": files[2].name, "depth16": files[3].name}]
    trial = make_trial([0], agent="viewer", budget=1, modality="rgbd", pictures=names)
    writing.write_logs([trial], small_study(["viewer"]), tmp_path / "x.eval", pictures=tmp_path)
    source = read_log(tmp_path / "x.eval")
    assert {file.name: source.picture(file.name) for file in files} == {file.name: file.png for file in files}


@pytest.mark.parametrize("ending", [".eval", ".json"])
def test_a_picture_takes_room_once_however_many_calls_show_it(tmp_path, ending):
    from lockprobe.trial.pictures.picture import Picture

    files = [Picture(kind="rgb", png=hashlib.shake_256(bytes([i])).digest(9000)) for i in range(13)]
    for file in files:
        (tmp_path / file.name).write_bytes(file.png)
    trial = make_trial([0] * 12, agent="viewer", budget=12, modality="rgb", pictures=[{"rgb": f.name} for f in files])
    (path,) = writing.write_logs([trial], small_study(["viewer"]), tmp_path / f"x{ending}", pictures=tmp_path)
    assert path.stat().st_size < 2 * sum(len(file.png) for file in files)
