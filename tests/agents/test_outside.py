"""An agent outside of the loop decides when it is told to, in order, and says how it was reached."""

import asyncio

from lockprobe.agents.outside import OutsideAgent
from lockprobe.agents.prompt import example
from lockprobe.record import Decision


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
