"""``lockprobe box``: lists, shows, solves, generates and checks boxes."""

from __future__ import annotations

import json as json_
import sys
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import asdict, replace
from pathlib import Path
from typing import Annotated

import typer

from lockprobe.boxes.box import Lockbox
from lockprobe.boxes.families import DEFAULT_BOX, box, find_box, named_boxes, sized
from lockprobe.boxes.generate import Recipe
from lockprobe.boxes.generate import generate as make
from lockprobe.boxes.layouts import LayoutName
from lockprobe.boxes.sketch import ascii_only, interlock_lines, panel_lines
from lockprobe.boxes.solve import (
    difficulty,
    optimal_plans,
    optimum,
)
from lockprobe.boxes.state_space import space_of
from lockprobe.cli import options
from lockprobe.foundation.errors import BadFile, BadValue, UserMistake
from lockprobe.foundation.formatting import count as counted
from lockprobe.foundation.inputs import read_input
from lockprobe.foundation.plugins import listed_plugins, robot_plugin
from lockprobe.foundation.spec import Spec, arguments_from
from lockprobe.foundation.storage.atomic_file import refuse_links, write_file

app = typer.Typer(no_args_is_help=True, rich_markup_mode=None)
Name = Annotated[str, typer.Argument(metavar="NAME|FILE", help=options.BOX)]

_FAMILY = (
    "A named box, with or without its size, or random; random?alternatives=2&literals=2&negative=0.25 has options."
)
_PARTS = tuple(Recipe.__dataclass_fields__)
_FIXED = tuple(name for name in _PARTS if name not in ("alternatives", "literals", "negative"))
"""The parts of a recipe that are no options of a family."""

_PLANS = 100
"""The most plans that are listed."""

_TRIES = 100
"""Seeds tried for each box that was asked for."""


@app.command("check")
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
        f"{counted(len(space_of(found).reachable), 'configuration')} before {found.target} moves"
    )
    if model is None:
        return
    from lockprobe.plants.catalogue import resolve_plant

    resolve_plant(model if model.startswith("twin?") else str(Spec("twin", options={"model": model}))).check(found)
    print(f"{model}: every push went as the rules say")


@app.command("list")
def list_boxes(json: options.AsJson = False) -> None:
    """List the named boxes and their difficulty."""
    if not json:
        print(f"{'name':16} joints  optimum  random  no-repeat")
    for row in (*((name, "", box(name)) for name in named_boxes()), *_packaged()):
        name, package, found = row
        owner = {"package": package} if package else {}
        if isinstance(found, str):
            print(json_.dumps({"error": found, "name": name} | owner) if json else f"{name:16} {found}")
        elif json:
            print(json_.dumps(_facts(found) | {"name": name} | owner))
        else:
            says = f"  ({package})" if package else "  (default)" if name == DEFAULT_BOX else ""
            facts = difficulty(found)
            print(
                f"{name:16} {len(found.joints):6}  {facts.optimum:7}"
                f"  {facts.random_success:6.3f}  {facts.random_no_repeat_success:9.3f}{says}"
            )
    if not json:
        print("Also: random-N-SEED, an interlock of N joints drawn from the seed, as random-5-17; and TOML files.")


def _packaged() -> Iterator[tuple[str, str, Lockbox | str]]:
    """The boxes of installed packages: name, package, and the box or the reason why it cannot be used."""
    for row in listed_plugins("box", named_boxes()):
        try:
            yield row.name, row.package, row.what if row.found is None else find_box(row.name)
        except UserMistake as mistake:
            yield row.name, row.package, f"Cannot be used. {mistake}"


@app.command("show")
def show(
    name: Name = DEFAULT_BOX,
    out: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE", help=options.with_brackets(options.OUT, "a drawing, .svg or .png; a model for MuJoCo, .xml")
        ),
    ] = None,
    arm: Annotated[bool, typer.Option("--arm", help="With the robot arm (in a model for MuJoCo).")] = False,
    json: options.AsJson = False,
) -> None:
    """Show a box: its panel, its interlock and its difficulty."""
    box = find_box(name)
    if arm and (out is None or out.suffix != ".xml"):
        raise BadValue("--arm", True, "--out FILE.xml with it, a model for MuJoCo")
    if out:
        _draw(box, out, arm=arm)
    if json:
        print(json_.dumps(_facts(box)))
    elif out:
        print(out)
    else:
        _print(_in_words(box))


@app.command("view")
def view(
    name: Name = DEFAULT_BOX,
    arm: Annotated[bool, typer.Option("--arm", help="With the robot arm.")] = False,
) -> None:
    """Open a box in MuJoCo's viewer: its joints can be pulled with the mouse, and lock each other."""
    robot_plugin("tool", "box-view", "MuJoCo models of boxes need").load()(find_box(name), arm=arm)


@app.command("solve")
def solve(
    name: Name = DEFAULT_BOX,
    json: options.AsJson = False,
) -> None:
    """List all optimal plans of a box."""
    box = find_box(name)
    plans, steps = optimal_plans(box, _PLANS), optimum(box)
    if json:
        print(json_.dumps({"name": box.name, "optimum": steps, "optimal_plans": plans.count, "plans": plans.listed}))
        return
    print(f"{box.name}: optimum {steps} steps, {plans.count} optimal plan{'s' * (plans.count != 1)}")
    for plan in plans.listed:
        print("  " + ", ".join(plan))
    if plans.count > len(plans.listed):
        print(f"  and {plans.count - len(plans.listed)} more")


@app.command("generate")
def generate(
    family: Annotated[str, typer.Option(help=_FAMILY)] = "random",
    joints: Annotated[int | None, typer.Option(help=options.with_brackets(options.JOINTS, "4"))] = None,
    layout: Annotated[LayoutName, typer.Option(help=options.LAYOUT)] = "serial",
    deal: Annotated[
        bool, typer.Option("--deal", help="Assign places, kinds and names to the joints at random.")
    ] = False,
    shortest: Annotated[int, typer.Option(help="The least number of steps of the optimum.")] = 2,
    count: Annotated[int, typer.Option(min=1, max=100_000, help="How many boxes.")] = 1,
    seed: options.Seed = 1,
    out: Annotated[
        Path | None, typer.Option(metavar="DIR", help=options.with_brackets(options.OUT, "a TOML file of each box"))
    ] = None,
) -> None:
    """Generate boxes, from --seed on. Seeds that give no valid box are skipped and counted, with the reasons."""
    spec = Spec.parse(family, "family")
    name = sized(spec.full_name, joints)
    drawn = arguments_from(Recipe, name, spec.options, taken=_FIXED if name.startswith("random-") else _PARTS)
    recipe = Recipe(family=name, layout=layout, dealt=deal, shortest=shortest, seed=seed, **drawn)  # type: ignore[arg-type] # named as its fields are
    made, refused = 0, Counter[str]()
    for tried in range(seed, seed + _TRIES * count):
        found = make(replace(recipe, seed=tried))
        if isinstance(found, str):
            kind = found.partition(":")[0]
            refused[kind] += 1
            continue
        file, facts = _write(found, out) if out else None, difficulty(found)
        print(
            f"{file or found.name}  optimum {facts.optimum}, random {facts.random_success:.3f}, "
            f"no-repeat {facts.random_no_repeat_success:.3f}"
        )
        made += 1
        if made == count:
            break
    if refused:
        print(f"refused: {', '.join(f'{number} {kind}' for kind, number in refused.most_common())}", file=sys.stderr)
    if made < count:
        raise BadValue("count", count, f"at most {made}: all other seeds of {_TRIES * count} were refused")


def _write(box: Lockbox, directory: Path) -> Path:
    """Write the box to a file named after it; refuse to replace a file with other content."""
    from lockprobe.boxes.boxfile import toml_of

    refuse_links(directory)
    directory.mkdir(parents=True, exist_ok=True)
    path, text = directory / f"{box.name}.toml", toml_of(box)
    if path.exists() and read_input(path) != text.encode():
        raise BadFile(path, "already exists with other content: give another --out")
    write_file(path, text)
    return path


def _draw(box: Lockbox, out: Path, *, arm: bool) -> None:
    if out.suffix == ".xml":
        robot_plugin("tool", "box-model", "MuJoCo models of boxes need").load()(box, out, arm=arm)
        return
    if out.suffix not in (".svg", ".png"):
        raise BadValue("--out", str(out), "a file name that ends in .svg, .png or .xml")
    from lockprobe.report.figures.boxes import box_figure
    from lockprobe.report.figures.drawing import render

    write_file(out, render(box_figure(box), "svg" if out.suffix == ".svg" else "png"))


def _print(lines: Iterable[str]) -> None:
    """Print lines in characters that the terminal can show."""
    text = "\n".join(lines)
    try:
        text.encode(sys.stdout.encoding or "ascii")
    except UnicodeEncodeError:
        text = ascii_only(text)
    print(text)


def _in_words(box: Lockbox) -> Iterator[str]:
    """The panel with the legend of its numbers, the interlock, and the difficulty."""
    found, wide = difficulty(box), max(map(len, box.names))
    plans = f"{found.optimal_plans} optimal plan{'s' * (found.optimal_plans != 1)}"
    yield f"{box.name}: {len(box.joints)} joints, target {box.target}, optimum {found.optimum} steps, {plans}"
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


def _facts(box: Lockbox) -> dict[str, object]:
    """The facts of a box for JSON."""
    return {**box.as_data(), **asdict(difficulty(box))}
