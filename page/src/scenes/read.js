import { examplesOf } from "../box/example.js";
import { actButton, element, heading, noticeOf, paragraphs } from "../element.js";
import { filled } from "../words.js";

/** Whether somebody takes part. Nothing is chosen beforehand. */
export function consentOf(scene, words, answer) {
  const field = scene.ask_code ? element("input", { type: "text", autocomplete: "off", maxlength: 64 }) : null;
  const code = field ? element("p", {}, element("label", { class: "field" }, words.page.code, " ", field)) : null;
  const choice = (agreed) => (event) => {
    const given = field ? field.value.trim() : "";
    if (agreed && field && !given) field.focus();
    else answer(event, () => (given ? { kind: "agree", agreed, code: given } : { kind: "agree", agreed }));
  };
  const acts = element(
    "div",
    { class: "acts", role: "group" },
    actButton("agree", words.consent.agree, choice(true), "first"),
    actButton("decline", words.consent.decline, choice(false)),
  );
  return { part: article(scene, heading(scene.title), ...paragraphs(scene.paragraphs), code, acts) };
}

/** Something to read: a page, what is said after a box, and the ends: a debriefing and a closed door. */
export function textOf(scene, words, answer) {
  const part = article(
    scene,
    scene.kind === "page" && scene.of > 1 ? element("p", { class: "where" }, `${scene.number} / ${scene.of}`) : null,
    heading(scene.title),
    ...noticeOf(scene),
    ...paragraphs(scene.paragraphs),
    ...(scene.kind === "page" ? examplesOf(scene, words.page) : []),
  );
  if (scene.kind === "debrief" || scene.kind === "closed") part.append(...wayBack(scene, words));
  else {
    const next = (event) => answer(event, () => ({ kind: "next" }));
    const text = scene.begins ? words.page.begin : words.page.next;
    part.append(element("div", { class: "acts" }, actButton("next", text, next, "first")));
  }
  return { part };
}

function article(scene, ...children) {
  const result = scene.kind === "over" && scene.solved !== null ? scene.solved : null;
  return element("article", { class: "words", "data-solved": result }, ...children);
}

/** How to go on where participants came from. Who comes no further completes nothing. */
function wayBack(scene, words) {
  const [code, leave] =
    scene.kind === "debrief"
      ? [words.debrief.code, words.debrief.completion]
      : [words.page.closed_code, words.page.closed_leave];
  const found = [];
  if (scene.completion_code) {
    const given = { class: "code", "data-code": scene.completion_code };
    found.push(element("p", given, filled(code, { code: scene.completion_code })));
  }
  if (scene.completion_url.startsWith("https://")) {
    const away = { class: "button first", href: scene.completion_url, rel: "noreferrer", "data-act": "leave" };
    found.push(element("div", { class: "acts" }, element("a", away, leave)));
  }
  return found;
}
