import { ParameterType } from "jspsych";

import { SceneClock } from "../clock.js";
import { meant } from "../choosing.js";
import { element, heading, paragraphs } from "../element.js";

const info = {
  name: "lockprobe-consent",
  version: "1.0.0",
  parameters: {
    /** A scene of the kind `consent`. */
    scene: { type: ParameterType.OBJECT },
    /** Texts. */
    words: { type: ParameterType.OBJECT },
    /** Tells the server what was done; afterwards there is a new scene. */
    act: { type: ParameterType.FUNCTION },
  },
  data: {
    /** Whether somebody takes part. */
    agreed: { type: ParameterType.BOOL },
    /** How long it was read, in ms since it was painted. */
    rt: { type: ParameterType.FLOAT },
  },
};

/** Whether somebody takes part. Nothing is chosen beforehand. */
export class ConsentPlugin {
  static info = info;

  trial(display, { scene, words, act }, onLoad) {
    return new Promise((resolve) => {
      const title = heading(scene.title);
      const field = scene.ask_code ? element("input", { type: "text", autocomplete: "off", maxlength: 64 }) : null;
      const code = field ? element("p", {}, element("label", { class: "field" }, words.page.code, " ", field)) : null;
      const choice = (agreed) => async (event) => {
        const rt = clock.now();
        const code = field ? field.value.trim() : "";
        if (agreed && field && !code) {
          field.focus();
          return;
        }
        if (acts.getAttribute("aria-disabled") || !meant(event, rt)) return;
        for (const part of [acts, ...acts.children]) part.setAttribute("aria-disabled", "true");
        await act(code ? { kind: "agree", agreed, code } : { kind: "agree", agreed });
        resolve({ agreed, rt });
      };
      const acts = element(
        "div",
        { class: "acts", role: "group" },
        element(
          "button",
          { type: "button", class: "first", "data-act": "agree", onclick: choice(true) },
          words.consent.agree,
        ),
        element("button", { type: "button", "data-act": "decline", onclick: choice(false) }, words.consent.decline),
      );
      display.append(element("article", { class: "words" }, title, ...paragraphs(scene.paragraphs), code, acts));
      const clock = new SceneClock();
      title.focus();
      onLoad();
    });
  }
}
