"""``lockprobe fit``, as typed."""

import json

import pytest
from builders import small_study, write_study
from typed import typed

from lockprobe.studies.options.studyfile import study as make_study

QUICK = ("--models", "no-repeat,human-inspired,softmax-memory", "--folds", "4")


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    return write_study(tmp_path_factory.mktemp("study"), small_study(p=(0.0, 0.4), trials=6))


def test_the_sentence_comes_first_then_the_table_within_100_columns(study):
    done = typed("fit", study, "--agent", "human-inspired", *QUICK)
    assert done.returncode == 0, done.stderr
    assert all(line.startswith("fitting human-inspired: ") for line in done.stderr.splitlines())
    lines = done.stdout.splitlines()
    assert max(map(len, lines)) <= 100
    said = " ".join(done.stdout.split())
    assert "human-inspired is best described by human-inspired:target-first" in said
    assert said.index("is best described by") < said.index("log-lik.") < said.index("with 95 % intervals")
    assert "target-first, best of 6" in said
    assert "--agent 'human-inspired:target-first?lapse=0'" in said
    assert "Models are compared only with each other" in said
    assert "-0.00" not in said
    assert "\x1b" not in done.stdout


def test_json_holds_every_number(study, tmp_path):
    path = tmp_path / "fit.json"
    done = typed("fit", study, *QUICK, "--by-condition", "--json", "--out", path)
    assert (done.returncode, done.stdout) == (0, "")
    found = json.loads(path.read_text("utf-8"))
    assert (found["schema"], found["folds"]) == (1, 4)
    assert [(one["agent"], one["conditions"]) for one in found["agents"]] == [
        (agent, [label]) for agent in ("human-inspired", "random") for label in ("truth", "flip?p=0.4")
    ]
    assert found["unpredicted"] == {}
    for one in found["agents"]:
        rivals = {rival["model"]: rival for rival in one["rivals"]}
        assert set(rivals) == {"random", "no-repeat", "human-inspired", "softmax-memory"}
        assert one["finding"]
        assert one["described"] in (None, one["rivals"][0]["model"])
        assert (one["described"] is not None) == ("is best described by" in one["finding"])
        assert rivals["human-inspired"]["versions"] == 6  # the nearest joint is known, for the box is
        assert len(rivals["softmax-memory"]["parameters"]) == 8
        assert set(rivals["no-repeat"]["parameters"][0]) == {"name", "value", "low", "high", "at_bound"}


def test_no_parameters_are_given_of_a_model_that_is_not_shown_to_predict(tmp_path):
    """With one cluster of trials there are no others to predict: the best has a parameter, and it describes nothing."""
    single = write_study(tmp_path / "study", small_study(("human-inspired",), p=(0.0,), repetitions=1, trials=1))
    done = typed("fit", single, *QUICK)
    assert done.returncode == 0, done.stderr
    assert "No gain over chance in predicting" in done.stdout
    assert "with 95 % intervals" not in done.stdout
    assert "To play it" not in done.stdout


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--agent", "gpt"), "no agent in these trials is called 'gpt'; there are: human-inspired, random"),
        (("--models", "markov,random"), "no model is called 'markov'; there are: random, favourite-places"),
        (("--condition", "nudge"), "no condition of these trials is called 'nudge'; there are: truth, flip?p=0.4"),
        (("--folds", "1"), "folds: got 1"),
        (("--out", "DIR/trials.jsonl"), "belongs to the study"),
        (("--models", "random", "--agent", "random", "--out", "DIR/no/fit.txt"), "cannot be written"),
    ],
)
def test_mistakes_are_one_line(study, lockprobe, arguments, message):
    status, said, mistake = lockprobe("fit", study, *(argument.replace("DIR", str(study)) for argument in arguments))
    assert (status, said) == (2, "")
    assert message in mistake
    assert mistake.count("\n") == 1


def test_a_directory_without_trials_is_named(tmp_path, lockprobe):
    assert "is it the directory of a study?" in lockprobe("fit", tmp_path)[2]


def test_every_condition_is_fitted_and_one_without_a_prediction_is_named(tmp_path):
    """A study without a single flip: chosen and attempted joints differ, and reports are missing or forgotten."""
    acting = ["nudge", "tremble?p=0.3", "drop?p=0.3", "history?last=2"]
    asked = {"agent": "random", "p": [0], "condition": acting, "trials": 3, "repetitions": 1, "strategy_trials": 3}
    directory = write_study(tmp_path / "study", make_study("flips", **asked))
    done = typed("fit", directory, "--models", "no-repeat", "--folds", 2)
    assert done.returncode == 0
    assert "12 trials" in done.stdout
    assert "Under truth; nudge; tremble?p=0.3; drop?p=0.3\n" in done.stdout
    assert done.stderr == (
        "history?last=2 is left out: history takes reports from the agent, and the record does not hold which it still "
        "has.\n"
    )
    alone = typed("fit", directory, "--models", "no-repeat", "--folds", 2, "--condition", "tremble?p=0.3")
    assert "3 trials" in alone.stdout
    assert "Under tremble?p=0.3\n" in alone.stdout
    assert alone.stderr == ""
