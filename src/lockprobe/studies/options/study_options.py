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

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Annotated, Any

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, InstanceOf, ValidationError

from lockprobe.boxes.box import LayoutKind, Lockbox, Shuffle
from lockprobe.foundation.errors import BadFile, BadValue, UnknownName
from lockprobe.foundation.inputs import PRESETS, read_toml
from lockprobe.foundation.plugins import refuse_python
from lockprobe.foundation.spec import named_spec
from lockprobe.foundation.validation import plain
from lockprobe.interventions.flip import FlipKind
from lockprobe.studies.options.agent_names import named_agents
from lockprobe.trial.condition import Contrast
from lockprobe.trial.record import Ask

STUDIES = ("flips", "modalities", "why", "looks")
"""The studies by name."""

SHIPPED = ("mechanisms.toml",)
"""Study files that come with the package. One of the same name in the working directory overrides it."""


def _listed(given: object) -> object:
    """One alone as a list of one."""
    return [given] if isinstance(given, str) else given


def _number(given: object) -> object:
    """A number; Python counts true as 1, and nobody means that."""
    if isinstance(given, bool):
        raise ValueError("expected a number, not true or false")  # noqa: TRY004 - which pydantic does not take
    return given


def _box(given: object) -> object:
    if isinstance(given, list | tuple) and not given:
        raise ValueError("expected at least one box")
    for one in given if isinstance(given, list | tuple) else [given]:
        if one is not None and not isinstance(one, str | Path | Lockbox):
            raise ValueError("expected a name, a Lockbox or the path of a TOML file")
    return given


def _option(words: str, default: object = None) -> Any:
    """An option with what it means, its default in brackets."""
    return Field(default=default, description=words)


class NamedCondition(BaseModel):
    """What acts in a condition of a study file, with plus signs between, and the experimenter's name for it."""

    model_config = ConfigDict(extra="forbid")

    spec: str
    name: str = ""


Spec = Annotated[str, Field(max_length=1000)]
"""The spec of an agent, a condition or a plant."""

Several = Annotated[list[Spec], Field(max_length=64), BeforeValidator(_listed)]
"""One, or a list of them."""

Conditions = Annotated[list[NamedCondition | Spec], Field(max_length=1000), BeforeValidator(_listed)]


Whole = Annotated[int, BeforeValidator(_number)]
Number = Annotated[float, BeforeValidator(_number)]
_OneBox = str | Path | InstanceOf[Lockbox]
Box = Annotated[_OneBox | list[_OneBox], BeforeValidator(_box)]
"""A name, the path of a file, or a box, or a list of them; in a file of text only the first two."""


def _words(given: object) -> object:
    """Words with commas between, or a list of them, as a list of words."""
    texts = [given] if isinstance(given, str) else given
    if not isinstance(texts, list | tuple) or not all(isinstance(text, str) for text in texts):
        return given
    return [word.strip() for text in texts for word in text.split(",")]


Words = Annotated[list[str], Field(max_length=64), BeforeValidator(_words)]
"""Words with commas between, or a list of them."""


class StudyOptions(BaseModel):
    """What a user asks for; what is left out follows the study's own default. Every field carries what it means."""

    model_config = ConfigDict(extra="forbid")

    study: str = _option("flips, modalities, why, looks, or the study of a file.", default="flips")
    agent: Several | None = _option(
        "Agent by its spec, or by the name that 'NAME=SPEC' gives it; may be repeated (flips: a cognitive model, "
        "human-inspired, llm:local and random)."
    )
    box: Box | None = _option("A box by name, random-N-SEED, or a TOML file (chain-4; several with commas between).")
    boxes: Whole | None = _option(
        "So many boxes instead: random-4-SEED from a seed of 1 on, those whose shortest plan has four steps, as "
        "chain-4's; with --box random-N, of N joints, 4 to 8 (none)."
    )
    p: Annotated[list[Number], Field(max_length=1000)] | None = _option(
        "Flip rates, how often reports are inverted (0,0.2,0.4,0.6; 0 to 0.6 by 0.1 with --full, --trials or "
        "--repetitions; 0.4 with why)."
    )
    trials: Whole | None = _option(
        "Trials per condition and box (in each repetition: 1; 10 with --full, or if --p or --repetitions is given; 50"
        " with why; 5 with several boxes)."
    )
    strategy_trials: Whole | None = _option(
        "Trials per condition and box for strategies, which cost nothing (100 in the short study, 150 with why, 20 "
        "with several boxes; else as --trials)."
    )
    until: str | None = _option(
        "Play until every difference is decided (shown to be an effect, or smaller than 10 points), or until each is "
        "known to ±10, or ±5, points; it stops there. This assumes an effect that does not drift meanwhile (all "
        "trials are played)."
    )
    most: Whole | None = _option("With --until: trials per condition at most (300).")
    repetitions: Whole | None = _option("Repetitions (3; 1 with why and with several boxes).")
    seed: Whole | None = _option("Seed of everything (1).")
    max_steps: Whole | None = _option("Budget of a trial in steps (20).")
    flip: FlipKind | None = _option(
        "What a false report is: re-observed, integrated, memoryless or transient, latched or sticky; independent, "
        "all positions; or outcome-only, without positions (re-observed)."
    )
    readings: Words | None = _option(
        "What a false report is, several readings side by side: fresh, kept (re-observed, integrated), all, or words "
        "of --flip (fresh,kept in the short study and with --full for strategies, which cost nothing; models play "
        "fresh)."
    )
    plant: Spec | None = _option(
        "What is acted on: a plant that lockprobe list plants lists, with options as in twin?looks=varied (flips: "
        "symbolic; modalities: fast-twin)."
    )
    modality: Several | None = _option(
        "How the box is shown: symbolic?tell=state, the states of the joints (flips); symbolic, also what attempts "
        "did; rgb, rgb?blur=8, rgbd?depth=height; may be repeated (modalities: rgb, rgbd, symbolic?tell=state)."
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
    parts: bool = _option(
        "Also play the parts of a false report, in reports that tell outcomes and positions (why).", default=False
    )
    full: bool = _option("The paper's 7 x 3 x 10 trials per agent (flips).", default=False)
    as_paper: bool = _option(
        "The paper's set-up, as far as it is known: states of all joints as JSON, labels and panel drawn once, no "
        "hypothesis, its numbers of trials; other options override (flips, modalities; docs/as-paper.md).",
        default=False,
    )
    name: str | None = _option("A name for the study, with which keys of records begin (the study's).")

    @property
    def specs(self) -> dict[str, list[str]]:
        """The specs that can name code, by option."""
        found: dict[str, Iterable[object]] = {
            "agent": named_agents(self.agent or ())[0],
            "condition": [one.spec for one in self.conditions_named],
            "sweep": self.sweep or (),
            "plant": [self.plant],
            "box": self.boxes_named,
        }
        return {what: [spec for spec in specs if isinstance(spec, str)] for what, specs in found.items()}

    @property
    def boxes_named(self) -> list[str | Path | Lockbox]:
        """The boxes that it names, each alone: a text may have several with commas between."""
        if isinstance(self.box, str):
            return [name.strip() for name in self.box.split(",")]
        return [] if self.box is None else [*self.box] if isinstance(self.box, list) else [self.box]

    @property
    def conditions_named(self) -> list[NamedCondition]:
        """Its conditions, those without a name too."""
        found = []
        for one in self.condition or ():
            if isinstance(one, str):
                name, spec = named_spec(one, "condition", "lies=flip?p=0.4")
                one = NamedCondition(spec=spec, name=name)  # noqa: PLW2901 - the same, parsed
            found.append(one)
        return found


def study_options(given: Mapping[str, Any]) -> StudyOptions:
    """Options given in Python or to another tool.

    Raises:
        UnknownName: If one does not exist; the message lists those that do.
        BadValue: If one has a value that it cannot have.
    """
    try:
        return StudyOptions.model_validate(given)
    except ValidationError as error:
        where = str(error.errors()[0]["loc"][0])
        if where not in StudyOptions.model_fields:
            raise UnknownName("option", where, StudyOptions.model_fields) from None
        raise refusal_of(error, where, given.get(where)) from None


def refusal_of(error: ValidationError, name: str, got: object) -> BadValue:
    """The first mistake in the value of an option, in one line; ``name`` is the option as its user calls it."""
    first = error.errors()[0]
    expected = plain(first["msg"]).removeprefix("expected ")
    if first["type"] == "literal_error":
        expected = "one of " + expected.replace("'", "").replace(" or ", ", ")
    return BadValue(name, got if len(str(got)) <= 1000 else f"{str(got)[:40]}…", expected)


def read_options_file(path: Path) -> StudyOptions:
    """The options in a TOML file: a user's, or one that ships (:data:`SHIPPED`), by its bare name.

    Raises:
        BadFile: If it is not one, with the key that is wrong.
    """
    if str(path) in SHIPPED and not path.exists():
        path = PRESETS / path.name
    try:
        options = StudyOptions.model_validate(read_toml(path))
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(map(str, first["loc"]))
        known = f"; keys are {', '.join(StudyOptions.model_fields)}" if first["type"] == "extra_forbidden" else ""
        raise BadFile(path, f"{where}: {plain(first['msg'])}{known}") from None
    if not options.model_fields_set - {"name"}:
        raise BadFile(path, 'says nothing to play: a study file has at least a line such as study = "flips"')
    for what, specs in options.specs.items():
        refuse_python(path, what, specs)
    return options


def parse_p(text: str) -> list[float]:
    """Flip probabilities from ``0,0.1,0.2``."""
    try:
        return [float(part) for part in text.split(",")]
    except ValueError:
        raise BadValue("p", text, "numbers from 0 to 1 with commas between, for example 0,0.2,0.4") from None
