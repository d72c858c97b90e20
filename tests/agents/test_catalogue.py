"""Specs and what they name."""

import pytest

from lockprobe.agents.catalogue import KNOWN, description, is_strategy, resolve
from lockprobe.foundation.errors import BadValue, UnknownName, UserMistake
from lockprobe.foundation.plugins import allow


@pytest.mark.parametrize(
    ("spec", "engine", "sees"),
    [
        *((spec, "inline", False) for spec in ("random", "right-to-left", "human-inspired:target-first", "ideal-observer", "cognitive:careful")),
        *((spec, "inline", True) for spec in ("viewer", "viewer:random?acuity=9", "python:any:Thing")),
        ("participant", "person", True),
        ("participant:3f9a01bc", "person", True),
        ("mcp:claude-code", "client", True),
        ("llm:local", "process", False),
        ("llm:gguf:some.gguf", "process", False),
        ("llm:openai/gpt-4o?images=4", "network", True),
        ("llm:openai/o3-mini", "network", False),
    ],
)  # fmt: skip
def test_a_spec_says_where_its_time_goes_and_what_it_can_take_in(spec, engine, sees):
    source = resolve(spec)
    assert (source.engine, source.sees) == (engine, sees)
    assert is_strategy(spec) == (engine == "inline" and "python" not in spec)
    if is_strategy(spec):
        source.check()


NAMED = "a name without control characters"


@pytest.mark.parametrize(
    ("spec", "kind", "message"),
    [
        ("randon", UnknownName, "no agent is called 'randon' (did you mean 'random'?); there are: random, random-no-repeat"),
        ("openai/gpt-4o", UnknownName, "no agent is called 'openai/gpt-4o' (did you mean 'llm:openai/gpt-4o'?)"),
        ("human-inspired:fast", UnknownName, "no strategy is called 'human-inspired:fast' (did you mean 'human-inspired'?); there are: random"),
        ("cognitive:slow", UnknownName, "no strategy is called 'cognitive:slow' (did you mean 'cognitive:careful'?); there are: "),
        ("ideal-observer:x", UnknownName, "no strategy is called 'ideal-observer:x'"),
        ("llm:gpt", BadValue, "language model: got 'gpt', expected PROVIDER/MODEL such as openai/gpt-4o, local or gguf:PATH"),
        ("random:x", UnknownName, "no strategy is called 'random:x'"),
        ("viewers", UnknownName, "no agent is called 'viewers'"),
        ("viewer:llm:local", UnknownName, "no strategy is called 'llm:local'; there are: random, random-no-repeat"),
        ("viewer:viewer", UnknownName, "no strategy is called 'viewer'; there are: random"),
        ("viewer:python:os:abort", UnknownName, "no strategy is called 'python:os:abort'; there are: random"),
        ("viewer?acuty=9", UnknownName, "no option of viewer is called 'acuty' (did you mean 'acuity'?); there are: acuity, target, "),
        ("viewer:random?lapse=0.1", UnknownName, "no option of viewer:random is called 'lapse'; there are: acuity"),
        *((f"mcp{name}", BadValue, f"agent: got 'mcp{name}', expected mcp:NAME") for name in ("", ":", ":-a", ":a b", ":a/b", ":é", ":" + "A" * 65, ":a:b")),
        *((f"participant:{name}", BadValue, f"agent: got 'participant:{name}', expected participant, or participant:ID with 4 to 32") for name in ("", "abc", "ABCD", "a" * 33, "abcd:e")),
        ("random\x1b[31m", BadValue, f"agent: got 'random?[31m', expected {NAMED}"),
        ("llm:openai/gpt\u202e4o", BadValue, f"agent: got 'llm:openai/gpt?4o', expected {NAMED}"),
        ("human-inspired\n", BadValue, f"agent: got 'human-inspired?', expected {NAMED}"),
    ],
)  # fmt: skip
def test_what_names_no_agent_is_refused_with_what_there_is(spec, kind, message):
    with pytest.raises(kind) as mistake:
        resolve(spec)
    assert str(mistake.value).startswith(message)


def test_options_of_a_viewer_and_of_its_strategy_stand_side_by_side():
    one = resolve("viewer:human-inspired:proximity?acuity=12&lapse=0.1").make()
    other = resolve("viewer:human-inspired:proximity?lapse=0.1&acuity=12").make()
    assert one == other
    assert (one.acuity, one.strategy.lapse, one.strategy.nearest) == (12, 0.1, True)
    assert one.strategy == resolve("human-inspired:proximity?lapse=0.1").make()
    assert one.facts.items() >= {"acuity": 12, "strategy": "human-inspired:proximity?lapse=0.1", "lapse": 0.1}.items()
    assert resolve("viewer").make() == resolve("viewer:human-inspired:target-first").make()
    assert resolve("human-inspired").make().facts == {}  # the default states nothing
    assert resolve("ideal-observer?prior=chains").make().facts.items() >= {"prior": "chains", "noise": "aware"}.items()


def test_every_kind_of_agent_is_described():
    assert all(KNOWN.values())
    assert description("cognitive:careful") == "Turns to what has neither moved nor failed, the target first."
    assert description("human-inspired:proximity").startswith("Rules joints out")
    assert [description(spec) for spec in ("participant", "python:a:B", "llm:openai/gpt-4o")] == [""] * 3


def test_your_own_class(tmp_path, monkeypatch):
    """Those that play are in ``tests/test_docs.py``."""
    (tmp_path / "own_agent.py").write_text(
        "class NoAgent: pass\nclass Plain:\n    facts = {}\n    def decide(self, situation, rng): pass\n"
    )
    monkeypatch.syspath_prepend(tmp_path)
    allow("python:own_agent:NoAgent", "python:own_agent:Nobody", "python:own_agent:Plain")
    for name, said in {
        "Plain": "agent: got 'python:own_agent:Plain', expected a class with `facts` and `async def decide",
        "NoAgent": "agent: got 'python:own_agent:NoAgent', expected a class with `facts` and `async def decide",
        "Nobody": "agent 'python:own_agent:Nobody' does not work .AttributeError: module 'own_agent' has no",
    }.items():
        with pytest.raises(UserMistake, match=f"^{said}"):
            resolve(f"python:own_agent:{name}").check()
