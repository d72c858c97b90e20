import { element } from "../element.js";
import { labelButton } from "./joint.js";

const REACH = 0.12; // of a picture's width: how far from a handle a click may be

/** The box as a camera sees it. A click on a handle chooses its joint; so do the buttons below. */
export function picturesOf(scene, words, choose) {
  const { joints, pictures } = scene.panel;
  const buttons = joints.map((joint) => labelButton(joint, words));
  const point = (event) => {
    const found = nearest(joints, event);
    event.currentTarget.classList.toggle("over", found !== null);
    for (const button of buttons) button.classList.toggle("near", button.dataset.joint === found);
  };
  const click = (event) => {
    const found = nearest(joints, event);
    if (found !== null) choose(found, event);
  };
  const does = { draggable: "false", onpointermove: point, onpointerleave: point, onclick: click };
  const images = pictures.map((src, i) => element("img", { src, alt: i ? words.depth : words.colours, ...does }));
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
  let best = { label: null, distance: REACH };
  for (const { label, handle } of joints) {
    const distance = handle ? toSegment(at, handle, frame.height / frame.width) : Infinity;
    if (distance < best.distance) best = { label, distance };
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
