"""A provider that counts what cannot be is told so, counted as the most that can be, and not asked again."""

import json

import pytest
from provider_server import counted

from lockprobe import load
from lockprobe.cli.run import run
from lockprobe.cli.status import status
from lockprobe.foundation.errors import Missing
from lockprobe.studies.costs.call_log import read_calls

SPEC = "llm:openai-api/fake/model"


@pytest.fixture
def play(tmp_path, provider, prices):
    """Plays a trial whose replies claim the usage that is given."""
    prices(3, 10)
    _, answer = provider

    def played(usage, **more):
        def claiming(request):
            status, content = counted(request)
            return status, content if usage is HONEST else content | {"usage": usage}

        answer(claiming)
        run("flips", agent=[SPEC], p=["0"], trials=1, repetitions=1, out=tmp_path / "s", connections=1, **more)

    return played


HONEST = "as a provider counts"
CLAIMED = {"prompt_tokens": 10**9, "completion_tokens": 20, "total_tokens": 10**9 + 20}


def test_a_reply_without_a_count_is_played_and_counted_at_its_worst(tmp_path, play):
    play({})
    assert [trial.ending for trial in load(tmp_path / "s")] == ["solved"]
    assert all(call.uncounted and call.most is not None for call in read_calls(tmp_path / "s"))


@pytest.mark.parametrize("budget", [None, 1.0])
def test_what_cannot_be_is_claimed_not_spent_and_the_run_stops(tmp_path, play, capsys, budget):
    with pytest.raises(Missing, match=r"its provider claims 1,000,000,000 tokens in and 20 out for a call of at most"):
        play(CLAIMED, budget=budget)
    (call,) = read_calls(tmp_path / "s")
    assert call.claimed.input_tokens == 10**9
    assert call.usage.input_tokens < 10_000
    capsys.readouterr()
    status(tmp_path / "s")
    (line,) = [line for line in capsys.readouterr().out.splitlines() if line.startswith("claimed")]
    assert line.startswith("claimed     1 call: the provider claims an impossible usage; counted above")
    status(tmp_path / "s", json=True)
    facts = json.loads(capsys.readouterr().out)
    assert facts["claimed"] == 1
    assert 0 < facts["dollars"] < 0.1
    play(HONEST, budget=budget)  # once its count is mended
    assert [trial.ending for trial in load(tmp_path / "s")] == ["solved"]
