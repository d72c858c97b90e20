"""Models with made-up prices, and calls and usage of theirs."""

from functools import cache

import pytest

from lockprobe.agents.llm.model_facts import OWN_FACTS
from lockprobe.studies.options.study_options import StudyOptions
from lockprobe.studies.options.studyfile import study
from lockprobe.trial.model_call import Call, Usage
from lockprobe.trial.record import TrialName

PRICES = """
[[model]]
match = ["fake/dear*"]
price = { input = 3, cached = 1, stored = 4, output = 10, date = "2026-01-02", source = "made up" }
[[model]]
match = ["fake/cheap"]
price = { input = 0.5, cached = 0.5, output = 1, date = "2026-01-03", source = "made up" }
"""
DEAR, CHEAP, FREE = "llm:fake/dear", "llm:fake/cheap", "llm:fake/unheard"


@pytest.fixture(autouse=True, scope="module")
def prices(tmp_path_factory):
    path = tmp_path_factory.mktemp("prices") / "models.toml"
    path.write_text(PRICES)
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(OWN_FACTS, str(path))
        yield


def planned(*agents):
    return study(StudyOptions(agent=list(agents), trials=9, p=[0], repetitions=1))


@cache
def _plans(agent):
    return list(planned(agent).plans(agent))


def plan(agent=DEAR, trial=1):
    """The plan of the trial of a call."""
    return _plans(agent)[trial - 1]


def call(agent=DEAR, trial=1, step=1, reply="said", **more):
    place = {"agent": agent, "condition": "truth", "repetition": 1, "trial": trial}
    key = str(TrialName(study="flips", **place))
    return Call(key=key, **place, step=step, turn=more.pop("turn", 1), request="r", reply=reply, **more)


def usage(read=0, wrote=0, cached=0, stored=0):
    return Usage(calls=1, input_tokens=read, output_tokens=wrote, cached_tokens=cached, stored_tokens=stored)
