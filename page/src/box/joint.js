import { drawn, element, filled } from "../element.js";

/** What a joint is called, also for those who do not see it; `view` is `panel` or `pictures`. */
export function nameOf(joint, words, view) {
  const parts = [filled(words.joint, { label: joint.label })];
  if (joint.target) parts.push(words.target);
  if (view === "panel") {
    if (joint.kind) parts.push(joint.kind === "prismatic" ? words.slides : words.turns);
    const told = joint.position !== null;
    parts.push(told ? filled(words.position, { position: joint.position }) : words.unknown_position);
  }
  return parts.join(", ");
}

/** The button of a joint beside pictures. */
export function labelButton(joint, words) {
  const target = joint.target ? element("span", { class: "target" }, targetMark(), words.target) : null;
  const letter = element("span", { class: "letter" }, joint.label);
  return jointButton(joint, words, "pictures", { class: "label" }, letter, " ", target);
}

/** The button of a joint as it is drawn: a slider or a knob, at the position at which it was told to be. */
export function drawnButton(joint, words) {
  const parts = joint.kind === "revolute" ? knob(joint.position) : slider(joint.position);
  const picture = drawn("svg", { viewBox: "0 0 64 64", "aria-hidden": "true", focusable: "false" }, ...parts, ...digits());
  const letter = element("span", { class: "letter" }, joint.target ? targetMark() : null, joint.label);
  const target = joint.target ? element("span", { class: "target" }, words.target) : null;
  const own = { class: "joint", "data-kind": joint.kind ?? "prismatic", "data-position": joint.position ?? "none" };
  return jointButton(joint, words, "panel", own, letter, " ", picture, target);
}

function jointButton(joint, words, view, own, ...children) {
  const { label, target } = joint;
  const name = nameOf(joint, words, view);
  const all = { type: "button", ...own, "data-joint": label, "data-target": target, "aria-label": name };
  return element("button", all, ...children);
}

/** A bull's-eye: the target is marked by more than colour. */
function targetMark() {
  return drawn(
    "svg",
    { class: "mark", viewBox: "0 0 16 16", "aria-hidden": "true" },
    drawn("circle", { cx: 8, cy: 8, r: 6.5, fill: "none", stroke: "currentColor", "stroke-width": 2 }),
    drawn("circle", { cx: 8, cy: 8, r: 2.5, fill: "currentColor" }),
  );
}

/** 0 and 1, as lines: text within a button would be read out with its name. */
function digits() {
  return [
    drawn("ellipse", { class: "digit", cx: 12, cy: 57, rx: 3, ry: 4.8 }),
    drawn("path", { class: "digit", d: "M49 54.6l3.2-2.6v9.8" }),
  ];
}

function slider(position) {
  const ribs = () => drawn("path", { class: "ribs", d: "M11 23v12M14 23v12M17 23v12" });
  return [
    drawn("rect", { class: "way", x: 2, y: 17, width: 60, height: 24, rx: 12 }),
    drawn("rect", { class: "groove", x: 12, y: 26.5, width: 40, height: 5, rx: 2.5 }),
    drawn(
      "g",
      { class: "handle" },
      drawn("rect", { class: "grip", x: 4, y: 15, width: 20, height: 28, rx: 7 }),
      position === null ? unknown(14, 28) : ribs(),
    ),
  ];
}

function knob(position) {
  return [
    drawn("circle", { class: "way", cx: 32, cy: 27, r: 24 }),
    drawn(
      "g",
      { class: "handle" },
      drawn("circle", { class: "grip", cx: 32, cy: 27, r: 17 }),
      position === null ? unknown(32, 26) : drawn("path", { class: "pointer", d: "M32 27V8" }),
    ),
  ];
}

/** A question mark. */
function unknown(x, y) {
  return drawn("path", {
    class: "unknown",
    d: `M${x - 3.5} ${y - 3.5}a3.6 3.6 0 1 1 4.6 3.5q-1.1.5-1.1 2.4M${x} ${y + 6.2}v.1`,
  });
}
