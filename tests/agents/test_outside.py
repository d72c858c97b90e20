"""An agent outside of the loop decides when it is told to, in order, and says how it was reached."""

import asyncio
from dataclasses import replace

import pytest

from lockprobe.agents.outside import OutsideAgent
from lockprobe.agents.prompt import example
from lockprobe.foundation.errors import ChannelFault
from lockprobe.trial.briefing import Briefing
from lockprobe.trial.record import Decision


def test_a_decision_waits_until_it_is_said():
    async def play():
        agent = OutsideAgent({"transport": "stdio"})
        deciding = asyncio.create_task(agent.decide(example(), None))
        assert await agent.asked() == example()
        await asyncio.sleep(0)
        assert not deciding.done()
        agent.say("A", "moved", "it turns")
        assert await deciding == Decision(joint="A", claimed="moved", hypothesis="it turns")
        return agent.facts

    assert asyncio.run(play()) == {"transport": "stdio"}


def test_who_reads_words_alone_is_asked_for_nothing_else():
    asked = {"instruction": "{joints}"}

    async def decides(briefing, **settings):
        agent = OutsideAgent(**settings)
        agent.say("A")
        return await agent.decide(replace(example(), briefing=briefing), None)

    words = Briefing(remark="Look.", warning="Mind.")
    for briefing, settings in ((words, {"words_alone": True}), (replace(words, **asked), {})):
        assert asyncio.run(decides(briefing, **settings)).joint == "A"
    with pytest.raises(ChannelFault, match="more than a remark or a warning"):
        asyncio.run(decides(replace(words, **asked), words_alone=True))
