import { element } from "./element.js";
import { filled } from "./words.js";

/**
 * How far a participant is in the whole study: a bar, and the boxes that are done.
 *
 * @param {HTMLElement} place
 * @param {{share: number, done: number, of: number} | null} progress Null where nobody takes part.
 * @param {Record<string, string>} words
 */
export function showProgress(place, progress, words) {
  if (!progress) {
    place.replaceChildren();
    return;
  }
  const { share, done, of } = progress;
  const percent = Math.round(100 * share);
  const text = filled(words.progress, { done, of });
  const bar = element("span", { class: "way-done" });
  bar.style.width = `${percent}%`;
  const facts = { role: "progressbar", "aria-valuenow": percent, "aria-valuemin": 0, "aria-valuemax": 100 };
  place.replaceChildren(
    element("span", { class: "whole-way", ...facts, "aria-label": text }, bar),
    element("span", { "aria-hidden": "true" }, text),
  );
}
