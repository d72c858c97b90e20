"""A warning stands in the instruction, and nowhere else."""

from dataclasses import replace

import pytest

from lockprobe.agents.prompt import conversation, example
from lockprobe.interventions.warn import Warn
from lockprobe.trial.briefing import Briefing


@pytest.mark.parametrize(("rate", "often"), [(None, "sometimes"), (0.4, "with probability 0.4")])
def test_the_instruction_says_it_once(rate, often):
    briefing = Warn(rate=rate).brief(Briefing(), (), None, None)
    first, *others = conversation(replace(example(), briefing=briefing))
    plain, *same = conversation(example())
    assert others == same
    assert (
        first.text.replace(f" What you are told of your last action is {often} false.", "") == plain.text != first.text
    )
