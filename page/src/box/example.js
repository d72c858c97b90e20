import { element, filled } from "../element.js";
import { claimOf, reportOf } from "../scenes/box.js";
import { nameOf } from "./joint.js";
import { panelOf } from "./panel.js";
import { picturesOf } from "./pictures.js";

const VIEWS = { panel: panelOf, pictures: picturesOf };

/** By what parts are found with which something can be done. */
const HOOKS = ["id", "data-joint", "data-claim", "aria-keyshortcuts"];

/**
 * The examples of a page of instructions: boxes as they will look, on which nothing can be done. Each is one picture,
 * whose text says all that is seen in it.
 */
export function examplesOf(scene, words) {
  const some = scene.examples.length > 1;
  return scene.examples.map(({ panel, ask }, i) => {
    const shown = element(
      "div",
      { class: "box", inert: true, translate: "no" },
      reportOf(panel),
      ask ? claimOf(words, () => {}) : null,
      element("h2", {}, words.choose),
      VIEWS[panel.view]({ panel, practice: true, number: -1 - i }, words, () => {}),
    );
    for (const part of shown.querySelectorAll("button, [id]")) {
      for (const name of HOOKS) part.removeAttribute(name);
      part.tabIndex = -1;
    }
    return element(
      "figure",
      { class: "example" },
      element("figcaption", {}, captionOf(panel, words, some, scene.number === 1)),
      element("div", { class: "shown", role: "img", "aria-label": inWords(panel, ask, words) }, shown),
    );
  });
}

/** What it is, and how it is to be read: that once, where the box is shown first. */
function captionOf(panel, words, some, first) {
  const told = panel.joints.some(({ position }) => position !== null);
  const said = [some ? words.example_some : words.example];
  if (panel.last !== null) said.push(filled(words.example_step, { label: panel.last }));
  if (panel.last === null || first) {
    if (panel.view === "panel") said.push(words.example_panel, told ? words.example_positions : "");
    if (panel.view === "pictures") said.push(words.example_pictures);
    if (panel.pictures.length > 1) said.push(words.example_depth);
  }
  return said.filter(Boolean).join(" ");
}

/** All that is seen in it. */
function inWords(panel, ask, words) {
  const question = ask ? [`${words.question} ${words.said_moved} / ${words.said_blocked}`] : [];
  const pictures = panel.pictures.map((_, i) => (i ? words.depth : words.colours));
  const joints = panel.joints.map((joint) => nameOf(joint, words, panel.view));
  return [...panel.report, ...question, ...pictures, joints.join("; ")].join(" – ");
}
