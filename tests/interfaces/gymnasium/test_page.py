"""The programs on the environment's page run as they stand there."""

import re
import warnings
from pathlib import Path

PAGE = Path(__file__).parents[3] / "docs" / "gymnasium.md"


def test_the_programs_on_the_page_run():
    programs = re.findall(r"```python\n(.*?)```", PAGE.read_text("utf-8"), re.DOTALL)
    ours = [program for program in programs if "stable_baselines3" not in program]
    names = {}
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for program in ours:
            exec(compile(program, str(PAGE), "exec"), names)
    assert len(ours) == len(programs) - 1 == 6
    assert names["there"].steps
    assert names["observations"].shape == (1000, 7)
    assert len(names["rows"]) > 0
