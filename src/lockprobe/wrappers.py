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
import secrets
import string
from collections.abc import Callable, Sequence
from copy import deepcopy
from hashlib import sha256
from pathlib import Path
from typing import Any, TypedDict, Unpack

from lockprobe.foundation.errors import BadFile, BadValue, needing
from lockprobe.foundation.inputs import is_there, read_input
from lockprobe.foundation.storage.atomic_file import append_whole
from lockprobe.foundation.validation import check_function, check_number
from lockprobe.interventions import asked_and_done, told
from lockprobe.interventions.flip import OutcomeFlip, While
from lockprobe.trial.luck import Luck
from lockprobe.trial.places import Places
from lockprobe.trial.record import Moment, Percept, Task

with needing("the wrappers", "gym"):
    import gymnasium
    from gymnasium import spaces
    from gymnasium.utils import RecordConstructorArgs

__all__ = ["Delay", "FalseReports", "Record", "Tremble", "Withhold"]

Environment = gymnasium.Env[Any, Any]

LONGEST = 1000
"""The most characters of an action and of a statement, and by how many observations that are texts may grow."""


class Telling(TypedDict, total=False):
    """The options of all wrappers that act on what is told; of nested ones, the innermost has to have ``outcome``.

    ``tell`` makes of an observation, the true statement and what is told, or None, what the agent observes: by default
    a text that says it in place of the true statement, or as a sentence more.
    """

    outcome: Callable[[Any, Any, Any], tuple[str, str] | None]
    tell: Callable[[Any, str | None, str | None], Any]


class _Wrapper(gymnasium.Wrapper[Any, Any, Any, Any], RecordConstructorArgs):
    """One of nested wrappers: the outermost plays with the laws of all; making it changes none inside it.

    To a law a step is an attempt of the action as a joint. It moved where what is told is true, and was blocked where
    it is false.
    """

    only = "any"
    choice = Task(joints=(), target="", budget=0)

    def __init__(self, env: Environment, law: Any, **settings: Any) -> None:
        RecordConstructorArgs.__init__(self, _disable_deepcopy=True, **settings)
        super().__init__(env)
        inside = env.lockprobe_wrappers if isinstance(env, _Wrapper) else ()
        if not inside and env.has_wrapper_attr("lockprobe_wrappers"):
            raise BadValue(type(self).__name__, env, "Lockprobe's wrappers directly around each other")
        self.lockprobe_wrappers: tuple[_Wrapper, ...] = (*inside, self)
        self.law, self.bare = law, inside[0].env if inside else env
        self.box = type(self.unwrapped).__name__ if self.unwrapped.spec is None else self.unwrapped.spec.id
        self.teller = next((one for one in self.lockprobe_wrappers if isinstance(one, _Telling)), None)
        self._records = [one for one in self.lockprobe_wrappers if isinstance(one, Record)]
        self._acting = [one for one in self.lockprobe_wrappers if one.law is not None]
        self._places = Places([one.law for one in self._acting])
        lags = [one.law.lag for one in self._acting if isinstance(one, Delay) and one.law.lag > 0]
        self._lag = lags[-1] if lags else 0  # each begins with the truth
        self._luck = Luck(seed=secrets.randbelow(2**31), box=self.box, repetition=1, trial=0)
        self._past, self._named, self._seen = list[Moment](), list[tuple[str, str] | None](), None

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Begin an episode; the very first one is given a seed if it has none, so that it can be repeated."""
        last = self._luck
        luck = last.but(trial=last.trial + 1) if seed is None else last.but(seed=seed, trial=1)
        for record in self._records:
            record.begins(luck)
        observation, info = self.bare.reset(seed=luck.seed if luck.trial == 1 else None, options=options)
        self._luck, self._past, self._named = luck, [Moment(was=Percept(), told=Percept())], []
        return self._observed(observation, info, None, None)

    def step(self, action: Any) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        """Act, and be told what that brought about."""
        step, past, done = len(self._past), tuple(self._past), action
        for law in self._places.at["done"]:
            chosen, choice = str(int(done)), self._acting[law.number].choice
            slipped = law.act(chosen, past, choice, self._luck.at(law.stream, step))
            done = done if slipped == chosen else int(slipped)
        observation, reward, terminated, truncated, info = self.bare.step(done)
        named = None if self.teller is None else self.teller.outcome(self._seen, done, observation)
        texts = isinstance(named, tuple) and [*map(type, named)] == [str, str]
        if named is not None and not (texts and named[0] != named[1] and max(map(len, named)) <= LONGEST):
            raise BadValue("outcome", named, f"two different texts of at most {LONGEST} characters, the true one first")
        self._named.append(named)
        late = self._named[-1 - self._lag] if step > self._lag else None
        report = was = Percept(joint=str(_plain(done)), outcome=None if named is None else "moved")
        for law in self._places.at["told"]:
            by = self._acting[law.number]
            if by.only in ("any", _said(report, late)):
                report = law.act(report, past, by.choice, self._luck.at(law.stream, step))
        self._past.append(Moment(was=was, told=report, attempted=was.joint))
        truth, heard = _said(was, named), _said(report, late)
        row: dict[str, Any] = {"seed": self._luck.seed, "episode": self._luck.trial, "step": step}
        row |= {"action": _plain(action), "done": _plain(done)}
        row |= {"told": heard, "told_falsely": report.outcome == "blocked", "outcome": truth}
        for record in self._records:
            record.notes(row, float(reward), terminated, truncated, info)
        shown, info = self._observed(observation, info, truth, heard)
        return shown, reward, terminated, truncated, info

    def _observed(self, seen: Any, info: dict[str, Any], truth: str | None, heard: str | None) -> tuple[Any, Any]:
        """What the agent observes; what was seen is kept, as an environment may change it in place."""
        if self.teller is None:
            return seen, info
        self._seen = deepcopy(seen)
        shown = seen if self.teller.tell is None else self.teller.tell(seen, truth, heard)
        return shown, {**info, "told": heard}


def _said(report: Percept, named: tuple[str, str] | None) -> str | None:
    """What a report says: the first of the two texts of an outcome, or falsely the second."""
    return named[report.outcome == "blocked"] if named and report.outcome else None


def _plain(action: Any) -> Any:
    """An action as a record has it: a number or a text; of any other its JSON, and at the end of a long one a hash."""
    plain = action.tolist() if hasattr(action, "tolist") else action
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

    def __init__(self, env: Environment, law: Any, settings: Any, *, outcome: Any = None, tell: Any = None) -> None:
        super().__init__(env, law, outcome=outcome, tell=tell, **settings)
        self.outcome, self.tell, teller, seen = outcome, tell, self.teller or self, env.observation_space
        if teller is not self:
            if not {outcome, tell} <= {None, teller.outcome, teller.tell}:
                raise BadValue(f"outcome and tell of {type(self).__name__}", (outcome, tell), f"those of {teller}")
            return
        check_function("outcome", outcome, 3)
        check_function("tell", tell or _in_words, 3)
        if isinstance(seen, spaces.Text):
            self.tell = tell or _in_words
            letters = seen.character_set | frozenset(string.printable)
            self.observation_space = spaces.Text(seen.max_length + LONGEST, min_length=0, charset=letters)


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
        law = OutcomeFlip(p=p, at=tuple(at), while_=while_)
        super().__init__(env, law, {"p": p, "only": only, "at": at, "while_": while_}, **given)
        self.only = only


class Withhold(_Telling):
    """With probability p nothing is told, as by ``drop``; with ``luck="flip"`` where false reports of that p are."""

    def __init__(
        self, env: Environment, p: float, *, at: Sequence[int] = (), luck: told.Luck = "own", **given: Unpack[Telling]
    ) -> None:
        super().__init__(env, told.Drop(p=p, at=tuple(at), luck=luck), {"p": p, "at": at, "luck": luck}, **given)


class Delay(_Telling):
    """The truth of ``lag`` steps ago is told, and before it nothing, as by ``delay``; lies told inside it are lost."""

    def __init__(self, env: Environment, lag: int = 1, **given: Unpack[Telling]) -> None:
        super().__init__(env, told.Delay(lag=lag), {"lag": lag}, **given)


class Tremble(_Wrapper):
    """With probability p, ``at`` some steps or all, another ``Discrete`` action is done, as by ``tremble``."""

    def __init__(self, env: Environment, p: float, *, at: Sequence[int] = ()) -> None:
        super().__init__(env, asked_and_done.Tremble(p=p, at=tuple(at)), p=p, at=at)
        actions = env.action_space
        if not isinstance(actions, spaces.Discrete) or actions.n < 2:
            raise BadValue("actions of Tremble", actions, "Discrete, and two of them or more")
        self.choice = Task(joints=tuple(str(actions.start + at) for at in range(actions.n)), target="", budget=0)


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
        names = {"agent": agent, "condition": condition, "task": task}
        super().__init__(env, None, path=path, solved=solved, score=score, **names)
        self._path, self._solved, self._score = Path(path), solved, score
        self._names = names | {"task": task or self.box}
        self._rows, self._total, self._held = list[dict[str, Any]](), 0.0, set[tuple[int, int]]()
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
