import { element } from "../element.js";
import { labelButton } from "./joint.js";

/** The box as a camera sees it, with a button for each joint. */
export function picturesOf(scene, words) {
  const images = scene.panel.pictures.map((src, i) => element("img", { src, alt: i ? words.depth : words.colours }));
  const buttons = scene.panel.joints.map((joint) => labelButton(joint, words));
  return element(
    "div",
    { class: "pictures" },
    element("div", { class: "images" }, ...images),
    element("div", { class: "labels" }, ...buttons),
  );
}
