"""An agent outside of the loop is a person or a client by its spec. That it is waited for: ``test_paused_trial.py``."""

import asyncio
from dataclasses import replace

import pytest

from lockprobe.agents.catalogue import resolve
from lockprobe.agents.outside import OutsideAgent
from lockprobe.agents.prompt import example
from lockprobe.foundation.errors import BadValue, ChannelFault
from lockprobe.trial.record import Briefing


@pytest.mark.parametrize(
    ("names", "expected"),
    [
        (["mcp", *(f"mcp:{name}" for name in ("", "-a", "a b", "a/b", "é", "A" * 65, "a:b"))], "mcp:NAME"),
        ([f"participant:{name}" for name in ("", "abc", "ABCD", "a" * 33, "abcd:e")], "participant:ID with 4 to 32"),
    ],
)
def test_a_person_or_a_client_is_named_in_a_form_that_is_refused_otherwise(names, expected):
    for name in names:
        with pytest.raises(BadValue, match=expected):
            resolve(name)
    assert [resolve(spec).engine for spec in ("participant", "participant:3f9a01bc")] == ["person"] * 2
    assert resolve("mcp:claude-code").engine == "client"


def test_who_reads_words_alone_is_asked_for_nothing_else():
    async def decides(briefing, **settings):
        agent = OutsideAgent(**settings)
        agent.say("A")
        return await agent.decide(replace(example(), briefing=briefing), None)

    words = Briefing(remark="Look.", warning="Mind.")
    asked = replace(words, instruction="{joints}")
    for briefing, settings in ((words, {"words_alone": True}), (asked, {})):
        assert asyncio.run(decides(briefing, **settings)).joint == "A"
    with pytest.raises(ChannelFault, match="more than a remark or a warning"):
        asyncio.run(decides(asked, words_alone=True))
