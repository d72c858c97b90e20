import { ParameterType } from "jspsych";

import { claimOf, showClaimed } from "../box/claim.js";
import { panelOf } from "../box/panel.js";
import { picturesOf } from "../box/pictures.js";
import { historyOf } from "../box/history.js";
import { meant, onKeys } from "../choosing.js";
import { SceneClock } from "../clock.js";
import { deviceOf } from "../device.js";
import { element, heading, paragraphs } from "../element.js";
import { filled } from "../words.js";

const info = {
  name: "lockprobe-box",
  version: "1.0.0",
  parameters: {
    /** A scene of the kind `box`: what is told of the box now. */
    scene: { type: ParameterType.OBJECT },
    /** Texts. */
    words: { type: ParameterType.OBJECT },
    /** Tells the server what was done; afterwards there is a new scene. */
    act: { type: ParameterType.FUNCTION },
  },
  data: {
    /** Label of the joint that was attempted. */
    joint: { type: ParameterType.STRING },
    /** What was said of the last action, `moved` or `blocked`; null where it was not asked. */
    claimed: { type: ParameterType.STRING },
    /** From when the scene was painted to the choice of the joint, without the time for `claimed`; ms. */
    rt: { type: ParameterType.FLOAT },
    /** From when the scene was painted to what was said of the last action, ms; null where it was not asked. */
    claimed_rt: { type: ParameterType.FLOAT },
    /** With what the joint was chosen: `mouse`, `touch`, `pen` or `keyboard`; only where the study keeps it. */
    pointer: { type: ParameterType.STRING },
    /** Width and height of the window, CSS pixels; only where the study keeps it. */
    viewport: { type: ParameterType.INT, array: true },
  },
};

let cameFrom = { box: "", joint: "" }; // which box was shown last, and which joint was chosen there

/** One step of a box: a joint is chosen with a click, a key or a finger. */
export class BoxPlugin {
  static info = info;

  async trial(display, { scene, words: { page: words }, act }, onLoad) {
    const step = new Step(scene, words);
    await Promise.all([...step.element.querySelectorAll("img")].map((image) => image.decode().catch(() => {})));
    display.append(step.element);
    step.begin();
    onLoad();
    const chosen = await step.chosen;
    await act({ kind: "attempt", ...chosen });
    return chosen;
  }
}

class Step {
  #scene;
  #words;
  #clock;
  #claim = null;
  #claimed = null;
  #claimedAt = null;
  #done = false;
  #resolve;
  #endKeys = () => {};

  constructor(scene, words) {
    this.#scene = scene;
    this.#words = words;
    this.chosen = new Promise((resolve) => (this.#resolve = resolve));
    this.#claim = scene.ask ? claimOf(words, (claimed, event) => this.#say(claimed, event)) : null;
    this.element = this.#made();
    this.#enable(!scene.ask);
  }

  /** Starts the clock and listens. To be called when the scene is on the page. */
  begin() {
    this.#clock = new SceneClock();
    document.getElementById("spoken").textContent = this.#scene.spoken;
    this.#endKeys = onKeys((key, event) => this.#key(key, event));
    this.#focus();
  }

  #made() {
    const { practice, number, of, step, budget, panel, remark, warning } = this.#scene;
    const words = this.#words;
    const choose = (label, event) => this.#choose(label, event);
    const shown = VIEWS[panel.view](this.#scene, words, choose);
    shown.setAttribute("role", "group");
    shown.setAttribute("aria-labelledby", "choose");
    for (const button of shown.querySelectorAll("button")) {
      button.setAttribute("aria-keyshortcuts", button.dataset.joint);
      button.addEventListener("click", (event) => choose(button.dataset.joint, event));
    }
    const report = element("div", { class: "report", "data-outcome": panel.outcome }, ...paragraphs(panel.report));
    return element(
      "div",
      { class: "box", "data-view": panel.view, translate: "no" }, // or a browser changes letters and reports
      element(
        "div",
        { class: "top" },
        heading(practice ? words.practice : filled(words.box, { number, of })),
        element("p", { class: "where", "data-step": step }, filled(words.step, { step, budget })),
      ),
      element(
        "div",
        { class: "now" },
        practice && words.practice_ends ? element("p", { class: "where" }, filled(words.practice_ends, { budget })) : null,
        warning ? element("p", { class: "warning" }, warning) : null,
        report,
        remark ? element("p", { class: "remark" }, remark) : null,
        this.#claim,
        element("h2", { id: "choose" }, words.choose),
        shown,
      ),
      historyOf(this.#scene, words),
    );
  }

  #say(claimed, event) {
    const at = this.#clock.now();
    if (this.#claimed || this.#done || !meant(event, at)) return;
    this.#claimed = claimed;
    this.#claimedAt = at;
    showClaimed(this.#claim, claimed);
    this.#enable(true);
    (this.#lastChosen() ?? this.#joint(this.#scene.panel.joints[0].label)).focus({ preventScroll: true });
  }

  #choose(label, event) {
    const at = this.#clock.now();
    if (this.#done || (this.#scene.ask && !this.#claimed) || !meant(event, at)) return;
    this.#done = true;
    this.#enable(false);
    this.#endKeys();
    this.#joint(label).dataset.chosen = "";
    cameFrom = { box: this.#box, joint: label };
    const rt = Math.round((at - (this.#claimedAt ?? 0)) * 10) / 10;
    const device = this.#scene.device ? deviceOf(event) : {};
    this.#resolve({ joint: label, claimed: this.#claimed, rt, claimed_rt: this.#claimedAt, ...device });
  }

  #key(key, event) {
    if (this.#scene.ask && !this.#claimed) {
      if (key === "1") this.#say("moved", event);
      if (key === "2") this.#say("blocked", event);
    } else if (this.#scene.panel.joints.some(({ label }) => label === key)) {
      this.#choose(key, event);
    }
  }

  /** To the heading of a new box; within a box to the question, or to the joint that was chosen last. */
  #focus() {
    const last = this.#lastChosen();
    const place = last ? (this.#claim?.querySelector("h2") ?? last) : this.element.querySelector("h1");
    place.focus({ preventScroll: last !== null });
    if (last) this.element.querySelector(".report").scrollIntoView({ block: "nearest" });
  }

  /** The joint that was chosen in the step before; null at the first. */
  #lastChosen() {
    return cameFrom.box === this.#box ? this.#joint(cameFrom.joint) : null;
  }

  get #box() {
    return `${this.#scene.practice ? "practice" : "box"}-${this.#scene.number}`;
  }

  #joint(label) {
    return this.element.querySelector(`button[data-joint="${CSS.escape(label)}"]`);
  }

  #enable(enabled) {
    for (const button of this.element.querySelectorAll("button[data-joint]")) {
      if (enabled) button.removeAttribute("aria-disabled");
      else button.setAttribute("aria-disabled", "true");
    }
  }
}

const VIEWS = {
  panel: panelOf,
  pictures: picturesOf,
};
