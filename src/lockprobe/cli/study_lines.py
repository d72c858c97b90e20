"""What is said of a study before its first trial."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

from lockprobe.foundation.formatting import count
from lockprobe.plants.catalogue import resolve_plant
from lockprobe.studies.decisions import LOOK_EVERY
from lockprobe.studies.records.directory import read_study
from lockprobe.studies.records.journal import Journal
from lockprobe.studies.study import Study

_LOOKS = (
    f"After every {LOOK_EVERY} blocks it looks what is decided. A decision holds however often it looks; conditions "
    "that are decided are no longer played."
)


def begin_lines(study: Study, journal: Journal, owed: int) -> Iterator[str]:
    """What will be played, where it goes, and what of it is done."""
    run, done = study.size - study.invited, done_of(journal, study)
    if run:
        kind = {"flips": "Flip study", "modalities": "Modality study"}.get(study.name, "") if study.of_flips else ""
        yield (
            f"{kind or f'Study {study.name}'} on {study.boxes_in_words}: {_conditions(study)}; {_extent(study)} of "
            f"{study.max_steps} steps; agents {', '.join(study.labels)}; seed {study.seed}"
        )
        if study.simulated:
            source = resolve_plant(study.plant)
            drawn = study.has_pictures and owed and source.picture_size is not None
            yield f"Plant: {study.plant}" + (f"; pictures by {source.renderer()}" if drawn else "")
        elif study.name == "modalities":
            yield "Plant: symbolic, which has no camera: pictures are left out (--plant fast-twin has one)"
        if reading := [study.label_of(one) for one in study.agents if study.modalities_of(one) != study.modalities]:
            yield f"Reports only, since they look at no pictures: {', '.join(reading)}"
    if study.invited:
        played = sum(not trial.owed_again for trial in journal.trials.values() if trial.player)
        said = f"People: {played} of {count(study.invited, 'trial')} played; they are not run but invited, by"
        yield f"{said} lockprobe serve {journal.directory}"
    if not run:
        return
    yield f"Records: {journal.directory} (the same command resumes it)"
    yield settings_line(read_study(journal.directory).settings_hash)
    if study.until:
        yield f"{done} trials are done already; {owed} are owed before the next look" if done else _LOOKS
    elif done:
        yield f"{done} of {run} trials are done already; {owed} are owed"
    elif study.shard:
        yield f"{owed} of {replace(study, shard=None).size - study.invited} trials are played here"


def done_of(journal: Journal, study: Study | None = None) -> int:
    """The finished trials; with a study, those that it runs, without those of people."""
    return sum(
        not one.owed_again and (study is None or one.spec in study.run_agents) for one in journal.trials.values()
    )


def _extent(study: Study) -> str:
    """How many trials are played."""
    if study.until:
        return f"until {study.until}, at most {count(study.repetitions * study.trials, 'trial')} per condition,"
    apart = f" ({study.strategy_trials} for strategies)" if study.strategy_trials is not None else ""
    return f"{count(study.repetitions, 'repetition')} of {count(study.trials, 'trial')}{apart}"


def _conditions(study: Study) -> str:
    """How the box is shown, and how often reports are false, as far as the study varies it."""
    if not study.of_flips:
        return f"{count(len(study.conditions), 'condition')}: {'; '.join(one.label for one in study.conditions)}"
    p = f"flip rate {', '.join(f'{p:g}' for p in study.p)}"
    if not study.has_pictures:
        return p
    shown = f"shown as {', '.join(study.modalities)}"
    return f"{shown}; {p}" if any(study.p) else shown


def settings_line(found: str) -> str:
    """The hash of the settings, as it is said before the first trial."""
    return f"Settings: {found} (for a preregistration; lockprobe verify DIR --settings HASH checks it)"


def in_boundaries(errors: Mapping[str, int]) -> str:
    """Errors by boundary: ``3 errors: model 2, reply 1``; empty where there are none."""
    if not (number := sum(errors.values())):
        return ""
    return f"{count(number, 'error')}: {', '.join(f'{name} {errors[name]}' for name in sorted(errors))}"
