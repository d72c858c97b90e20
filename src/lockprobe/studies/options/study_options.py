"""The options of a study. Command line, study files, Inspect tasks and Python all derive theirs from here.

A study file holds them as TOML::

    study = "flips"
    agent = ["llm:local", "random"]
    sweep = "tremble?p=0,0.1,0.2"
    trials = 5

    [[condition]]
    name = "nudged"
    spec = "flip?p=0.4 + nudge"

An option on the command line overrides the file. A study file is data from anyone: it cannot name an agent, a plant,
a box or an intervention that runs code.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, InstanceOf, ValidationError, model_validator

from lockprobe.agents.local import portable
from lockprobe.boxes.box import LayoutKind, Lockbox, Shuffle
from lockprobe.foundation.errors import BadFile, BadValue, UnknownName, UserMistake
from lockprobe.foundation.inputs import PRESETS, read_toml
from lockprobe.foundation.plugins import plugin_name_of
from lockprobe.foundation.spec import named_spec, spec_kind, split_specs
from lockprobe.foundation.validation import plain
from lockprobe.interventions.flip import FlipKind
from lockprobe.trial.condition import Contrast
from lockprobe.trial.record import LONGEST_TRIAL, Ask

STUDIES = ("flips", "modalities", "why", "looks")
"""The studies by name."""

SHIPPED = ("mechanisms.toml",)
"""Study files that come with the package. One of the same name in the working directory overrides it."""

Trials = Annotated[int, Field(strict=True, ge=1, le=1_000_000)]
Repetitions = Annotated[int, Field(strict=True, ge=1, le=10_000)]
Steps = Annotated[int, Field(strict=True, ge=1, le=LONGEST_TRIAL)]
Seed = Annotated[int, Field(strict=True, ge=0, le=2**63)]
"""The numbers of a study, here and in :class:`lockprobe.studies.study.Study`."""


def _listed(given: object) -> object:
    """One alone as a list of one."""
    return [given] if isinstance(given, str) else given


def _parts(given: object) -> object:
    """One alone, or a list, in which a text may have several with commas between, as a list."""
    found = given if isinstance(given, list | tuple) else [given] * (given is not None)
    return [part for one in found for part in (map(str.strip, one.split(",")) if isinstance(one, str) else [one])]


def _agents(given: object) -> Any:
    """Agents as specs, of classes too; ``NAME=SPEC`` of those in a mapping."""
    if isinstance(given, Mapping):
        return [f"{name}={spec}" for name, one in given.items() for spec in _agents([one])]
    if not isinstance(given, list | tuple):
        return _agents([given]) if isinstance(given, str | type) else given
    return [plugin_name_of("agent", one) if isinstance(one, type) else one for one in given]


def _option(words: str, default: object = None) -> Any:
    """An option with what it means, its default in brackets."""
    return Field(default=default, description=words)


class NamedCondition(BaseModel):
    """What acts in a condition, with plus signs between, and the experimenter's name for it; from ``NAME=SPEC`` too."""

    model_config = ConfigDict(extra="forbid")

    spec: str = Field(max_length=1000)
    name: str = ""

    @model_validator(mode="before")
    @classmethod
    def _parsed(cls, given: object) -> object:
        if isinstance(given, str):
            return dict(zip(("name", "spec"), named_spec(given, "condition", "lies=flip?p=0.4"), strict=True))
        return given


Spec = Annotated[str, Field(max_length=1000)]
"""The spec of an agent or a plant."""

Several = Annotated[list[Spec], Field(max_length=64), BeforeValidator(_listed)]
"""One, or a list of them."""

Agents = Annotated[list[Spec], Field(max_length=64), BeforeValidator(_agents)]
"""Specs or classes: one, a list of them, or a mapping with their names."""

Flips = Annotated[list[FlipKind], Field(min_length=1), BeforeValidator(_parts)]
Rates = Annotated[list[float], Field(max_length=1000), BeforeValidator(_parts)]
Boxes = Annotated[list[str | Path | InstanceOf[Lockbox]], Field(min_length=1), BeforeValidator(_parts)]
"""Names, paths of files, or boxes; in a file of text only the first two."""

Conditions = Annotated[list[NamedCondition], Field(max_length=1000), BeforeValidator(_listed)]


class StudyOptions(BaseModel):
    """What a user asks for; what is left out follows the study's own default. Every field carries what it means."""

    model_config = ConfigDict(extra="forbid")

    study: str = _option("flips, modalities, why, looks, or the study of a file.", default="flips")
    agent: Agents | None = _option(
        "Agent by its spec, or by the name that 'NAME=SPEC' gives it; may be repeated (flips: a cognitive model, "
        "human-inspired, llm:local and random)."
    )
    box: Boxes | None = _option("A box by name, random-N-SEED, or a TOML file (chain-4; several with commas between).")
    boxes: Annotated[int, Field(strict=True, ge=2, le=100)] | None = _option(
        "So many boxes instead: random-4-SEED from a seed of 1 on, those whose shortest plan has four steps, as "
        "chain-4's; with --box random-N, of N joints, 4 to 8 (none)."
    )
    p: Rates | None = _option(
        "Flip rates, how often reports are inverted (0,0.2,0.4,0.6; 0 to 0.6 by 0.1 with --full, --trials or "
        "--repetitions; 0.4 with why)."
    )
    trials: Trials | None = _option(
        "Trials per condition and box: 10 on each of 5 boxes are 50 (in each repetition: 1; 10 with --full, or if --p "
        "or --repetitions is given; 50 with why; 5 with several boxes)."
    )
    strategy_trials: Trials | None = _option(
        "Trials per condition and box for strategies, which cost nothing (100 in the short study, 150 with why, 20 "
        "with several boxes; else as --trials)."
    )
    until: str | None = _option(
        "Play until every difference is decided (shown to be an effect, or smaller than 10 points), or until each is "
        "known to ±10, or ±5, points; it stops there, or after --trials, 300. This assumes an effect that does not "
        "drift meanwhile (all trials are played)."
    )
    repetitions: Repetitions | None = _option("Repetitions (3; 1 with why and with several boxes).")
    seed: Seed | None = _option("Seed of everything (1).")
    max_steps: Steps | None = _option("Budget of a trial in steps (20).")
    flip: Flips | None = _option(
        "What a false report is: re-observed, integrated, memoryless or transient, latched or sticky; independent, "
        "all positions; or outcome-only, without positions; several with commas between (re-observed; in the short "
        "study and with --full strategies, which cost nothing, also play integrated)."
    )
    plant: Spec | None = _option(
        "What is acted on: a plant that lockprobe list plants lists, with options as in twin?looks=varied (flips: "
        "symbolic; modalities: fast-twin)."
    )
    modality: Several | None = _option(
        "How the box is shown: symbolic?tell=state, the states of the joints (flips); symbolic, also what attempts "
        "did; rgb, rgb?blur=8; may be repeated (modalities: rgb, rgbd, symbolic?tell=state)."
    )
    condition: Conditions | None = _option(
        "Interventions with plus signs between, 'flip?p=0.4 + nudge', or the name that 'NAME=SPEC' gives them; may be"
        " repeated (nothing; with any, truth is played too, as the control)."
    )
    contrasts: Annotated[dict[str, Contrast], Field(max_length=64)] | None = _option(
        "What is asked, by its name: mean success, or misreading, under the conditions of one list minus that under "
        "the conditions of another; a table of a study file, or a dict in Python (none)."
    )
    sweep: Several | None = _option(
        "One condition for each dose: 'tremble?p=0,0.1,0.2'; for several doses with plus signs between, one for every"
        " combination; may be repeated (nothing)."
    )
    as_paper: bool = _option(
        "The paper's set-up, as far as it is known: states of all joints as JSON, labels and panel drawn once, no "
        "hypothesis, its numbers of trials; other options override (flips, modalities; docs/as-paper.md).",
        default=False,
    )
    layout: LayoutKind | None = _option(
        "Where joints lie on the panel (fixed, as in the box; dealt: at random, in all trials alike; shuffled: at "
        "random in every trial, as it is where people or pictures see places, if the plant can)."
    )
    shuffle: Shuffle | None = _option(
        "How often labels and their order are drawn: trial, once for the study, never (trial; modalities and looks "
        "with pictures of a real box: never)."
    )
    assessment: bool | None = _option(
        "Ask, with every reply, what the last action did; asking may change behaviour (--assessment)."
    )
    hypothesis: Ask | None = _option(
        "When a hosted model says how the box works, in a sentence: before or after its choice, or off (before)."
    )
    full: bool = _option("The paper's 7 x 3 x 10 trials per agent (flips).", default=False)
    name: str | None = _option("A name for the study, with which keys of records begin (the study's).")

    @property
    def agents(self) -> tuple[list[str], dict[str, str]]:
        """The specs of its agents, and spec -> name of those that ``NAME=SPEC`` gives one.

        Specs are those of records, without paths of this machine (:func:`lockprobe.agents.local.portable`).

        >>> StudyOptions(agent=["careful=human-inspired?lapse=0.1", "random"]).agents
        (['human-inspired?lapse=0.1', 'random'], {'human-inspired?lapse=0.1': 'careful'})
        """
        found = [named_spec(one, "agent", "careful=human-inspired?lapse=0.1") for one in self.agent or ()]
        named = [(name, portable(spec)) for name, spec in found]
        return [spec for _, spec in named], {spec: name for name, spec in named if name}

    @property
    def specs(self) -> dict[str, list[str]]:
        """The specs that can name code, by option."""
        found: dict[str, list[Any]] = {
            "agent": self.agents[0],
            "condition": [one.spec for one in self.condition or ()],
            "sweep": self.sweep or [],
            "plant": [self.plant],
            "box": self.box or [],
        }
        return {what: [spec for spec in specs if isinstance(spec, str)] for what, specs in found.items()}


def read_options(asked: StudyOptions | str | Path, given: Mapping[str, Any]) -> StudyOptions:
    """What is asked for: a bare name, the path of a TOML file or options, and options that go before those.

    Of a file, only what the options leave is refused if it would run code.

    Raises:
        UnknownName: If an option or a study does not exist; the message lists those that do.
        BadValue: If an option has a value that it cannot have.
        BadFile: If there is no such file, or it is none of a study.
    """
    file = None if isinstance(asked, StudyOptions) or not str(asked).endswith(".toml") else Path(asked)
    before = asked if isinstance(asked, StudyOptions) else read_file(file) if file else None
    wanted = given if before else {"study": str(asked), **given}
    try:
        more = StudyOptions.model_validate(wanted)
    except ValidationError as error:
        raise refused(error, wanted) from None
    said = before.model_copy(update={name: getattr(more, name) for name in given}) if before else more
    if said.study not in STUDIES:
        raise UnknownName("study", said.study, [*STUDIES, *SHIPPED, "FILE.toml"])
    for what, spec in ((what, spec) for what, specs in said.specs.items() for spec in specs if what not in given):
        if file and any(spec_kind(part) == "python" for part in split_specs(spec)):
            raise BadFile(file, f"{what}: {spec} would run code; name it on the command line with --{what}")
    return said


def refused(error: ValidationError, given: Mapping[str, Any]) -> UserMistake:
    """The first of the options that are none, or have a value that they cannot have, in one line."""
    first = error.errors()[0]
    where, said, got = str(first["loc"][0]), plain(first["msg"]), given.get(str(first["loc"][0]))
    if first["type"] == "extra_forbidden" and len(first["loc"]) == 1:
        return UnknownName("option", where, StudyOptions.model_fields)
    if not said.startswith("expected "):  # of a part of it
        return UserMistake(f"{'.'.join(map(str, first['loc']))}: {said}")
    return BadValue(where, got if len(str(got)) <= 1000 else f"{str(got)[:40]}…", said.removeprefix("expected "))


def read_file(path: Path) -> StudyOptions:
    """The options in a TOML file: a user's, or one that ships (:data:`SHIPPED`), by its bare name."""
    if str(path) in SHIPPED and not path.exists():
        path = PRESETS / path.name
    content = read_toml(path)
    try:
        options = StudyOptions.model_validate(content)
    except ValidationError as error:
        raise BadFile(path, str(refused(error, content))) from None
    if not options.model_fields_set - {"name"}:
        raise BadFile(path, 'says nothing to play: a study file has at least a line such as study = "flips"')
    return options
