import { element } from "../element.js";
import { filled } from "../words.js";

/**
 * What was told of one step, in the language of the page. In English it is, word for word, what models read.
 *
 * @param {{joint: string | null, outcome: "moved" | "blocked" | null, ones: readonly string[] | null}} report `ones`
 *   are the joints that are told to be at position 1; null where no positions are told.
 * @param {Record<string, string>} words
 * @returns {string[]}
 */
function sentences({ joint, outcome, ones }, words) {
  const found = [];
  if (outcome) found.push(filled(words[outcome], { label: joint }));
  else if (ones && joint !== null) found.push(filled(words.attempted, { label: joint }));
  if (ones) found.push(filled(words.positions, { labels: ones.join(", ") || words.none }));
  return found;
}

function now({ last, outcome, joints }) {
  const told = joints.some(({ position }) => position !== null);
  return {
    joint: last,
    outcome,
    ones: told ? joints.filter(({ position }) => position).map(({ label }) => label) : null,
  };
}

/**
 * What came of the last attempt, in words; what the panel shows is not said again.
 *
 * @param {object} scene
 * @param {Record<string, string>} words
 * @returns {string[]}
 */
export function reportOf(scene, words) {
  const { view, last } = scene.panel;
  const said = view === "pictures" ? [] : sentences(now(scene.panel), words);
  if (last === null) return view === "text" ? [words.first, ...said] : [words.first];
  if (view === "pictures") return [filled(words.seen, { label: last })];
  return view === "text" ? said : said.slice(0, 1);
}

/**
 * The same for those who hear it: also what the panel shows.
 *
 * @param {object} scene
 * @param {Record<string, string>} words
 */
export function spokenReport(scene, words) {
  const { view, last } = scene.panel;
  const told = last !== null && view === "panel" ? sentences(now(scene.panel), words) : reportOf(scene, words);
  return [...told, `${filled(words.step, { step: scene.step, budget: scene.budget })}.`].join(" ");
}

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
  const rows = [...scene.history].reverse().map((report) => {
    const told = sentences(report, words).join(" ");
    return element("li", { value: report.step }, told || filled(words.joint, { label: report.joint }));
  });
  const list = element(
    "details",
    { class: "history", open: open ?? scene.history_open },
    element("summary", {}, words.history),
    element("ol", { reversed: true, tabindex: 0, "aria-label": words.history }, ...rows),
  );
  list.addEventListener("toggle", () => (open = list.open));
  return list;
}
