"""The runtime of local models: llama.cpp through xllamacpp, in this process, on one thread.

It computes the exact probability of each allowed continuation of a text and generates no token: the logits of all other
tokens are pushed out of reach, which leaves the model's own distribution over the allowed ones. It agrees with the
renormalised softmax over the whole vocabulary to 2e-7.

Every trial starts from the same cached prefix, evaluated in one piece (:meth:`Engine.restart`), so probabilities are
bit-identical whatever was played before. llama.cpp gives slightly different numbers when the same tokens are evaluated
in pieces of another size.
"""

from __future__ import annotations

import json
import math
import os
import urllib.request
from collections.abc import Sequence
from functools import cache, partial
from pathlib import Path

from lockprobe.foundation.errors import BadFile, Missing, ModelFault

os.environ.setdefault("OMP_WAIT_POLICY", "passive")  # else the threads' barriers spin, and two workers crawl

try:
    import xllamacpp
except ImportError as error:
    if "libgomp" in str(error):
        raise Missing("local models need the system's libgomp.so.1", "apt-get install libgomp1") from error
    raise Missing("local models need the package xllamacpp", "pip install 'lockprobe[local]'") from error

_PULL = 100.0
"""Added to the logits of allowed tokens; any other is then e^100 times less likely than it was."""


class Engine:
    """One loaded model.

    Args:
        path: A GGUF file.
        context: Tokens that a prompt may have.

    Attributes:
        tokens: The tokens of a text.
        opening: The same at the beginning of a prompt, after the initial token that some models need.

    Raises:
        BadFile: If the file cannot be loaded.
    """

    def __init__(self, path: Path, *, context: int = 4096) -> None:
        self._path = path
        params = xllamacpp.CommonParams()
        params.model.path = str(path)
        params.n_ctx = context
        params.cpuparams.n_threads = params.cpuparams_batch.n_threads = 1
        params.flash_attn_type = params.cache_ram_mib = params.n_ctx_checkpoints = 0
        params.warmup = params.fit_params = False
        params.verbosity = -1
        try:
            self._server = xllamacpp.Server(params)
        except RuntimeError as error:
            raise BadFile(path, f"cannot be loaded by {self.runtime} ({error})") from None
        self.tokens = cache(self._tokens)
        self.opening = cache(partial(self._tokens, opening=True))
        self._constant: list[int] | None = None

    @property
    def runtime(self) -> str:
        """The runtime and its version, for the record."""
        return f"xllamacpp {xllamacpp.__version__}"

    def _tokens(self, text: str, *, opening: bool = False) -> tuple[int, ...]:
        asked = json.dumps({"content": text, "add_special": opening, "parse_special": False}).encode()
        request = urllib.request.Request(  # noqa: S310 - the runtime's own loopback address
            f"{self._server.listening_address}/tokenize", data=asked, headers={"Content-Type": "application/json"}
        )
        with urllib.request.urlopen(request, timeout=60) as answer:  # noqa: S310
            return tuple(json.loads(answer.read())["tokens"])

    def restart(self, constant: str) -> list[int]:
        """Reset the cache to the constant prefix, from which every trial begins, and return the prefix's tokens."""
        tokens = list(self.opening(constant))
        self._evaluate([*tokens, self.tokens("\n\n\n\n")[-1]], [0, 1], reuse=tokens == self._constant)
        self._constant = tokens
        return tokens

    def score(self, prompt: Sequence[int], options: Sequence[Sequence[int]]) -> list[float]:
        """The exact probability of each allowed continuation, given that one of them follows; they sum to 1.

        Prompt and options are tokens; no option may begin with another.

        Raises:
            BadFile: If the weights give numbers that are no probabilities.
            ModelFault: If the runtime does not answer.
        """
        if len(options) == 1:
            return [1.0]
        heads = list(dict.fromkeys(option[0] for option in options))
        share = dict(zip(heads, self._evaluate(prompt, heads) if len(heads) > 1 else [1.0], strict=True))
        result = [0.0] * len(options)
        for head in heads:
            inside = [i for i, option in enumerate(options) if option[0] == head]
            below = self.score([*prompt, head], [options[i][1:] for i in inside])
            for i, probability in zip(inside, below, strict=True):
                result[i] = share[head] * probability
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
                "logit_bias": [[token, _PULL] for token in allowed],
            }
        )
        if "choices" not in answer:
            raise ModelFault(f"the runtime answered {json.dumps(answer)[:300]}")
        found = {entry["id"]: entry["prob"] for entry in answer["choices"][0]["logprobs"]["content"][0]["top_probs"]}
        weights = [float(found.get(token) or 0.0) for token in allowed]
        total = sum(weights)
        if not 0 < total < math.inf:  # NaN is neither
            raise BadFile(self._path, "its weights give no probabilities, but numbers that are none: it is damaged")
        return [weight / total for weight in weights]
