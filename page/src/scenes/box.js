import { panelOf, picturesOf } from "../box/panel.js";
import { deviceOf, meant } from "../choosing.js";
import { acts, element, filled, heading, paragraphs } from "../element.js";

const VIEWS = { panel: panelOf, pictures: picturesOf };

let cameFrom = { box: "", joint: "" }; // which box was shown last, and which joint was chosen there
let unfolded = null; // whether somebody wants to see the history; before that it is unfolded, the same on every device

/** One step of a box: a joint is chosen with a click, a key or a finger, where asked after what the last action did. */
export function boxOf(scene, { page: words }, answer) {
  const { practice, number, of, step, budget, panel, remark, warning } = scene;
  const box = `${practice ? "practice" : "box"}-${number}`;
  let clock;
  let claimed = null;
  let claimedAt = null;

  const buttonOf = (label) => part.querySelector(`button[data-joint="${CSS.escape(label)}"]`);
  /** The joint that was chosen in the step before; null at the first. */
  const lastChosen = () => (cameFrom.box === box ? buttonOf(cameFrom.joint) : null);

  const choose = (joint, event) => {
    if (scene.ask && !claimed) return;
    answer(event, (at) => {
      buttonOf(joint).dataset.chosen = "";
      cameFrom = { box, joint };
      const rt = Math.round((at - (claimedAt ?? 0)) * 10) / 10;
      return { kind: "attempt", joint, claimed, rt, claimed_rt: claimedAt, ...(scene.device ? deviceOf(event) : {}) };
    });
  };
  const say = (what, event) => {
    const at = clock();
    if (claimed || !meant(event, at)) return;
    claimed = what;
    claimedAt = at;
    for (const button of claim.querySelectorAll("button")) {
      button.setAttribute("aria-pressed", String(button.dataset.claim === claimed));
      button.setAttribute("aria-disabled", "true");
    }
    for (const button of part.querySelectorAll("button[data-joint]")) button.removeAttribute("aria-disabled");
    (lastChosen() ?? buttonOf(panel.joints[0].label)).focus({ preventScroll: true });
  };

  const claim = scene.ask ? claimOf(words, say) : null;
  const shown = VIEWS[panel.view](scene, words);
  shown.setAttribute("role", "group");
  shown.setAttribute("aria-labelledby", "choose");
  for (const button of shown.querySelectorAll("button")) {
    button.setAttribute("aria-keyshortcuts", button.dataset.joint);
    if (scene.ask) button.setAttribute("aria-disabled", "true");
    button.addEventListener("click", (event) => choose(button.dataset.joint, event));
  }
  const ends = practice ? element("p", { class: "where" }, filled(words.practice_ends, { budget })) : null;
  const part = element(
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
      ends,
      warning ? element("p", { class: "warning" }, warning) : null,
      reportOf(panel),
      remark ? element("p", { class: "remark" }, remark) : null,
      claim,
      element("h2", { id: "choose" }, words.choose),
      shown,
    ),
    historyOf(scene, words),
  );

  /** To the heading of a new box; within a box to the question, or to the joint that was chosen last. */
  const begin = (started) => {
    clock = started;
    document.getElementById("spoken").textContent = scene.spoken;
    const last = lastChosen();
    const place = last ? (claim?.querySelector("h2") ?? last) : part.querySelector("h1");
    place.focus({ preventScroll: last !== null });
    if (last) part.querySelector(".report").scrollIntoView({ block: "nearest" });
  };
  const keyed = (key, event) => {
    if (scene.ask && !claimed) {
      if (key === "1") say("moved", event);
      if (key === "2") say("blocked", event);
    } else if (panel.joints.some(({ label }) => label === key)) {
      choose(key, event);
    }
  };
  return { part, begin, keyed };
}

/** What came of the last attempt. */
function reportOf({ report, outcome }) {
  return element("div", { class: "report", "data-outcome": outcome }, ...paragraphs(report));
}

/** What the last action did, as the participant sees it: asked before a joint can be chosen, and answered once. */
function claimOf(words, said) {
  const button = (claimed, text, key) => {
    const onclick = (event) => said(claimed, event);
    const own = { type: "button", "data-claim": claimed, "aria-keyshortcuts": key, "aria-pressed": "false", onclick };
    return element("button", own, text);
  };
  return element(
    "div",
    { class: "claim", role: "group", "aria-labelledby": "claim-question" },
    element("h2", { id: "claim-question", tabindex: -1 }, words.question),
    acts(button("moved", words.said_moved, "1"), button("blocked", words.said_blocked, "2")),
  );
}

/** What was told before in this trial, the newest first; null if nothing is shown of it. */
function historyOf(scene, words) {
  if (!scene.history.length) return null;
  const rows = scene.history.map((said, i) => element("li", { value: i + 1 }, said)).reverse();
  const list = element(
    "details",
    { class: "history", open: unfolded ?? true },
    element("summary", {}, words.history),
    element("ol", { reversed: true, tabindex: 0, "aria-label": words.history }, ...rows),
  );
  list.addEventListener("toggle", () => (unfolded = list.open));
  return list;
}
