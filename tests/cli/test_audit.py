"""``lockprobe audit``, as typed: it prints what was measured."""

import json

from lockprobe.report.prose.hypothesis_tests import QUESTIONS
from lockprobe.simulation.audit.rates import measured, shipped


def test_an_audit_in_words(lockprobe):
    status, out, _ = lockprobe("audit")
    assert status == 0
    said = " ".join(out.split())
    for question in QUESTIONS.values():
        assert question in said
    for rate in measured():
        if rate.truth:
            assert f"{rate.rate:.2f} ±{rate.error:.2f} {rate.world}" in said
    for rate in shipped()["many_agents"]["rates"]:
        assert f"{rate['world']} {rate['agents']} {rate['sentence']} " in said
    assert all(f"{name} {says}" in said for name, says in shipped()["worlds"].items())
    for rate in shipped()["every_look"]["rates"]:
        assert f"{rate['says']} {rate['agents']} {rate['worlds']} {rate['world']} {rate['rate']:.3f} ±" in said
    assert "Pearson over doses 1.00 ±0.00 inverted-u !" in said
    assert "two lines * 0.02 ±0.00 loop-trapped 0.29" in said


def test_an_audit_as_json_is_the_file_that_ships(lockprobe):
    assert json.loads(lockprobe("audit", "--json")[1]) == shipped()
