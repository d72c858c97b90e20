"""``lockprobe box``."""

from __future__ import annotations

import json as json_
from typing import Annotated

import typer

from lockprobe.lockbox.box import Lockbox
from lockprobe.lockbox.families import DEFAULT_BOX, named_boxes
from lockprobe.lockbox.solve import optimum, random_no_repeat_success, random_success
from lockprobe.studies.studyfile import find_box

__all__ = ["app", "list_boxes", "show"]

app = typer.Typer(no_args_is_help=True)
AsJson = Annotated[bool, typer.Option("--json", help="One JSON object.")]


@app.command("list")
def list_boxes(json: AsJson = False) -> None:
    """The boxes there are, with the success of a random agent in 20 steps."""
    for name in named_boxes():
        facts = _facts(find_box(name))
        if json:
            print(json_.dumps(facts))
        else:
            default = "  (default)" if name == DEFAULT_BOX else ""
            print(f"{name}  optimum {facts['optimum']} steps, random {facts['random_success']:.3f}{default}")


@app.command("show")
def show(
    name: Annotated[str, typer.Argument(help="A box by name, or a TOML file.")] = DEFAULT_BOX,
    json: AsJson = False,
) -> None:
    """A box: its joints, what locks them, and what blind agents reach on it."""
    box = find_box(name)
    facts = _facts(box)
    if json:
        print(json_.dumps(facts))
        return
    print(f"{box.name}: {len(box.joints)} joints, target {box.target}, optimum {facts['optimum']} steps")
    for joint in box.joints:
        alternatives = [
            " and ".join(f"{other}={int(position)}" for other, position in clause.items())
            for clause in box.interlock.get(joint.name, ({},))
        ]
        print(f"  {joint.name} ({joint.kind}): {' or '.join(text or 'always free' for text in alternatives)}")
    print(
        f"in 20 steps: random {facts['random_success']:.4f}, "
        f"random without repeats {facts['random_no_repeat_success']:.4f}"
    )


def _facts(box: Lockbox) -> dict[str, object]:
    return {
        **box.as_data(),
        "optimum": optimum(box),
        "random_success": random_success(box),
        "random_no_repeat_success": random_no_repeat_success(box),
    }
