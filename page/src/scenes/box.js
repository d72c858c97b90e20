import { claimOf, showClaimed } from "../box/claim.js";
import { historyOf } from "../box/history.js";
import { panelOf } from "../box/panel.js";
import { picturesOf } from "../box/pictures.js";
import { meant } from "../choosing.js";
import { deviceOf } from "../device.js";
import { element, heading, paragraphs } from "../element.js";
import { filled } from "../words.js";

const VIEWS = { panel: panelOf, pictures: picturesOf };

let cameFrom = { box: "", joint: "" }; // which box was shown last, and which joint was chosen there

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
    const at = clock.now();
    if (claimed || !meant(event, at)) return;
    claimed = what;
    claimedAt = at;
    showClaimed(claim, claimed);
    for (const button of part.querySelectorAll("button[data-joint]")) button.removeAttribute("aria-disabled");
    (lastChosen() ?? buttonOf(panel.joints[0].label)).focus({ preventScroll: true });
  };

  const claim = scene.ask ? claimOf(words, say) : null;
  const shown = VIEWS[panel.view](scene, words, choose);
  shown.setAttribute("role", "group");
  shown.setAttribute("aria-labelledby", "choose");
  for (const button of shown.querySelectorAll("button")) {
    button.setAttribute("aria-keyshortcuts", button.dataset.joint);
    if (scene.ask) button.setAttribute("aria-disabled", "true");
    button.addEventListener("click", (event) => choose(button.dataset.joint, event));
  }
  const ends = practice && words.practice_ends;
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
      ends ? element("p", { class: "where" }, filled(words.practice_ends, { budget })) : null,
      warning ? element("p", { class: "warning" }, warning) : null,
      element("div", { class: "report", "data-outcome": panel.outcome }, ...paragraphs(panel.report)),
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
