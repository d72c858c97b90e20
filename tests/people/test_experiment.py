"""The settings of an experiment are read back from where they are kept."""

import pytest
from pydantic import ValidationError

from lockprobe.foundation.errors import BadFile
from lockprobe.people.experiment import EXPERIMENT, Experiment, kept_experiment


def keep(directory, text):
    (directory / "people").mkdir()
    (directory / "people" / EXPERIMENT).write_text(text)


def test_what_is_kept_reads_back_and_where_nothing_is_kept_there_are_none(tmp_path):
    assert kept_experiment(tmp_path) is None
    settings = Experiment(feedback=True, trials_each=3)
    keep(tmp_path, settings.model_dump_json())
    assert kept_experiment(tmp_path) == settings


@pytest.mark.parametrize(
    "question",
    [
        {"low": 3},
        {"type": "integer", "options": ["a", "b"]},
        {"type": "number", "low": 3, "high": 2},
        {"type": "age"},
    ],
)
def test_a_question_that_nobody_could_answer_is_refused(tmp_path, question):
    with pytest.raises(ValidationError):
        Experiment.model_validate({"questions": [{"name": "age", "question": "Age?", **question}]})


def test_an_id_is_required_only_where_one_is_kept():
    with pytest.raises(ValidationError, match="require_id"):
        Experiment(require_id=True, recruitment=())


@pytest.mark.parametrize("text", ["{", "[]", '{"design": "film"}', "[" * 100_000])
def test_settings_that_are_none_are_refused(tmp_path, text):
    keep(tmp_path, text)
    with pytest.raises(BadFile):
        kept_experiment(tmp_path)
