"use strict";
// One trial told two ways, the order of the list of agents, and what a link or a printer unfolds.
// Data come from agents: they become text, never markup.
(() => {
  const $ = (name) => document.getElementById(name);
  const all = () => document.querySelectorAll("details");
  addEventListener("beforeprint", () => all().forEach((one) => { one.open = true; }));
  const unfold = () => {
    const found = location.hash && $(decodeURIComponent(location.hash.slice(1)));
    for (let at = found; at; at = at.parentElement) if (at.tagName === "DETAILS") at.open = true;
    if (found) found.scrollIntoView();
  };
  addEventListener("hashchange", unfold);
  unfold();

  const rows = $("rows"), bar = document.querySelector(".bar");
  if (rows && bar) {
    bar.hidden = false;
    bar.addEventListener("click", ({ target }) => {
      const key = target.dataset.k;
      if (!key) return;
      bar.querySelectorAll("button").forEach((one) => one.setAttribute("aria-pressed", String(one === target)));
      const of = (row) => Number(row.dataset[key] ?? -9);
      rows.append(...[...rows.children].sort((a, b) => (key === "name" ? a.dataset.name.localeCompare(b.dataset.name, "en", { numeric: true }) : of(b) - of(a))));
    });
    bar.querySelector("button").click(); // by change: who solves more stands first, who solves fewer last
  }

  const home = $("explorer"), source = $("trials-data");
  const data = source && source.textContent.trim() ? JSON.parse(source.textContent) : { trials: [] };
  if (!home || !data.trials.length) return;
  for (const one of data.trials) { // what is left out repeats what is there
    one.told ??= one.moved;
    one.said ??= ` ${one.told}`;
    one.loop ??= "";
  }
  home.hidden = false;
  const make = (tag, name = "", text = "") => {
    const element = document.createElement(tag);
    if (name) element.className = name;
    if (text) element.textContent = text;
    return element;
  };
  const called = (joint, one) => data.boxes[one.b ?? 0].joints[joint.charCodeAt(0) - 65];
  const outcome = { 1: "moved", 0: "was blocked", "-": "did nothing that was told" };
  const told = { 1: "moved", 0: "blocked", "-": "nothing" };
  const lies = (trial, i) => trial.told[i] !== "-" && trial.told[i] !== trial.moved[i];
  const corrected = (trial, i) => (trial.back?.[i] ?? "0") === "1";
  const misread = (trial, i) => "10".includes(trial.said[i + 1] ?? "-") && trial.said[i + 1] !== trial.told[i];
  const end = (trial) => (trial.solved ? `opened at step ${trial.did.length}` : `not opened in ${trial.did.length} steps`);
  const number = (trial) => (trial.person ? `person ${trial.person}, ` : "") + `${trial.r}.${trial.n}` + (data.boxes.length > 1 ? `, ${data.boxes[trial.b ?? 0].name}` : "");
  const agent = $("agent"), left = $("left"), right = $("right"), which = $("which"), slider = $("step");
  const fill = (select, values, names, kept) => {
    select.replaceChildren(...values.map((value, i) => { const one = make("option", "", names[i]); one.value = value; return one; }));
    if (values.includes(kept)) select.value = kept;
    select.closest("label").hidden = values.length < 2;
  };
  const conditions = (a) => [...new Set(data.trials.filter((one) => one.a === a).map((one) => one.c))].sort((x, y) => x - y);
  const under = (c) => (data.conditions[c] === "told the truth" ? "when told the truth" : `with ${data.conditions[c]}`);
  const key = (one) => `${one.r} ${one.n}`;

  // Pairs of trials of equal luck: one agent under two conditions, or, of a single condition, each trial alone.
  let pairs = [], pair = [], parted = 0;
  const collect = () => {
    const a = Number(agent.value), [c, d] = [Number(left.value), Number(right.value)];
    const second = new Map(data.trials.filter((one) => one.a === a && one.c === d && c !== d).map((one) => [key(one), one]));
    const first = data.trials.filter((one) => one.a === a && one.c === c);
    pairs = first.filter((one) => second.has(key(one))).map((one) => [one, second.get(key(one))]);
    if (!pairs.length) pairs = first.map((one) => [one]);
    const only = [0, 1].map((side) => pairs.filter((two) => two.length > 1 && two[side].solved && !two[1 - side].solved));
    const apart = pairs.filter((two) => two.length > 1 && two[0].did !== two[1].did);
    const typical = [only[1].length > only[0].length ? only[1] : only[0], apart, pairs].find((some) => some.length);
    const middle = (side) => typical.map((two) => two[side]?.did.length ?? 0).sort((x, y) => x - y)[typical.length >> 1];
    const far = (two) => two.reduce((sum, one, side) => sum + Math.abs(one.did.length - middle(side)), 0);
    const start = typical.reduce((best, two) => (far(two) < far(best) ? two : best));
    fill(which, pairs.map((_, i) => i), pairs.map(([one]) => number(one)));
    which.value = pairs.indexOf(start);
    $("pairs").textContent = pairs[0].length > 1
      ? `In ${only[1].length} of ${pairs.length} pairs of trials with the same random numbers${data.of ? ", a sample of all," : ""} the box was opened only ${under(d)}, in ${only[0].length} only ${under(c)}. Shown: ${only.some((some) => some.length) ? "one of these" : "a pair"} of usual length.`
      : `Of ${pairs.length} trials, one of usual length stands first.`;
    show();
  };
  const show = () => {
    pair = pairs[Number(which.value)];
    const longest = Math.max(...pair.map((one) => one.did.length));
    home.style.setProperty("--steps", data.budget ?? longest);
    parted = pair.length > 1 ? Array.from({ length: longest }, (_, i) => i).findIndex((i) => pair[0].did[i] !== pair[1].did[i]) : -1;
    const parts = pair.length > 1 ? Array.from({ length: longest }, (_, i) => i).findIndex((i) => pair[0].told[i] !== pair[1].told[i]) : -1;
    const said = [];
    if (pair.length > 1) {
      const alike = parted < 0 || parts >= 0 && parts < parted;
      if (parted < 0) said.push("Both play alike to the end.");
      else if (!alike && pair.filter((one) => misread(one, parted - 1)).length === 1) said.push(`They part at step ${parted + 1}, after one of them misread step ${parted}.`);
      else if (!alike) said.push(`They part at step ${parted + 1}, before any report differs: the condition acts elsewhere, or the agent's own draws are not shared.`);
      else {
        const at = parted - 1, differ = pair[0].told[at] !== pair[1].told[at], where = differ ? at : parts, joint = pair[0].did[where];
        const before = parts < where ? `, although what they are told differs from step ${parts + 1} on` : "";
        const heard = `one is told that ${joint} ${outcome[pair[0].told[where]]}, the other that it ${outcome[pair[1].told[where]]}`;
        said.push(`Both play alike up to step ${parted}${before}${differ ? `; there ${heard}.` : `. At step ${where + 1} ${heard}; from step ${parted + 1} they part.`}`);
      }
    }
    $("say").textContent = said.join(" ");
    const budget = Number(data.budget ?? longest);
    const numbers = make("div", "num");
    for (let i = 1; i <= budget; i += 1) numbers.append(make("span", "", i === 1 || i % 5 === 0 ? String(i) : ""));
    const strips = pair.flatMap((one, side) => {
      const head = make("p", "sl"), strip = make("div", "strip");
      const falsely = [...one.told].some((_, i) => lies(one, i));
      const name = data.conditions[one.c];
      head.append(make("strong", falsely ? "f" : "", name[0].toUpperCase() + name.slice(1)), make("span", "", end(one)));
      [...one.did].forEach((joint, i) => {
        const button = make("button", `${one.moved[i] === "1" ? "m" : "b"}${lies(one, i) ? " x" : corrected(one, i) ? " c" : ""}`, joint);
        button.type = "button";
        button.title = `step ${i + 1}: ${called(joint, one)} ${outcome[one.moved[i]]}, told: ${told[one.told[i]]}`;
        button.addEventListener("click", () => go(i + 1));
        strip.append(button);
      });
      if (one.solved && one.did.length < budget) strip.append(make("span", "e", "open"));
      strip.dataset.side = side;
      return [head, strip];
    });
    const cut = make("i", "cut");
    if (parted > 0) cut.style.left = `${100 * parted / budget}%`;
    $("taken-back").hidden = !pair.some((one) => one.back);
    $("strips").replaceChildren(numbers, ...strips, ...(parted > 0 ? [cut] : []));
    slider.max = longest;
    go(Math.max(1, parted));
  };
  const describe = (one, step) => {
    const i = step - 1, box = make("div"), joint = one.did[i];
    if (joint === undefined) { box.append("The trial is over."); return box; }
    const false_ = lies(one, i);
    box.append(make("small", "", `${data.conditions[one.c]}: `), `${joint} (${called(joint, one)}) ${outcome[one.moved[i]]}, told: `, make("b", false_ ? "f" : "", `${told[one.told[i]]}${false_ ? ", which is false" : ""}`), corrected(one, i) ? ", after a first report that was taken back. " : ". ");
    if (one.chosen && one.chosen[i] !== "-") box.append(`It had chosen ${one.chosen[i]}. `);
    for (const [name, who, none] of [["verdict", "The arm's verdict", "failed"], ["camera", "What the camera saw", "unclear"]]) {
      const judged = one[name] && one[name][i];
      if (judged && judged !== one.moved[i]) box.append(`${who}${one.source === name ? ", of which reports are made," : ""}: ${judged === "-" ? none : outcome[judged]}. `);
    }
    if (misread(one, i)) box.append(make("b", "f", `The agent says that it ${outcome[one.said[i + 1]]}: misread. `));
    if ((one.loop[i] ?? " ") !== " ") box.append(`Part of a sequence that it repeats (action loop ${one.loop[i]}). `);
    if (one.words && one.words[i]) box.append(make("blockquote", "", one.words[i]));
    return box;
  };
  const go = (to) => {
    const step = Math.min(Math.max(1, to), Number(slider.max));
    slider.value = step;
    $("at").textContent = step;
    $("now").replaceChildren($("now").firstElementChild, ...pair.map((one) => describe(one, step)));
    document.querySelectorAll(".strip").forEach((strip) => strip.querySelectorAll("button").forEach((button, i) => button.setAttribute("aria-current", String(i + 1 === step))));
  };
  const sides = (kept = []) => {
    const own = conditions(Number(agent.value)), names = own.map((c) => data.conditions[c]);
    fill(left, own, names, kept[0] ?? own[0]);
    fill(right, own, names, kept[1] ?? own[1] ?? own[0]);
    collect();
  };
  fill(agent, data.agents.map((_, i) => i), data.agents);
  agent.addEventListener("change", () => sides([Number(left.value), Number(right.value)]));
  left.addEventListener("change", collect);
  right.addEventListener("change", collect);
  which.addEventListener("change", show);
  slider.addEventListener("input", () => go(Number(slider.value)));
  home.addEventListener("keydown", (event) => {
    const to = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    if (!to || ["SELECT", "INPUT"].includes(event.target.tagName)) return;
    event.preventDefault();
    go(Number(slider.value) + to);
  });
  const [first, c, d] = data.start ?? [0];
  agent.value = first;
  sides([c, d]);
})();
