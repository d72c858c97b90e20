"""Logs are data from anyone: what is damaged, foreign, impossible or too large is refused in one line."""

import json
import os
import zipfile

import pytest
from builders import SOLUTION, make_trial, small_study

from lockprobe.foundation.errors import BadFile

reading = pytest.importorskip("lockprobe.interfaces.inspect.read_log")

from inspect_ai.log import read_eval_log, write_eval_log  # noqa: E402

from lockprobe.interfaces.inspect.scoring import SCORER, TRIAL  # noqa: E402
from lockprobe.interfaces.inspect.write_log import write_logs  # noqa: E402

STUDY = small_study(["random"], p=[0.0], repetitions=1)
TRIALS = [make_trial(SOLUTION), make_trial([0] * 20, trial=2)]


@pytest.fixture
def log(tmp_path):
    (path,) = write_logs(TRIALS, STUDY, tmp_path / "good.eval")
    return path


def changed(path, change):
    """The same log with something done to it."""
    log = read_eval_log(str(path))
    change(log)
    other = path.with_name("other.eval")
    write_eval_log(log, str(other))
    return other


def test_an_impossible_record_is_refused(log):
    def lie(log):
        metadata = log.samples[0].scores[SCORER].metadata
        metadata[TRIAL] = metadata[TRIAL].replace('"ending":"solved"', '"ending":"budget"')

    with pytest.raises(BadFile, match="ending"):
        reading.read_log(changed(log, lie))


def test_a_sample_without_a_record_is_not_finished(log):
    def forget(log):
        log.samples[0].scores = None

    source = reading.read_log(changed(log, forget))
    assert source.unfinished == {TRIALS[0].key}
    assert list(source.trials) == TRIALS[1:]


def test_settings_that_are_none_are_refused(log):
    def spoil(log):
        log.eval.metadata["lockprobe"]["p"] = [7]

    with pytest.raises(BadFile, match="p"):
        reading.read_log(changed(log, spoil))


def test_a_log_of_something_else_is_refused(log):
    def empty(log):
        log.eval.metadata = {}

    with pytest.raises(BadFile, match="without trials of Lockprobe"):
        reading.read_log(changed(log, empty))


@pytest.mark.parametrize("content", [b"", b"PK\x03\x04 no zip", b"{}", b"[" * 100_000, b'{"version": 2, "eval": 1}'])
@pytest.mark.parametrize("name", ["x.eval", "x.json", "x.txt"])
def test_what_is_no_log_is_refused(tmp_path, content, name):
    path = tmp_path / name
    path.write_bytes(content)
    with pytest.raises(BadFile, match=name):
        reading.read_log(path)


def test_a_cut_log_is_refused(log):
    log.write_bytes(log.read_bytes()[:-200])
    with pytest.raises(BadFile):
        reading.read_log(log)


def test_a_log_that_unpacks_to_too_much_is_not_read(log, monkeypatch):
    monkeypatch.setattr(reading, "LARGEST", 1000)
    with pytest.raises(BadFile, match="at most 1000"):
        reading.read_log(log)


def repacked(path, change):
    """The same log with some of its files replaced: name -> content, or None to leave it out."""
    other = path.with_name("repacked.eval")
    with zipfile.ZipFile(path) as packed, zipfile.ZipFile(other, "w", zipfile.ZIP_DEFLATED) as out:
        for name in packed.namelist():
            if (content := change(name, packed.read(name))) is not None:
                out.writestr(name, content)
    return other


def test_a_sample_that_is_nested_without_end_is_refused_and_not_waited_for(log):
    other = repacked(log, lambda name, content: b"[" * 100_000 if name.startswith("samples/") else content)
    with pytest.raises(BadFile, match="recursion"):
        reading.read_log(other)


def test_a_sample_that_unpacks_to_too_much_is_not_read(log, monkeypatch):
    largest = max(info.file_size for info in zipfile.ZipFile(log).infolist())
    monkeypatch.setattr(reading, "LARGEST_MEMBER", largest)
    assert reading.read_log(log).trials
    monkeypatch.setattr(reading, "LARGEST_MEMBER", largest - 1)
    with pytest.raises(BadFile, match=f"at most {largest - 1} bytes"):
        reading.read_log(log)


def test_a_log_without_the_samples_that_it_lists_is_refused(log):
    other = repacked(log, lambda name, content: None if name.startswith("samples/") else content)
    with pytest.raises(BadFile, match="samples: got 0, expected the 2"):
        reading.read_log(other)


def test_a_log_that_was_broken_off_before_its_first_sample_has_none(log):
    def fail(log):
        log.status = "error"

    other = repacked(changed(log, fail), lambda name, content: None if name.startswith("samples/") else content)
    source = reading.read_log(other)
    assert (source.trials, source.unfinished) == ((), frozenset())


def test_a_log_that_lists_more_than_can_be_looked_for_is_refused(log):
    def repeat(log):
        log.eval.config.epochs = 10**9

    with pytest.raises(BadFile, match="samples listed: got 2000000000"):
        reading.read_log(changed(log, repeat))


def test_a_record_under_the_name_of_another_trial_is_refused(log):
    def swap(log):
        first, second = (sample.scores for sample in log.samples)
        log.samples[0].scores, log.samples[1].scores = second, first

    with pytest.raises(BadFile, match=r"its sample truth/rep=1/trial=\d, epoch 1, holds the record of"):
        reading.read_log(changed(log, swap))


def test_a_directory_is_read_with_those_below_it_and_each_trial_once(log):
    below = log.parent / "below"
    write_logs(TRIALS[:1], STUDY, below / "again.eval")
    assert reading.log_files(log.parent) == [below / "again.eval", log]
    assert sorted(trial.key for trial in reading.trials_in(log.parent)) == [trial.key for trial in TRIALS]


def test_a_flipped_bit_is_one_line(log):
    whole = log.read_bytes()
    with zipfile.ZipFile(log) as packed:
        members = [member for member in packed.infolist() if member.filename.startswith("samples/")]
    begins = members[0].header_offset + 30 + len(members[0].filename)
    refused = 0
    for at in range(begins, begins + members[0].compress_size, members[0].compress_size // 20):
        log.write_bytes(whole[:at] + bytes([whole[at] ^ 16]) + whole[at + 1 :])
        try:
            reading.read_log(log)
        except BadFile as error:
            refused += "\n" not in str(error)
    assert refused >= 15


def test_devices_and_pipes_are_refused(tmp_path):
    os.mkfifo(tmp_path / "x.eval")
    for path, kind in ((tmp_path / "x.eval", "a pipe"), ("/dev/zero", "a device")):
        with pytest.raises(BadFile, match=f"{kind}, not a regular file"):
            reading.read_log(path)


@pytest.mark.parametrize(
    ("place", "value"),
    [
        (["eval", "sandbox"], ["docker"]),
        (["eval", "sandbox"], []),
        (["results"], {"scorer": None, "metrics": None}),
        (["results"], {"scorer": "match", "metrics": []}),
        (["samples"], [None]),
        (["samples", 0, "sandbox"], ["docker"]),
        (["samples", 0, "messages"], [None]),
        (["samples", 0, "transcript"], [1]),
        (["plan"], {"steps": None}),
        (["error"], "it broke"),
        (["version"], None),
        (["status"], None),
    ],
)
def test_a_json_log_of_any_version_is_read_or_refused_in_one_line(log, place, value):
    whole = read_eval_log(str(log))
    path = log.with_suffix(".json")
    write_eval_log(whole, str(path))
    content = json.loads(path.read_text("utf-8"))
    inside = content
    for key in place[:-1]:
        inside = inside[key]
    inside[place[-1]] = value
    path.write_text(json.dumps(content), "utf-8")
    try:
        assert len(reading.read_log(path).trials) <= len(TRIALS)
    except BadFile as refused:
        said = str(refused)
        assert said.startswith(f"{path}: "), said
