import { ParameterType } from "jspsych";

import { examplesOf } from "../box/example.js";
import { SceneClock } from "../clock.js";
import { meant } from "../choosing.js";
import { element, heading, noticeOf, paragraphs } from "../element.js";
import { filled } from "../words.js";

const info = {
  name: "lockprobe-read",
  version: "1.0.0",
  parameters: {
    /** A scene of the kind `page`, `over`, `debrief` or `closed`: a title, and what stands under it. */
    scene: { type: ParameterType.OBJECT },
    /** Texts. */
    words: { type: ParameterType.OBJECT },
    /** Tells the server what was done; afterwards there is a new scene. */
    act: { type: ParameterType.FUNCTION },
  },
  data: {
    /** How long it was read, in ms since it was painted. */
    rt: { type: ParameterType.FLOAT },
  },
};

/** Something to read. A debriefing and a closed door are the end. */
export class ReadPlugin {
  static info = info;

  async trial(display, { scene, words, act }, onLoad) {
    const ends = scene.kind === "debrief" || scene.kind === "closed";
    const title = heading(scene.title);
    const result = scene.kind === "over" && scene.solved !== null ? scene.solved : null;
    const article = element(
      "article",
      { class: "words", "data-solved": result },
      scene.kind === "page" && scene.of > 1 ? element("p", { class: "where" }, `${scene.number} / ${scene.of}`) : null,
      title,
      ...noticeOf(scene),
      ...paragraphs(scene.paragraphs),
      ...(scene.kind === "page" ? examplesOf(scene, words.page) : []),
      ...(ends ? wayBack(scene, words) : []),
    );
    display.append(article);
    const clock = new SceneClock();
    title.focus();
    onLoad();
    if (ends) return new Promise(() => {});
    return new Promise((resolve) => {
      const next = async (event) => {
        const rt = clock.now();
        if (button.getAttribute("aria-disabled") || !meant(event, rt)) return;
        button.setAttribute("aria-disabled", "true");
        await act({ kind: "next" });
        resolve({ rt });
      };
      const text = scene.begins ? words.page.begin : words.page.next;
      const button = element("button", { type: "button", class: "first", "data-act": "next", onclick: next }, text);
      article.append(element("div", { class: "acts" }, button));
    });
  }
}

/** How to go on where participants came from. Who comes no further completes nothing. */
function wayBack(scene, words) {
  const further = scene.kind === "debrief";
  const [code, leave] = further
    ? [words.debrief.code, words.debrief.completion]
    : [words.page.closed_code, words.page.closed_leave];
  const found = [];
  if (scene.completion_code) {
    found.push(
      element(
        "p",
        { class: "code", "data-code": scene.completion_code },
        filled(code, { code: scene.completion_code }),
      ),
    );
  }
  if (scene.completion_url.startsWith("https://")) {
    const link = element(
      "a",
      { class: "button first", href: scene.completion_url, rel: "noreferrer", "data-act": "leave" },
      leave,
    );
    found.push(element("div", { class: "acts" }, link));
  }
  return found;
}
