"""The key numbers of the first screen."""

from dataclasses import replace

from lockprobe.analysis.effects import effects
from lockprobe.analysis.reference import reference_of
from lockprobe.lockbox.families import box
from lockprobe.report.overview import _condition_numbers
from lockprobe.testing import make_trial

SOLVED, UNSOLVED = [3, 2, 1, 0], [0, 1, 0, 1]


def solving(condition, many, of=40):
    """Trials of which the first ``many`` are solved."""
    trials = [make_trial(SOLVED if i < many else UNSOLVED, trial=i + 1) for i in range(of)]
    return [replace(trial, condition=condition) for trial in trials]


def test_of_equal_p_values_the_largest_effect_is_the_clearest():
    found = effects({name: solving(name, many) for name, many in (("truth", 0), ("x", 30), ("y", 40))}, "truth")
    assert len({one.difference.p_value for one in found.effects}) == 1
    row = _condition_numbers(found, reference_of(box("chain-4"), 20))
    assert row.against == "clearest change under y"
    assert row.change.startswith("+100")
