import { element } from "../element.js";
import { filled } from "../words.js";

/**
 * What was told of one step, in the language of the page, and where the joint is now.
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
  if (ones && joint !== null) found.push(filled(words.now, { label: joint, position: Number(ones.includes(joint)) }));
  if (ones) found.push(filled(words.positions, { labels: ones.join(", ") || words.none }));
  return found;
}

/** Whether it is told where joints are. */
function known({ joints }) {
  return joints.some(({ position }) => position !== null);
}

/** What the panel says of the last attempt, in sentences; nothing where nothing was reported, and with pictures. */
function now({ view, last, outcome, joints, told, verbatim }, words) {
  if (view === "pictures") return [];
  if (verbatim) return [told];
  const ones = known({ joints }) ? joints.filter(({ position }) => position).map(({ label }) => label) : null;
  return sentences({ joint: last, outcome, ones }, words);
}

/**
 * What came of the last attempt, in words; what the panel shows is not said again.
 *
 * @param {object} scene
 * @param {Record<string, string>} words
 * @returns {string[]}
 */
export function reportOf(scene, words) {
  const { view, last, verbatim, pictures } = scene.panel;
  const said = now(scene.panel, words);
  if (isFirst(scene)) return verbatim ? [words.first, ...said] : [words.first];
  if (view === "pictures" && pictures.length) return [filled(words.seen, { label: last })];
  if (!said.length) return [words.no_report];
  return verbatim ? said : said.slice(0, last !== null && known(scene.panel) ? 2 : 1);
}

/** Whether nothing was attempted. An example has no step, and a late report names no joint. */
function isFirst({ step, panel }) {
  return panel.last === null && !(step > 1);
}

/**
 * The same for those who hear it: also what the panel shows, and what is said beside the report.
 *
 * @param {object} scene
 * @param {Record<string, string>} words
 */
export function spokenReport(scene, words) {
  const { view } = scene.panel;
  const drawn = view === "panel" && !isFirst(scene) ? now(scene.panel, words) : [];
  const told = drawn.length ? drawn : reportOf(scene, words);
  const step = `${filled(words.step, { step: scene.step, budget: scene.budget })}.`;
  return [...told, scene.remark, scene.step === 1 ? scene.warning : "", step].filter(Boolean).join(" ");
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
    const told = report.verbatim ? report.told : sentences({ ...report, joint: report.about }, words).join(" ");
    const said = [told || filled(words.joint, { label: report.joint }), report.remark].filter(Boolean).join(" ");
    return element("li", { value: report.step }, said);
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
