import { element } from "../element.js";
import { drawnButton, labelButton } from "./joint.js";

const WIDTH = 320; // of the panel; units of the drawing
const GAP = 4; // units that are left free around a joint
const STEP = 4; // units between the heights that are tried
const SPREAD = 140; // units between the lowest and the highest place of a panel
const EDGE = 1 / 8; // of the panel's width; joints further out are drawn at the edge
const CELLS = { 1: 96, 2: 96, 3: 96, 4: 76 }; // how wide so many joints are drawn; more are narrower
const TALLEST = 62; // hundredths of the window's height that a panel may take, where that leaves it wide enough

/** The box as a camera sees it, with a button for each joint. */
export function picturesOf(scene, words) {
  const images = scene.panel.pictures.map((src, i) => element("img", { src, alt: i ? words.depth : words.colours }));
  const buttons = scene.panel.joints.map((joint) => labelButton(joint, words));
  const [above, below] = [element("div", { class: "images" }, ...images), element("div", { class: "labels" }, ...buttons)];
  return element("div", { class: "pictures" }, above, below);
}

/** The box drawn as a panel, from what was told of it. */
export function panelOf(scene, words) {
  const { joints } = scene.panel;
  const { spots, cell, height } = layout(joints.map((joint) => joint.place));
  const buttons = joints.map((joint, i) => {
    const button = drawnButton(joint, words);
    button.style.left = `${(100 * (spots[i].x - cell.width / 2)) / WIDTH}%`;
    button.style.top = `${(100 * (spots[i].y - cell.height / 2)) / height}%`;
    button.style.width = `${(100 * cell.width) / WIDTH}%`;
    button.style.height = `${(100 * cell.height) / height}%`;
    return button;
  });
  const board = element("div", { class: "board" }, ...buttons);
  board.style.aspectRatio = `${WIDTH} / ${height}`;
  board.style.maxWidth = `max(20rem, ${(TALLEST * WIDTH) / height}vh)`;
  return element("div", { class: "panel" }, board);
}

/**
 * Where joints are drawn. Each stays where it is from left to right, and as near as it can to its height: joints that
 * would lie on each other are drawn one above the other. The same on every screen.
 *
 * @param {readonly (readonly [number, number] | null)[]} places From the left and from below, [0, 1]; null for a joint
 *   of which no place is known.
 * @returns Middles of the joints from the upper left corner, the room of each, and the height of the panel.
 */
function layout(places) {
  const known = places.map((place, i) => place ?? [(i + 0.5) / places.length, 0.5]);
  const left = Math.min(EDGE, ...known.map(([x]) => x));
  const right = Math.max(1 - EDGE, ...known.map(([x]) => x));
  const width = CELLS[places.length] ?? 62;
  const cell = { width, height: Math.round(width * 1.62) };
  const spots = known.map(([x, y]) => ({
    x: width / 2 + ((WIDTH - width) * (x - left)) / (right - left),
    y: (1 - y) * SPREAD,
  }));
  const others = [];
  for (const spot of [...spots].sort((a, b) => a.x - b.x || a.y - b.y)) {
    spot.y = freeHeight(spot, others, cell);
    others.push(spot);
  }
  const top = Math.min(...spots.map(({ y }) => y)) - cell.height / 2;
  for (const spot of spots) spot.y -= top;
  return { spots, cell, height: Math.max(...spots.map(({ y }) => y)) + cell.height / 2 };
}

/** The nearest height at which a joint lies on no other; below before above. */
function freeHeight({ x, y }, others, cell) {
  const inWay = others.filter((other) => Math.abs(other.x - x) < cell.width);
  const free = (height) => inWay.every((other) => Math.abs(other.y - height) >= cell.height + GAP);
  for (let off = 0; ; off += STEP) {
    if (free(y + off)) return y + off;
    if (free(y - off)) return y - off;
  }
}
