"""The example that puts the twin's pictures into a folder: a rehearsal of a person with a camera."""

import re
import runpy
import threading
from pathlib import Path
from queue import Queue

from lockprobe_robot.hardware import sight

from lockprobe.boxes.families import box
from lockprobe.plants.manual import ENTER
from lockprobe.studies.running.single import run_trial

PATH = Path(__file__).parents[2] / "examples" / "twin_camera.py"
NAMED = re.compile(r"Move joint \w \(([\w-]+)\)")


class Rehearsing:
    """Answers Lockprobe, after typing into the example the joint that Lockprobe names."""

    def __init__(self, type_in):
        self.type_in = type_in

    def ask(self, question, answers):
        assert answers == (ENTER,)
        named = NAMED.search(question)
        self.type_in(named[1] if named else "")
        return ENTER

    def tell(self, line):
        assert line.startswith(("New trial of chain-4.", "The picture shows "))


def test_a_trial_is_played_on_the_twins_pictures(tmp_path, monkeypatch):
    photograph = runpy.run_path(str(PATH))["photograph"]
    typed, taken = Queue(), Queue()

    def ask(question):
        taken.put(question)
        return typed.get(timeout=60)

    camera = threading.Thread(target=photograph, args=(tmp_path, box("chain-4"), ask), daemon=True)
    camera.start()
    taken.get(timeout=60)

    def type_in(words):
        typed.put(words)
        taken.get(timeout=60)

    monkeypatch.setattr(sight, "TerminalOperator", lambda: Rehearsing(type_in))
    short = {"agent": "human-inspired", "seed": 2, "max_steps": 2}
    by_hand = run_trial(plant=f"manual?camera={tmp_path}", **short)
    by_rules = run_trial(**short)
    typed.put("q")
    camera.join(timeout=60)
    assert not camera.is_alive()
    assert [(step.joint, step.moved) for step in by_hand.steps] == [(step.joint, step.moved) for step in by_rules.steps]
    assert {step.sensed["truth"] for step in by_hand.steps} == {"camera"}
