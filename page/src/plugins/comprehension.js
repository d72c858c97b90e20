import { ParameterType } from "jspsych";

import { SceneClock } from "../clock.js";
import { meant } from "../choosing.js";
import { element, heading, noticeOf, paragraphs } from "../element.js";

const info = {
  name: "lockprobe-comprehension",
  version: "1.0.0",
  parameters: {
    /** A scene of the kind `comprehension`: questions with options. */
    scene: { type: ParameterType.OBJECT },
    /** Texts. */
    words: { type: ParameterType.OBJECT },
    /** Tells the server what was done; afterwards there is a new scene. */
    act: { type: ParameterType.FUNCTION },
  },
  data: {
    /** One of the options of each question. */
    answers: { type: ParameterType.STRING, array: true },
    /** From when the questions were painted to the answers, ms. */
    rt: { type: ParameterType.FLOAT },
  },
};

/** Questions on the instructions, all of which have to be answered at once. */
export class ComprehensionPlugin {
  static info = info;

  trial(display, { scene, words, act }, onLoad) {
    return new Promise((resolve) => {
      const title = heading(scene.title);
      const fields = scene.questions.map(questionOf);
      const missing = element("p", { class: "missing", role: "alert" });
      const send = async (event) => {
        event.preventDefault();
        const rt = clock.now();
        if (form.getAttribute("aria-disabled") || !meant(event, rt)) return;
        const chosen = fields.map((field) => field.querySelector("input:checked"));
        const open = chosen.indexOf(null);
        if (open >= 0) {
          missing.textContent = words.page.all_required;
          fields[open].querySelector("input").focus();
          return;
        }
        form.setAttribute("aria-disabled", "true");
        for (const button of form.querySelectorAll("button")) button.setAttribute("aria-disabled", "true");
        const answers = chosen.map((input) => input.value);
        await act({ kind: "answers", answers, rt });
        resolve({ answers, rt });
      };
      const form = element(
        "form",
        { class: "words", novalidate: true, onsubmit: send, oninput: () => missing.replaceChildren() },
        title,
        ...noticeOf(scene),
        ...paragraphs(scene.paragraphs),
        ...fields,
        missing,
        element(
          "div",
          { class: "acts" },
          element("button", { type: "submit", class: "first", "data-act": "answers" }, words.page.send),
        ),
      );
      display.append(form);
      const clock = new SceneClock();
      title.focus();
      onLoad();
    });
  }
}

function questionOf({ question, options }, i) {
  const rows = options.map((text) =>
    element(
      "label",
      { class: "option", "data-option": text },
      element("input", { type: "radio", name: `answer-${i}`, value: text }),
      element("span", {}, text),
    ),
  );
  return element(
    "fieldset",
    { class: "question", "data-question": i + 1 },
    element("legend", {}, question),
    element("div", { class: "options" }, ...rows),
  );
}
