"""Interventions on anyone's Gymnasium environment: false, missing and late reports, a trembling hand, and a record.

What a step brought about is named by ``outcome``. Of the observation before a step, the action that reached the
environment and the observation after it, it makes two texts, the true statement and its opposite, or None where there
is nothing to tell. What is told stands in ``info["told"]``, None where nothing is, and in observations that are texts;
all else that an observation shows is true. The truth reaches no agent: :class:`Record` has it, beside what was told.

The wrappers nest in any order, each directly around the other, and act from the inside to the outside by the laws of
studies (:mod:`lockprobe.interventions`). Their luck has an address (:mod:`lockprobe.trial.luck`): the id of the
environment, the seed of ``reset``, the episode since then, and the step. So a seed has the same false reports whatever
acts beside them, and those at a smaller p are among those at a larger one. The environment draws its own luck; with a
seed for each episode, episodes of equal seeds begin alike under all conditions.
"""

from __future__ import annotations

import json
import string
from collections.abc import Callable, Iterable, Sequence
from copy import deepcopy
from dataclasses import dataclass, field, replace
from hashlib import sha256
from pathlib import Path
from typing import Any, Literal, NamedTuple, TypedDict, Unpack

import numpy as np

from lockprobe.foundation.errors import BadFile, BadValue, needing
from lockprobe.foundation.inputs import is_there, read_input
from lockprobe.foundation.storage.atomic_file import append_whole
from lockprobe.foundation.validation import check_function, check_number, check_whole
from lockprobe.interventions import asked_and_done, told
from lockprobe.interventions.flip import OutcomeFlip, While
from lockprobe.trial.luck import Luck
from lockprobe.trial.record import Moment, Percept, Task

with needing("the wrappers", "gym"):
    import gymnasium
    from gymnasium import spaces
    from gymnasium.error import ResetNeeded
    from gymnasium.utils import RecordConstructorArgs

__all__ = ["Delay", "FalseReports", "Record", "Tremble", "Withhold"]

Environment = gymnasium.Env[Any, Any]

LONGEST = 1000
"""The most characters of a name, an action and a statement, and by how many observations that are texts may grow."""


class Telling(TypedDict, total=False):
    """The options of all wrappers that act on what is told; of nested ones, the innermost has to have ``outcome``.

    ``tell`` makes of an observation, the true statement and what is told, or None, what the agent observes: by default
    a text that says it in place of the true statement, or as a sentence more.
    """

    outcome: Callable[[Any, Any, Any], tuple[str, str] | None]
    tell: Callable[[Any, str | None, str | None], Any]


class _Report(NamedTuple):
    """What is told of an action, by its label: the first of the two texts of its outcome, or falsely the second."""

    action: str = ""
    outcome: tuple[str, str] | None = None
    falsely: bool = False

    @property
    def told(self) -> str | None:
        return None if self.outcome is None else self.outcome[self.falsely]


@dataclass(slots=True)
class _Episode:
    """An episode: its luck, its last observation, its steps as interventions take them, and their true reports."""

    luck: Luck
    seen: Any = None
    past: list[Moment] = field(default_factory=lambda: [Moment(was=Percept(), told=Percept())])
    truths: list[_Report] = field(default_factory=list)


class _Wrapper(gymnasium.Wrapper[Any, Any, Any, Any], RecordConstructorArgs):
    """One of nested wrappers: the outermost plays and asks each for its part; making it changes none inside it."""

    def __init__(self, env: Environment, **settings: Any) -> None:
        if not isinstance(env, gymnasium.Env):
            raise BadValue("env", type(env).__name__, "one environment; SyncVectorEnv makes many of wrapped ones")
        inside = env.lockprobe_wrappers if isinstance(env, _Wrapper) else ()
        if not inside and env.has_wrapper_attr("lockprobe_wrappers"):
            raise BadValue(type(self).__name__, env, "Lockprobe's wrappers directly around each other")
        if not isinstance(settings.get("at", ()), Iterable):
            raise BadValue("at", settings["at"], "a list of the numbers of steps, from 1")
        RecordConstructorArgs.__init__(self, _disable_deepcopy=True, **settings)
        super().__init__(env)
        self.lockprobe_wrappers: tuple[_Wrapper, ...] = (*inside, self)
        self.bare: Environment = inside[0].env if inside else env
        self.box = type(self.unwrapped).__name__ if self.unwrapped.spec is None else self.unwrapped.spec.id
        self.teller = next((one for one in self.lockprobe_wrappers if isinstance(one, _Telling)), None)
        self.nth = sum(type(one) is type(self) for one in inside)
        self._episode: _Episode | None = None

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Begin an episode; the very first one is given a seed if it has none, so that it can be repeated."""
        check_whole("seed", 0 if seed is None else seed, 0)
        if seed is None and self._episode is not None:
            luck = self._episode.luck.but(trial=self._episode.luck.trial + 1)
        else:
            seed = int(np.random.default_rng().integers(2**31) if seed is None else seed)
            luck = Luck(seed=seed, box=self.box, repetition=1, trial=1)
        for one in self.lockprobe_wrappers:
            one.begins(luck)
        observation, info = self.bare.reset(seed=seed, options=options)
        self._episode = _Episode(luck)
        return self._observed(self._episode, observation, info, _Report(), _Report())

    def step(self, action: Any) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        """Act, and be told what that brought about."""
        episode, done = self._episode, action
        if episode is None:
            raise ResetNeeded("no episode is under way: call reset()")
        for one in self.lockprobe_wrappers:
            done = one.does(done, episode)
        observation, reward, terminated, truncated, info = self.bare.step(done)
        named = None if self.teller is None else self.teller.names(episode.seen, done, observation)
        report = truth = _Report(str(_plain(done)), named)
        episode.truths.append(truth)
        for one in self.lockprobe_wrappers:
            report = one.tells(report, episode)
        place = {"seed": episode.luck.seed, "episode": episode.luck.trial, "step": len(episode.past)}
        acts, falsely = {"action": _plain(action), "done": _plain(done)}, report.falsely and report.told is not None
        row = {**place, **acts, "told": report.told, "told_falsely": falsely, "outcome": truth.told}
        for one in self.lockprobe_wrappers:
            one.notes(row, float(reward), terminated, truncated, info)
        episode.past.append(replace(episode.past[0], attempted=truth.action))
        shown, info = self._observed(episode, observation, info, truth, report)
        return shown, reward, terminated, truncated, info

    def _observed(self, episode: _Episode, seen: Any, info: Any, truth: _Report, report: _Report) -> tuple[Any, Any]:
        """What the agent observes; what was seen is kept, as an environment may change it in place."""
        if self.teller is None:
            return seen, info
        episode.seen = deepcopy(seen)
        shown = seen if self.teller.tell is None else self.teller.tell(seen, truth.told, report.told)
        if shown is not seen and shown not in self.observation_space and seen in self.bare.observation_space:
            raise BadValue("told", shown, f"an observation in {self.observation_space}")
        return shown, {**info, "told": report.told}

    def begins(self, luck: Luck) -> None: ...

    def does(self, action: Any, episode: _Episode) -> Any:
        return action

    def tells(self, report: _Report, episode: _Episode) -> _Report:
        return report

    def notes(self, row: dict[str, Any], reward: float, terminated: bool, truncated: bool, info: Any) -> None: ...


def _plain(action: Any) -> Any:
    """An action as a record has it: a number or a text; of any other its JSON, and at the end of a long one a hash."""
    plain = action.tolist() if isinstance(action, np.ndarray | np.generic) else action
    if not isinstance(plain, str | int | float):
        plain = json.dumps(plain, default=lambda part: getattr(part, "tolist", part.__str__)())
    long = isinstance(plain, str) and len(plain) > LONGEST
    return f"{plain[:900]}…{sha256(plain.encode('utf-8', 'replace')).hexdigest()}" if long else plain


def _in_words(observation: str, truth: str | None, said: str | None) -> str:
    """A text with what is told in place of the true statement, where that stands last, or as a sentence more."""
    if truth and truth in observation:
        before, _, behind = observation.rpartition(truth)
        return f"{before}{said or ''}{behind}"
    end = "" if said is None or said.endswith((".", "!", "?")) else "."
    return f"{observation} {said[0].upper()}{said[1:]}{end}".strip() if said else observation


class _Telling(_Wrapper):
    """Acts on what is told. The innermost of them names the outcome and says how the agent is told."""

    law: OutcomeFlip | told.Drop
    only = "any"

    def __init__(self, env: Environment, given: Telling, **settings: Any) -> None:
        for name in given.keys() - Telling.__annotations__.keys():
            raise BadValue(type(self).__name__, name, "only, at, while_, outcome or tell: no joint has a position here")
        super().__init__(env, **given, **settings)
        self.given, teller = given, self.teller or self
        if given.items() - teller.given.items():
            raise BadValue(type(self).__name__, sorted(given), f"what {type(teller).__name__} has, which is inside it")
        for name, function in ({"outcome": None} | teller.given).items():
            check_function(name, function, 3)
        self.tell, seen = given.get("tell"), env.observation_space
        if teller is self and isinstance(seen, spaces.Text):
            self.tell = self.tell or _in_words
            letters = seen.character_set | frozenset(string.printable)
            self.observation_space = spaces.Text(seen.max_length + LONGEST, min_length=0, charset=letters)

    def names(self, before: Any, action: Any, after: Any) -> tuple[str, str] | None:
        """What a step brought about, and its opposite."""
        named = self.given["outcome"](before, action, after)
        texts = isinstance(named, tuple) and [*map(type, named)] == [str, str]
        if named is not None and not (texts and named[0] != named[1] and max(map(len, named)) <= LONGEST):
            raise BadValue("outcome", named, f"two different texts of at most {LONGEST} characters, the true one first")
        return named

    def tells(self, report: _Report, episode: _Episode) -> _Report:
        """What the law makes of a report, in which ``moved`` is a statement that it may act on."""
        if report.outcome is None:
            return report
        outcome: Literal["moved", "blocked"] = "moved" if self.only in ("any", report.told) else "blocked"
        percept, task = Percept(joint=report.action, outcome=outcome), Task(joints=(), target="", budget=0)
        luck = episode.luck.at(f"{self.law.stream}-{self.nth}", len(episode.past))
        heard = self.law.perceive(percept, tuple(episode.past), task, luck).outcome
        return report._replace(falsely=report.falsely ^ (heard != outcome)) if heard else report._replace(outcome=None)


class FalseReports(_Telling):
    """With probability p the opposite of what happened is told, as by ``flip`` of outcomes.

    ``only`` is the true statement that is told falsely, any by default; ``at`` are the steps, from 1, whose reports can
    be false, all by default; with ``while_="looping"`` only the report of an action that continues an action loop can.
    """

    def __init__(
        self,
        env: Environment,
        p: float,
        *,
        only: str = "any",
        at: Sequence[int] = (),
        while_: While = "always",
        **given: Unpack[Telling],
    ) -> None:
        super().__init__(env, given, p=p, only=only, at=at, while_=while_)
        self.only = only
        self.law = OutcomeFlip(p=p, only="any" if only == "any" else "moved", at=tuple(at), while_=while_)


class Withhold(_Telling):
    """With probability p nothing is told, as by ``drop``; with ``luck="flip"`` where false reports of that p are."""

    def __init__(
        self, env: Environment, p: float, *, at: Sequence[int] = (), luck: told.Luck = "own", **given: Unpack[Telling]
    ) -> None:
        super().__init__(env, given, p=p, at=at, luck=luck)
        self.law = told.Drop(p=p, at=tuple(at), luck=luck)


class Delay(_Telling):
    """The truth of ``lag`` steps ago is told, and before it nothing, as by ``delay``; lies told inside it are lost."""

    def __init__(self, env: Environment, lag: int = 1, **given: Unpack[Telling]) -> None:
        super().__init__(env, given, lag=lag)
        self._lag = told.Delay(lag=lag).lag

    def tells(self, report: _Report, episode: _Episode) -> _Report:
        """The late report, or none yet."""
        return ([_Report()] * self._lag + episode.truths)[len(episode.truths) - 1] if self._lag else report


class Tremble(_Wrapper):
    """With probability p, ``at`` some steps or all, another ``Discrete`` action is done, as by ``tremble``."""

    def __init__(self, env: Environment, p: float, *, at: Sequence[int] = ()) -> None:
        super().__init__(env, p=p, at=at)
        actions = env.action_space
        if not isinstance(actions, spaces.Discrete) or actions.n < 2:
            raise BadValue("actions of Tremble", actions, "Discrete, and two of them or more")
        self._law = asked_and_done.Tremble(p=p, at=tuple(at))
        self._task = Task(joints=tuple(str(actions.start + at) for at in range(actions.n)), target="", budget=0)

    def does(self, action: Any, episode: _Episode) -> Any:
        """The action, or another one."""
        luck = episode.luck.at(f"{self._law.stream}-{self.nth}", len(episode.past))
        done = self._law.act(str(int(action)), tuple(episode.past), self._task, luck)
        return action if done == str(int(action)) else int(done)


class Record(_Wrapper):
    """Appends the steps of an episode to a file of JSON lines when it ends; ``lockprobe report`` reads the file.

    A row has the three names (``task`` is by default the id of the environment), ``seed, episode, step, action, done``
    (what reached the environment), ``told, told_falsely`` (whether that is the opposite of the truth) and ``outcome``
    (the truth). The last row has ``solved``, by default whether the episode terminated with a positive reward, and
    ``score``, in [0, 1], if a function makes it of the sum of rewards; neither if the next reset came first, so limit
    steps by ``gymnasium.make(max_episode_steps=…)``. What is under way when a process stops is not written.
    """

    def __init__(
        self,
        env: Environment,
        path: str | Path,
        *,
        agent: str,
        condition: str,
        task: str = "",
        solved: Callable[[float, bool, dict[str, Any]], bool] = lambda reward, end, _: end and reward > 0,
        score: Callable[[float], float] | None = None,
    ) -> None:
        super().__init__(env, path=path, solved=solved, score=score, agent=agent, condition=condition, task=task)
        self._path, self._solved, self._score = Path(path), solved, score
        self._names = {"agent": agent, "condition": condition, "task": task or self.box}
        self._rows, self._total, self._held = list[dict[str, Any]](), 0.0, set[tuple[int, int]]()
        check_function("solved", solved, 3)
        check_function("score", score or float, 1)
        for name, given in self._names.items():
            if str(given).encode("utf-8", "replace").decode()[:LONGEST] != given:
                raise BadValue(name, given, f"a text of at most {LONGEST} characters of UTF-8")
        for number, line in enumerate(read_input(self._path).splitlines() if is_there(self._path) else (), 1):
            try:
                row = json.loads(line.strip() or b"{}")
                if row.items() >= self._names.items():
                    self._held.add((row["seed"], row["episode"]))
            except (AttributeError, KeyError, TypeError, ValueError, RecursionError):
                why = f"line {number}: got {line.decode(errors='replace')!r:.80}, expected JSON with seed and episode"
                raise BadFile(self._path, f"{why}: delete it with its episode, which is then played again") from None

    def holds(self, seed: int, episode: int = 1) -> bool:
        """Whether the file held this episode under these names when the wrapper was made."""
        return (seed, episode) in self._held

    def begins(self, luck: Luck) -> None:
        """Write the steps of an episode that did not end, and refuse one that is there."""
        self._write()
        if self.holds(luck.seed, luck.trial):
            expected = f"one that {self._path} does not hold (env.holds(seed) tells)"
            raise BadValue("episode", f"{luck.trial} of seed {luck.seed}", expected)

    def notes(self, row: dict[str, Any], reward: float, terminated: bool, truncated: bool, info: Any) -> None:
        """Keep a step, and write all of them after the last one."""
        self._total += reward
        self._rows.append({**self._names, **row})
        if terminated or truncated:
            self._rows[-1]["solved"] = bool(self._solved(reward, terminated, info))
            if self._score is not None:
                check_number("score", score := self._score(self._total))
                self._rows[-1]["score"] = float(score)
            self._write()

    def _write(self) -> None:
        rows = "".join(f"{json.dumps(row, ensure_ascii=False)}\n" for row in self._rows)
        append_whole(self._path, rows.encode("utf-8", "replace"))
        self._rows, self._total = [], 0.0
