"""``lockprobe box``: lists, shows, generates and checks boxes."""

from __future__ import annotations

import json as json_
from collections.abc import Iterator
from dataclasses import asdict
from itertools import islice
from pathlib import Path
from typing import Annotated, Any

import typer

from lockprobe.boxes.box import Lockbox, data_of
from lockprobe.boxes.families import DEFAULT_BOX, STRUCTURES, find_box
from lockprobe.boxes.families import generate as make
from lockprobe.boxes.layouts import LayoutName
from lockprobe.boxes.sketch import interlock_lines, panel_lines
from lockprobe.boxes.solve import difficulty, space_of
from lockprobe.cli import options
from lockprobe.cli.printing import say
from lockprobe.foundation.errors import BadFile, BadValue, UserMistake
from lockprobe.foundation.formatting import count as counted
from lockprobe.foundation.inputs import read_input
from lockprobe.foundation.plugins import listed_plugins, robot_plugin
from lockprobe.foundation.spec import Spec
from lockprobe.foundation.storage.atomic_file import make_directory, write_file

app = typer.Typer(no_args_is_help=True, rich_markup_mode=None)

_MODEL = "A MuJoCo model of the box, or 'twin?model=FILE.xml' with options."
_DRAWING = options.with_brackets(options.OUT, "a drawing, .svg or .png; a model for MuJoCo, .xml")
_DEAL = "Assign places, kinds and names to the joints at random."
_FILES = options.with_brackets(options.OUT, "a TOML file of each box")

_PLANS, _SAID = 100, 6
"""The most plans that JSON lists, and words."""

_TRIES = 100
"""Seeds tried for each box that was asked for."""


@app.command("check")
def check(
    box: Annotated[str, typer.Argument(metavar="FILE.toml", help="The box file: its rules.")],
    model: Annotated[str | None, typer.Argument(metavar="FILE.xml", help=_MODEL)] = None,
) -> None:
    """Check a box file, and a MuJoCo model of the box against its rules.

    Every joint is pushed in every configuration that the model reaches, in 64 of them at most.
    """
    found = find_box(box)
    print(
        f"{box}: can be played. {len(found.joints)} joints, target {found.target}, optimum "
        f"{space_of(found).optimum} steps, {counted(len(space_of(found).reachable), 'configuration')} before "
        f"{found.target} moves"
    )
    if model is None:
        return
    from lockprobe.plants.catalogue import resolve_plant

    resolve_plant(model if model.startswith("twin?") else str(Spec("twin", options={"model": model}))).check(found)
    print(f"{model}: every push went as the rules say")


@app.command("list")
def list_boxes(json: options.AsJson = False) -> None:
    """List the named boxes and their difficulty, also those of installed packages."""
    rows: list[dict[str, Any]] = [{**_facts(find_box(name)), "name": name} for name in STRUCTURES]
    for one in listed_plugins("box", STRUCTURES):
        try:
            facts = {"error": one.what} if one.found is None else _facts(find_box(one.name))
        except UserMistake as mistake:
            facts = {"error": f"Cannot be used. {mistake}"}
        rows.append({**facts, "name": one.name, "package": one.package})
    if json:
        print("\n".join(map(json_.dumps, rows)))
        return
    print(f"{'name':16} joints  optimum  random  no-repeat")
    for row in rows:
        says = f"  ({row['package']})" if "package" in row else "  (default)" if row["name"] == DEFAULT_BOX else ""
        line = row.get("error") or (
            f"{len(row['joints']):6}  {row['optimum']:7}"
            f"  {row['random_success']:6.3f}  {row['random_no_repeat_success']:9.3f}{says}"
        )
        print(f"{row['name']:16} {line}")
    print("Also: random-N-SEED, an interlock of N joints drawn from the seed, as random-5-17; and TOML files.")


@app.command("show")
def show(
    name: Annotated[str, typer.Argument(metavar="NAME|FILE", help=options.BOX)] = DEFAULT_BOX,
    out: Annotated[Path | None, typer.Option(metavar="FILE", help=_DRAWING)] = None,
    arm: Annotated[bool, typer.Option("--arm", help="With the robot arm (in a model for MuJoCo).")] = False,
    json: options.AsJson = False,
) -> None:
    """Show a box: its panel, its interlock, its difficulty and its optimal plans."""
    box = find_box(name)
    if arm and (out is None or out.suffix != ".xml"):
        raise BadValue("--arm", True, "--out FILE.xml with it, a model for MuJoCo")
    if out and out.suffix == ".xml":
        robot_plugin("tool", "box-model", "MuJoCo models of boxes need").load()(box, out, arm=arm)
    elif out and out.suffix in (".svg", ".png"):
        from lockprobe.report.figures.boxes import box_figure
        from lockprobe.report.figures.drawing import render

        write_file(out, render(box_figure(box), "svg" if out.suffix == ".svg" else "png"))
    elif out:
        raise BadValue("--out", str(out), "a file name that ends in .svg, .png or .xml")
    if json:
        print(json_.dumps(_facts(box)))
    elif out:
        print(out)
    else:
        say("\n".join(_in_words(box)))


@app.command("generate")
def generate(
    family: Annotated[str, typer.Option(help="A named box, or random-N: an interlock of N joints.")] = "random-4",
    layout: Annotated[LayoutName, typer.Option(help="Where joints lie on the panel.")] = "serial",
    deal: Annotated[bool, typer.Option("--deal", help=_DEAL)] = False,
    count: Annotated[int, typer.Option(min=1, max=100_000, help="How many boxes.")] = 1,
    seed: options.Seed = 1,
    out: Annotated[Path | None, typer.Option(metavar="DIR", help=_FILES)] = None,
) -> None:
    """Generate boxes, from --seed on. Seeds that give no valid box are skipped."""
    from lockprobe.boxes.boxfile import toml_of

    seeds = range(seed, seed + _TRIES * count)
    tried = (make(family, one, layout=layout, dealt=deal) for one in seeds)
    made = 0
    for found in islice((one for one in tried if isinstance(one, Lockbox)), count):
        made += 1
        said, facts = found.name, difficulty(found)
        if out:
            path, text = out / f"{found.name}.toml", toml_of(found)
            make_directory(out)
            if path.exists() and read_input(path) != text.encode():
                raise BadFile(path, "already exists with other content: give another --out")
            write_file(path, text)
            said = str(path)
        print(
            f"{said}  optimum {facts.optimum}, random {facts.random_success:.3f}, "
            f"no-repeat {facts.random_no_repeat_success:.3f}"
        )
    if made < count:
        raise BadValue("count", count, f"at most {made}: all other seeds of {_TRIES * count} were refused")


def _in_words(box: Lockbox) -> Iterator[str]:
    """The panel with the legend of its numbers, the interlock, the difficulty, and some optimal plans."""
    found, wide = difficulty(box, _SAID), max(map(len, box.names))
    optimal = counted(found.optimal_plans, "optimal plan")
    yield f"{box.name}: {len(box.joints)} joints, target {box.target}, optimum {found.optimum} steps, {optimal}"
    yield from panel_lines(box)
    for i, (joint, position) in enumerate(zip(box.joints, box.initial, strict=True), 1):
        target, start = "*" if joint.name == box.target else " ", "open" if position else "closed"
        yield f" {i}{target} {joint.name:{wide}}  {joint.kind:9}  {start} at the start"
    yield from ("", *interlock_lines(box), "")
    yield f"joints that no optimal plan moves: {', '.join(found.distractors) or 'none'}"
    yield (
        f"solved in 20 steps: random {found.random_success:.4f}, "
        f"random without repeats {found.random_no_repeat_success:.4f}"
    )
    yield f"solved in 20 steps by a fixed order of all joints, repeated: {found.cycle_success:.4f} of all orders"
    yield from (f"plan: {', '.join(plan)}" for plan in found.plans)
    if more := found.optimal_plans - len(found.plans):
        yield f"and {counted(more, 'more plan')}"


def _facts(box: Lockbox) -> dict[str, Any]:
    """The facts of a box for JSON."""
    return {**data_of(box), **asdict(difficulty(box, _PLANS))}
