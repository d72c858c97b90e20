import { element } from "../element.js";

let open = null; // as somebody set it; before that as the study has it, on every screen

/**
 * What was told before in this trial, the newest first; null if nothing is shown of it.
 *
 * @param {object} scene
 * @param {Record<string, string>} words
 * @returns {HTMLElement | null}
 */
export function historyOf(scene, words) {
  if (!scene.history.length) return null;
  const rows = scene.history.map((said, i) => element("li", { value: i + 1 }, said)).reverse();
  const list = element(
    "details",
    { class: "history", open: open ?? scene.history_open },
    element("summary", {}, words.history),
    element("ol", { reversed: true, tabindex: 0, "aria-label": words.history }, ...rows),
  );
  list.addEventListener("toggle", () => (open = list.open));
  return list;
}
