"""``lockprobe box check``: checks a box file, and a MuJoCo model of the box against its rules."""

from __future__ import annotations

from typing import Annotated

import typer

from lockprobe.boxes.families import find_box
from lockprobe.boxes.solve import optimum
from lockprobe.boxes.state_space import space_of
from lockprobe.foundation.formatting import count
from lockprobe.foundation.spec import Spec


def check(
    box: Annotated[str, typer.Argument(metavar="FILE.toml", help="The box file: its rules.")],
    model: Annotated[
        str | None,
        typer.Argument(metavar="FILE.xml", help="A MuJoCo model of the box, or 'twin?model=FILE.xml' with options."),
    ] = None,
) -> None:
    """Check a box file, and a MuJoCo model of the box against its rules.

    Every joint is pushed in every configuration that the model reaches, in 64 of them at most.
    """
    found = find_box(box)
    print(
        f"{box}: can be played. {len(found.joints)} joints, target {found.target}, optimum {optimum(found)} steps, "
        f"{count(len(space_of(found).reachable), 'configuration')} before {found.target} moves"
    )
    if model is None:
        return
    from lockprobe.plants.catalogue import resolve_plant

    resolve_plant(model if model.startswith("twin?") else str(Spec("twin", options={"model": model}))).check(found)
    print(f"{model}: every push went as the rules say")
