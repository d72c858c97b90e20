"""A trial again, in words or as a film."""

import re
from functools import partial

import pytest
from builders import make_trial, small_study, write_study
from painted import painted_twins
from PIL import Image
from saboteur import Evidence
from typed import in_process

KEY = "flips/human-inspired/truth/rep=1/trial=1"


@pytest.fixture(autouse=True)
def made(monkeypatch):
    monkeypatch.setattr("lockprobe_robot.film.make.STAND_IN", "fast-twin")
    return painted_twins(monkeypatch)


@pytest.fixture
def directory(tmp_path):
    return write_study(tmp_path / "study", small_study(p=(0.0,), repetitions=1, trials=1))


replay = partial(in_process, "replay")


def test_without_a_film_it_is_told_in_words(directory, made):
    assert replay(directory, KEY).stdout.startswith(f"{KEY}: solved after ")
    assert made == []


@pytest.fixture
def shown(tmp_path, monkeypatch):
    """From a trial to the lines of its replay."""

    def show(trial, *more):
        monkeypatch.setattr("lockprobe.cli.replay.load", lambda directory: [trial])
        return replay(tmp_path, trial.key, *more).stdout.splitlines()

    return show


def test_what_arm_and_camera_took_for_another_outcome_stands_in_the_row_with_the_reason_of_a_false_report(shown):
    told = {"modality": "symbolic?source=verdict", "verdicts": ["blocked", "failed", "blocked"], "budget": 3}
    trial = make_trial([3, 0, 0], false_at=[1, 3], readings=["0000", "0001", "?001", "0001"], **told)
    first, second, third = (line[45:].strip() for line in shown(trial)[2:])
    assert re.fullmatch(r"did not move <- false +the verdict is wrong  \(verdict: did not move\)", first)
    assert re.fullmatch(r"did not move +\(verdict: failed, camera: unclear\)", second)
    assert third == "moved        <- false"


def test_a_film_of_a_symbolic_trial_says_what_it_is_made_of(directory, tmp_path):
    done = replay(directory, KEY, "--out", tmp_path / "a.gif")
    said = done.stderr.splitlines()[-1]  # on a busy machine lines of progress come before
    assert said == "The plant symbolic cannot be filmed: the film shows fast-twin in its place."
    with Image.open(tmp_path / "a.gif") as gif:
        steps = (gif.n_frames - 1) // 2
    size = (tmp_path / "a.gif").stat().st_size
    assert done.stdout == (
        f"Film: {tmp_path / 'a.gif'} ({1 + 2 * steps} pictures, {size / 1e3:.0f} kB, every one of {steps} steps as recorded)\n"
    )


def test_a_record_that_is_not_what_happens_is_found_out(directory, tmp_path):
    files = Evidence(directory)
    record = files.records[-1]
    at = next(at for at, step in enumerate(record["steps"]) if step["joint"] != record["target"])
    record["steps"][at]["moved"] = not record["steps"][at]["moved"]
    files.save()
    done = replay(directory, record["key"], "--out", tmp_path / "a.gif")
    assert f"lockprobe: step {at + 1} differs from the record: outcome " in done.stderr
    assert "as recorded" not in done.stdout
