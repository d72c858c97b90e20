import { element } from "../element.js";
import { drawnButton } from "./joint.js";
import { WIDTH, layout } from "./layout.js";

const TALLEST = 62; // hundredths of the window's height that a panel may take, where that leaves it wide enough

/** @type {{box: string, positions: Map<string, 0 | 1 | null>}} What was drawn last, to move on from. */
let before = { box: "", positions: new Map() };

/**
 * The box drawn as a panel, from what was told of it.
 *
 * @param {object} scene
 * @param {Record<string, string>} words
 * @returns {HTMLElement}
 */
export function panelOf(scene, words) {
  const { joints, last, outcome } = scene.panel;
  const box = `${scene.practice} ${scene.number}`;
  const from = box === before.box ? before.positions : new Map();
  const { spots, cell, height } = layout(joints.map((joint) => joint.place));
  const buttons = joints.map((joint, i) => {
    const button = drawnButton(joint, words, from.has(joint.label) ? from.get(joint.label) : joint.position);
    button.style.left = `${(100 * (spots[i].x - cell.width / 2)) / WIDTH}%`;
    button.style.top = `${(100 * (spots[i].y - cell.height / 2)) / height}%`;
    button.style.width = `${(100 * cell.width) / WIDTH}%`;
    button.style.height = `${(100 * cell.height) / height}%`;
    if (joint.label === last && outcome) button.dataset.outcome = outcome;
    return button;
  });
  before = { box, positions: new Map(joints.map((joint) => [joint.label, joint.position])) };
  const board = element("div", { class: "board" }, ...buttons);
  board.style.aspectRatio = `${WIDTH} / ${height}`;
  board.style.maxWidth = `max(20rem, ${(TALLEST * WIDTH) / height}vh)`;
  const goThere = () => joints.forEach((joint, i) => (buttons[i].dataset.position = String(joint.position ?? "none")));
  requestAnimationFrame(() => requestAnimationFrame(goThere));
  return element("div", { class: "panel" }, board);
}
