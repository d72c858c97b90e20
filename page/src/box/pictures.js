import { element } from "../element.js";
import { labelButton } from "./joint.js";

const REACH = 0.12; // of a picture's width: how far from a handle a click may be

/**
 * The box as a camera sees it. A click on a handle chooses its joint; so do the buttons below.
 *
 * @param {object} scene
 * @param {Record<string, string>} words
 * @param {(label: string, event: Event) => void} choose
 * @returns {HTMLElement}
 */
export function picturesOf(scene, words, choose) {
  const { joints, pictures } = scene.panel;
  const buttons = joints.map((joint) => labelButton(joint, words, "pictures"));
  const under = (event) => nearest(joints, event);
  const point = (event) => {
    const found = under(event);
    event.currentTarget.classList.toggle("over", found !== null);
    for (const button of buttons) button.classList.toggle("near", button.dataset.joint === found);
  };
  const click = (event) => {
    const found = under(event);
    if (found !== null) choose(found, event);
  };
  const images = pictures.map((url, i) =>
    element("img", {
      src: url,
      alt: i ? words.depth : words.colours,
      draggable: "false",
      onpointermove: point,
      onpointerleave: point,
      onclick: click,
    }),
  );
  return element(
    "div",
    { class: "pictures" },
    element("div", { class: "images", "data-count": images.length }, ...images),
    element("div", { class: "labels" }, ...buttons),
  );
}

/** The joint whose handle, at either position or between, is nearest to the pointer; null if none is near. */
function nearest(joints, event) {
  const frame = event.currentTarget.getBoundingClientRect();
  const at = { x: (event.clientX - frame.left) / frame.width, y: (event.clientY - frame.top) / frame.height };
  const ratio = frame.height / frame.width;
  let best = { label: null, distance: REACH };
  for (const joint of joints) {
    if (!joint.handle) continue;
    const distance = toSegment(at, joint.handle, ratio);
    if (distance < best.distance) best = { label: joint.label, distance };
  }
  return best.label;
}

/** Distance to the way of a handle, in widths of the picture. */
function toSegment(at, [[x0, y0], [x1, y1]], ratio) {
  const way = { x: x1 - x0, y: (y1 - y0) * ratio };
  const off = { x: at.x - x0, y: (at.y - y0) * ratio };
  const length = way.x ** 2 + way.y ** 2;
  const along = length ? Math.min(1, Math.max(0, (off.x * way.x + off.y * way.y) / length)) : 0;
  return Math.hypot(off.x - along * way.x, off.y - along * way.y);
}
