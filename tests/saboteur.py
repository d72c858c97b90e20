"""Edits of a study directory as somebody makes them who wants its numbers otherwise and knows its files.

Every edited line gets the checksum, and every record the identity, that it would have.
"""

import json
from pathlib import Path

from lockprobe.foundation.storage.jsonl import with_checksum, without_checksum
from lockprobe.studies.options.settings import read_study


def lines(path, *, checksums=True):
    """The lines of a file as objects, without their checksums if they have any."""
    if not path.exists():
        return []
    return [json.loads(without_checksum(line) if checksums else line) for line in path.read_bytes().splitlines()]


def write(path, objects, *, checksums=True):
    """Write objects as the lines of a file."""
    made = (json.dumps(one, ensure_ascii=False, separators=(",", ":")).encode() for one in objects)
    path.write_bytes(b"".join((with_checksum(line) if checksums else line) + b"\n" for line in made))


class Evidence:
    """The files of a study in a directory.

    Attributes:
        records: ``trials.jsonl``, as objects; so are the calls, the requests and the clock readings.
    """

    def __init__(self, directory):
        self.directory = Path(directory)
        self.records, self.calls, self.asked = (
            lines(self.directory / f"{name}.jsonl") for name in ("trials", "calls", "asked")
        )
        self.timings = lines(self.directory / "timings.jsonl", checksums=False)
        self.settings = json.loads((self.directory / "study.json").read_text("utf-8"))

    def save(self):
        """Write all of them back."""
        (self.directory / "study.json").write_text(json.dumps(self.settings, indent=2), "utf-8")
        study = read_study(self.directory)
        identities = {one.label: study.record_identity(one) for one in study.conditions}
        last = [{name: record[name] for name in record if name != "identity"} for record in self.records]
        named = [record | {"identity": identities[record["condition"]]} for record in last]
        write(self.directory / "trials.jsonl", named)
        for name in ("calls", "asked"):
            if (objects := getattr(self, name)) or (self.directory / f"{name}.jsonl").exists():
                write(self.directory / f"{name}.jsonl", objects)
        write(self.directory / "timings.jsonl", self.timings, checksums=False)

    def of(self, agent, ending=None):
        """The records of an agent, those that ended so if that is given."""
        return [one for one in self.records if one["agent"] == agent and ending in (None, one["ending"])]

    def calls_of(self, record):
        """The calls of a trial, oldest first."""
        return [call for call in self.calls if call["key"] == record["key"]]

    def drop(self, keep, *files):
        """Drop the lines of some files whose key is not to be kept."""
        for name in files:
            setattr(self, name, [one for one in getattr(self, name) if keep(one["key"])])


def relabelled(record, *, steps=None):
    """A failure relabelled as a trial whose agent gave no usable reply, in a step in which it gave one."""
    cut = len(record["steps"]) - 1 if steps is None else steps
    replies = record["steps"][cut]["decision"].get("replies", [])
    del record["steps"][cut:]
    record["changed"] = {spec: min(steps, cut) for spec, steps in record.get("changed", {}).items()}
    record["changed_steps"] = min(record.get("changed_steps", 0), cut)
    record["ending"] = "error"
    record["error"] = {
        "boundary": "reply",
        "message": f"no usable reply in {len(replies)} turns: not one JSON object",
        "step": cut + 1,
        "replies": replies,
        "usage": {"calls": len(replies), "input_tokens": 11 * len(replies), "output_tokens": 5 * len(replies)},
    }


def played_by(record, trial):
    """The steps and the ending of another trial under the name of this one's agent, with its words and costs."""
    decisions = [step["decision"] for step in record["steps"]]
    record["steps"] = trial["steps"]
    record["ending"] = trial["ending"]
    record.pop("error", None)
    for step, decision in zip(record["steps"], [*decisions, *decisions[-1:] * len(trial["steps"])], strict=False):
        step["decision"] = decision | {
            "joint": step["decision"]["joint"],
            "claimed": step["decision"].get("claimed"),
        }
        if step["decision"]["claimed"] is None:
            del step["decision"]["claimed"]


def reply_of(decision):
    """The reply that gives a decision."""
    said = {"moved": "moved", "blocked": "did not move", None: "none"}[decision.get("claimed")]
    return json.dumps({"last_action": said, "hypothesis": decision.get("hypothesis", ""), "joint": decision["joint"]})


def flipped(decision):
    """Make it claim the opposite."""
    decision["claimed"] = {"moved": "blocked", "blocked": "moved"}[decision["claimed"]]
