"use strict";
// Steps through the trials of a study, one or two at once. Data come from agents: they become text, never markup.
(() => {
  const home = document.getElementById("explorer");
  const source = document.getElementById("trials-data");
  addEventListener("beforeprint", () => document.querySelectorAll("details").forEach((one) => { one.open = true; }));
  const unfold = () => {
    const found = location.hash && document.getElementById(decodeURIComponent(location.hash.slice(1)));
    for (let at = found; at; at = at.parentElement) if (at.tagName === "DETAILS") at.open = true;
    if (found) found.scrollIntoView();
  };
  addEventListener("hashchange", unfold);
  unfold();
  if (!home || !source) return;
  const data = JSON.parse(source.textContent);
  if (!data.trials.length) return;

  const make = (tag, name = "", text = "") => {
    const element = document.createElement(tag);
    if (name) element.className = name;
    if (text) element.textContent = text;
    return element;
  };
  const drawn = (tag, settings) => {
    const element = document.createElementNS("http://www.w3.org/2000/svg", tag);
    for (const [name, value] of Object.entries(settings)) element.setAttribute(name, value);
    return element;
  };
  const number = (trial) => (trial.person ? `person ${trial.person}, ` : "") + `repetition ${trial.r}, trial ${trial.n}`;
  const short = (name) => (name.length > 16 ? `${name.slice(0, 15)}…` : name);

  // A panel: sliders go right, knobs turn; blue is the target, a frame the attempt, red what was told falsely.
  const WIDE = 96, HIGH = 104;
  const panel = (trial, bits, truth, tried, says) => {
    const count = trial.panel.length;
    const picture = drawn("svg", { viewBox: `0 0 ${count * WIDE} ${HIGH}`, class: "panel", role: "img", "aria-label": says });
    trial.panel.forEach((joint, place) => {
      const open = bits[place] === "1", x = place * WIDE + WIDE / 2;
      const off = truth && bits[place] !== truth[place];
      const group = drawn("g", { class: `${joint === trial.goal ? "goal" : ""}${off ? " off" : ""}${bits === "-" ? " unknown" : ""}` });
      if (joint === tried) group.append(drawn("rect", { x: x - 36, y: 6, width: 72, height: 68, rx: 8, class: "tried" }));
      if (data.turning[joint]) {
        const [dx, dy] = open ? [20, 0] : [0, -20];
        group.append(drawn("circle", { cx: x, cy: 40, r: 24, class: "slot" }));
        group.append(drawn("line", { x1: x, y1: 40, x2: x + dx, y2: 40 + dy, class: "hand" }));
      } else {
        group.append(drawn("rect", { x: x - 28, y: 31, width: 56, height: 18, rx: 9, class: "slot" }));
        group.append(drawn("rect", { x: open ? x + 5 : x - 26, y: 33, width: 21, height: 14, rx: 6, class: "handle" }));
      }
      const label = drawn("text", { x, y: 94, "text-anchor": "middle" });
      label.textContent = short(data.joints[joint]);
      group.append(label);
      picture.append(group);
    });
    return picture;
  };

  const after = (trial, step) => trial.state[Math.min(step, trial.state.length - 1)] ?? "";
  const outcome = { 1: "moved", 0: "blocked", "-": "nothing" };

  // One trial at one step: what was true, what was told, and what the agent said of the step before.
  const draw = (place, trial, step, parted) => {
    const index = Math.min(step, trial.did.length) - 1, ended = step > trial.did.length;
    const truth = after(trial, index + 1), did = trial.did[index];
    const shown = index < 0 || !trial.shown[index] ? truth : trial.shown[index];
    const unknown = shown === "-";
    const false_ = index >= 0 && trial.told[index] !== "-" && trial.told[index] !== trial.moved[index];
    const pair = make("div", "panels");
    for (const [name, bits, held] of [["true", truth, ""], ["told", unknown ? "-" : shown, truth]]) {
      const half = make("figure");
      half.append(make("figcaption", "", name === "true" ? "Truth" : unknown ? "No positions were told" : "Told"));
      half.append(panel(trial, bits, unknown ? "" : held, did, `${name}: ${trial.panel.map((joint, at) => `${data.joints[joint]} ${bits[at] === "1" ? "moved" : "at its start"}`).join(", ")}`));
      pair.append(half);
    }
    const line = make("p", "line");
    if (index < 0) line.append("Before the first step.");
    else {
      const chosen = trial.chosen && trial.chosen[index] >= 0 ? ` (it chose ${data.joints[trial.chosen[index]]})` : "";
      line.append(`Step ${index + 1}: ${data.joints[did]}${chosen}. In truth it ${trial.moved[index] === "1" ? "moved" : "was blocked"}; told: `);
      line.append(make("b", false_ ? "off" : "", `${outcome[trial.told[index]]}${false_ ? ", which is false" : ""}`), ". ");
      for (const [name, who, none] of [["verdict", "The arm's verdict", "failed"], ["camera", "What the camera saw", "unclear"]]) {
        const judged = trial[name] && trial[name][index];
        if (!judged || judged === trial.moved[index]) continue;
        line.append(`${who}${trial.source === name ? ", of which reports are made," : ""} was: ${judged === "-" ? none : outcome[judged]}. `);
      }
      const claim = trial.said[index + 1];
      if (claim === trial.told[index] && claim !== "-") line.append("The agent's claim repeats the report. ");
      else if (claim === "1" || claim === "0") line.append(make("b", "off", `The agent's claim is ${outcome[claim]}: it misread the report${claim === trial.moved[index] ? " and is right by chance" : ""}. `));
      if (trial.loop[index] !== " ") line.append(`This step is part of an action loop (${trial.loop[index]}). `);
      if (step === parted) line.append(make("b", "", "From here the two trials differ. "));
      if (ended || index + 1 === trial.did.length) line.append(make("b", "", trial.solved ? "Solved." : "Not solved within the budget."));
    }
    place.replaceChildren(pair, line);
    if (trial.words && index >= 0 && trial.words[index]) place.append(make("blockquote", "", trial.words[index]));
  };

  // All steps as a row of buttons: the joint by its number, red where the report was false, a line under loops.
  const strip = (trial, parted, go) => {
    const row = make("ol", "steps");
    trial.did.forEach((joint, index) => {
      const item = make("li"), button = make("button", "", String(trial.panel.indexOf(joint) + 1));
      button.type = "button";
      if (trial.told[index] !== "-" && trial.told[index] !== trial.moved[index]) button.classList.add("off");
      if (trial.moved[index] === "1") button.classList.add("moved");
      if (joint === trial.goal) button.classList.add("goal");
      if (trial.loop[index] !== " ") button.classList.add("looped");
      if (index + 1 === parted) button.classList.add("parted");
      button.title = `step ${index + 1}: ${data.joints[joint]}`;
      button.addEventListener("click", () => go(index + 1));
      item.append(button);
      row.append(item);
    });
    return row;
  };

  const chooser = (name, values, labels) => {
    const label = make("label", "", `${name} `), select = make("select");
    const fill = (those, says) => select.replaceChildren(...those.map((value, i) => { const option = make("option", "", says[i]); option.value = value; return option; }));
    fill(values, labels);
    label.append(select);
    return { label, select, fill };
  };
  const indexes = data.agents.map((_, i) => i);
  const agent = chooser("Agent", indexes, data.agents);
  const condition = chooser("Condition", [], []);
  const which = chooser("Trial", [], []);
  const other = chooser("Compare with", [], []);
  const controls = make("div", "controls");
  controls.append(agent.label, condition.label, which.label, other.label);
  const slider = make("input");
  Object.assign(slider, { type: "range", min: 0, value: 0 });
  slider.setAttribute("aria-label", "Step");
  const back = make("button", "go", "‹"), on = make("button", "go", "›");
  back.type = on.type = "button";
  back.setAttribute("aria-label", "Step back");
  on.setAttribute("aria-label", "Step on");
  const stepper = make("div", "stepper");
  stepper.append(back, slider, on);
  const sides = make("div", "sides"), note = make("p", "note");
  const legend = make("p", "note", "Each number is a step: which joint was attempted, counted from the left. Black: the step shown. Bold: it moved. Red: its report was false. Where positions are inverted, the report after a false one may look false too. Blue: the target. Double line below: part of an action loop. Dashed frame: the first step at which the two trials differ; in the picture of the box, the attempted joint. Keys: ← → Home End.");
  const key = make("details", "how");
  key.append(make("summary", "", "How to read it"), legend);
  const part = data.of ? make("p", "note", `These are ${data.trials.length} of ${data.of} trials: the first of every agent under every condition. lockprobe replay shows any other.`) : "";
  home.append(part, controls, stepper, sides, note, key);
  home.tabIndex = 0;
  home.hidden = false;

  let pair = [], step = 0, parted = 0, places = [], strips = [];
  const go = (to) => {
    step = Math.max(0, Math.min(to, Number(slider.max)));
    slider.value = step;
    pair.forEach((trial, i) => {
      draw(places[i], trial, step, parted);
      strips[i].querySelectorAll("button").forEach((button, at) => { button.setAttribute("aria-current", String(at + 1 === step)); });
    });
  };
  const twin = (trial, a, c) => data.trials.find((one) => one.a === a && one.c === c && one.r === trial.r && one.n === trial.n && one.person === trial.person);
  const show = () => {
    const trial = data.trials[Number(which.select.value)];
    const second = other.select.value === "" ? undefined : twin(trial, ...other.select.value.split(" ").map(Number));
    pair = second ? [trial, second] : [trial];
    const longest = Math.max(...pair.map((one) => one.did.length));
    const differs = (i) => pair[0].did[i] !== pair[1].did[i];
    parted = second ? Array.from({ length: longest }, (_, i) => i).findIndex(differs) + 1 : 0;
    slider.max = longest;
    places = pair.map(() => make("div", "at"));
    strips = pair.map((one) => strip(one, parted, go));
    sides.replaceChildren(...pair.map((one, i) => {
      const side = make("section");
      side.append(make("h3", "", `${one.a === trial.a ? data.conditions[one.c] : data.agents[one.a]}: ${one.solved ? "solved" : "not solved"} in ${one.did.length} steps`), strips[i], places[i]);
      return side;
    }));
    note.textContent = second ? (parted ? `Both trials draw the same random numbers. Their actions first differ at step ${parted}.` : "Both trials draw the same random numbers, and their actions are the same.") : "";
    go(Math.min(step, longest));
  };
  const fillOthers = () => {
    const trial = data.trials[Number(which.select.value)];
    const conditions = data.conditions.map((_, c) => c).filter((c) => c !== trial.c && twin(trial, trial.a, c));
    const agents = indexes.filter((a) => a !== trial.a && twin(trial, a, trial.c));
    const values = ["", ...conditions.map((c) => `${trial.a} ${c}`), ...agents.map((a) => `${a} ${trial.c}`)];
    const kept = other.select.value;
    other.fill(values, ["nothing", ...conditions.map((c) => data.conditions[c]), ...agents.map((a) => data.agents[a])]);
    if (values.includes(kept)) other.select.value = kept;
  };
  const fillTrials = () => {
    const own = data.trials.map((one, i) => [one, i]).filter(([one]) => one.a === Number(agent.select.value) && one.c === Number(condition.select.value));
    which.fill(own.map(([, i]) => i), own.map(([one]) => `${number(one)}${one.solved ? " (solved)" : ""}`));
    fillOthers();
  };
  const fillConditions = () => {
    const own = [...new Set(data.trials.filter((one) => one.a === Number(agent.select.value)).map((one) => one.c))];
    condition.fill(own, own.map((c) => data.conditions[c]));
    fillTrials();
  };
  agent.select.addEventListener("change", () => { fillConditions(); show(); });
  condition.select.addEventListener("change", () => { fillTrials(); show(); });
  which.select.addEventListener("change", () => { fillOthers(); show(); });
  other.select.addEventListener("change", show);
  slider.addEventListener("input", () => go(Number(slider.value)));
  back.addEventListener("click", () => go(step - 1));
  on.addEventListener("click", () => go(step + 1));
  const keys = { ArrowLeft: () => go(step - 1), ArrowRight: () => go(step + 1), Home: () => go(0), End: () => go(Number(slider.max)) };
  home.addEventListener("keydown", (event) => {
    if (!keys[event.key] || ["SELECT", "INPUT"].includes(event.target.tagName)) return;
    event.preventDefault();
    keys[event.key]();
  });
  let from = null;
  sides.addEventListener("touchstart", (event) => { from = event.touches[0].clientX; }, { passive: true });
  sides.addEventListener("touchend", (event) => {
    const moved = event.changedTouches[0].clientX - from;
    if (Math.abs(moved) > 40) go(step + (moved < 0 ? 1 : -1));
  }, { passive: true });

  // It opens on the first trial that ends otherwise than its twin under the first condition, at the step where they part.
  const tells = (one) => one.a === 0 && one.c > 0 && (twin(one, 0, 0)?.solved ?? one.solved) !== one.solved;
  const first = data.trials.find(tells) ?? data.trials.find((one) => one.a === 0) ?? data.trials[0];
  agent.select.value = first.a;
  fillConditions();
  condition.select.value = first.c;
  fillTrials();
  which.select.value = data.trials.indexOf(first);
  fillOthers();
  if (other.select.options.length > 1) other.select.selectedIndex = 1;
  show();
  go(parted || 1);
})();
