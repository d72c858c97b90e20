import { actButton, acts, element, filled, heading, noticeOf, paragraphs } from "../element.js";

/** Whether somebody takes part. Nothing is chosen beforehand. */
export function consentOf(scene, words, answer) {
  const choice = (agreed) => (event) => answer(event, () => ({ kind: "agree", agreed }));
  const choices = acts(
    actButton("agree", words.consent.agree, choice(true), "first"),
    actButton("decline", words.consent.decline, choice(false)),
  );
  return { part: article(scene, heading(scene.title), ...paragraphs(scene.paragraphs), choices) };
}

/** Something to read: a page, what is said after a box, and the ends: a debriefing and a closed door. */
export function textOf(scene, words, answer) {
  const isPage = scene.kind === "page";
  const next = (event) => answer(event, () => ({ kind: "next" }));
  const ends = scene.kind === "debrief" || scene.kind === "closed";
  const part = article(
    scene,
    isPage && scene.of > 1 ? element("p", { class: "where" }, `${scene.number} / ${scene.of}`) : null,
    heading(scene.title),
    ...noticeOf(scene),
    ...paragraphs(scene.paragraphs),
    ...(ends
      ? wayBack(scene, words)
      : [acts(actButton("next", scene.begins ? words.page.begin : words.page.next, next, "first"))]),
  );
  return { part };
}

function article(scene, ...children) {
  return element("article", { class: "words", "data-solved": scene.solved ?? null }, ...children);
}

/** How to go on where participants came from. Who comes no further completes nothing. */
function wayBack(scene, words) {
  const [code, leave] =
    scene.kind === "debrief"
      ? [words.debrief.code, words.debrief.completion]
      : [words.page.closed_code, words.page.closed_leave];
  const given = { class: "code", "data-code": scene.completion_code };
  const away = { class: "button first", href: scene.completion_url, rel: "noreferrer", "data-act": "leave" };
  return [
    scene.completion_code ? element("p", given, filled(code, { code: scene.completion_code })) : null,
    scene.completion_url.startsWith("https://") ? acts(element("a", away, leave)) : null,
  ];
}
