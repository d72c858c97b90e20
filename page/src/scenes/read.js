import { actButton, acts, element, filled, heading, noticeOf, paragraphs } from "../element.js";

/** Something to read: consent, a page, what is said after a box, and the ends: a debriefing and a closed door. */
export function textOf(scene, { page: words }, answer) {
  const does = (act, text, done, looks) => actButton(act, text, (event) => answer(event, done), looks);
  const agrees = (agreed) => () => ({ kind: "agree", agreed });
  const read = (rt) => ({ kind: "answers", answers: [], rt });
  const buttons = {
    consent: () => [
      does("agree", words.agree, agrees(true), "first"),
      does("decline", words.decline, agrees(false)),
    ],
    debrief: () => wayBack(scene, words),
    closed: () => wayBack(scene, words),
  };
  const next = () => [does("next", scene.begins ? words.begin : words.next, read, "first")];
  const below = (buttons[scene.kind] ?? next)();
  const part = element(
    "article",
    { class: "words", "data-solved": scene.solved ?? null },
    scene.kind === "page" && scene.of > 1 ? element("p", { class: "where" }, `${scene.number} / ${scene.of}`) : null,
    heading(scene.title),
    ...noticeOf(scene),
    ...paragraphs(scene.paragraphs),
    scene.code ? element("p", { class: "code", "data-code": scene.code }, filled(words.code, scene)) : null,
    below.length ? acts(...below) : null,
  );
  return { part };
}

/** How to go on where participants came from. */
function wayBack({ url }, words) {
  const away = { class: "button first", href: url, rel: "noreferrer", "data-act": "leave" };
  return url.startsWith("https://") ? [element("a", away, words.leave)] : [];
}
