import { ParameterType } from "jspsych";

import { SceneClock } from "../clock.js";
import { meant, onKeys } from "../choosing.js";
import { element, heading } from "../element.js";
import { filled } from "../words.js";

const info = {
  name: "lockprobe-answer",
  version: "1.0.0",
  parameters: {
    /** A scene of the kind `check` or `ask`: a question, with options or with room for words. */
    scene: { type: ParameterType.OBJECT },
    /** Texts. */
    words: { type: ParameterType.OBJECT },
    /** Tells the server what was done; afterwards there is a new scene. */
    act: { type: ParameterType.FUNCTION },
  },
  data: {
    /** One of the options, or words; empty if it was left out. */
    answer: { type: ParameterType.STRING },
    /** From when the question was painted to the answer, ms. */
    rt: { type: ParameterType.FLOAT },
  },
};

/** A question: one of some options, or words. */
export class AnswerPlugin {
  static info = info;

  trial(display, { scene, words, act }, onLoad) {
    return new Promise((resolve) => {
      const title = heading(scene.question);
      title.id = "question";
      const field = scene.options.length ? choices(scene.options) : room(scene);
      const required = scene.kind === "check" || scene.required;
      const missing = element("p", { class: "missing", role: "alert" });
      const answered = async (answer, event) => {
        const rt = clock.now();
        if (form.getAttribute("aria-disabled") || !meant(event, rt)) return;
        if (required && !answer) {
          missing.textContent = words.page.required;
          field.querySelector("input, textarea").focus();
          return;
        }
        if (answer && !fits(scene, answer)) {
          const wanted = scene.type === "integer" ? words.page.integer : words.page.number;
          missing.textContent = filled(wanted, { limits: limits(scene) });
          field.querySelector("input").focus();
          return;
        }
        form.setAttribute("aria-disabled", "true");
        for (const button of form.querySelectorAll("button")) button.setAttribute("aria-disabled", "true");
        endKeys();
        await act({ kind: "answer", answer, rt });
        resolve({ answer, rt });
      };
      const send = (event) => {
        event.preventDefault();
        answered(given(field), event);
      };
      field.addEventListener("input", () => missing.replaceChildren());
      const skip = (event) => answered("", event);
      const form = element(
        "form",
        { class: "words", novalidate: true, onsubmit: send },
        title,
        field,
        missing,
        element(
          "div",
          { class: "acts" },
          element("button", { type: "submit", class: "first", "data-act": "answer" }, words.page.send),
          required ? null : element("button", { type: "button", "data-act": "skip", onclick: skip }, words.page.skip),
        ),
      );
      const endKeys = onKeys((key) => {
        const input = field.querySelectorAll("input[type=radio]")[Number(key) - 1];
        if (input) {
          input.checked = true;
          missing.replaceChildren();
          input.focus();
        }
      });
      display.append(form);
      const clock = new SceneClock();
      title.focus();
      onLoad();
    });
  }
}

function choices(texts) {
  const rows = texts.map((text) =>
    element(
      "label",
      { class: "option", "data-option": text },
      element("input", { type: "radio", name: "answer", value: text }),
      element("span", {}, text),
    ),
  );
  return element("div", { class: "options", role: "radiogroup", "aria-labelledby": "question" }, ...rows);
}

const NUMBERS = { number: /^[+-]?[0-9]{1,15}([.,][0-9]{1,15})?$/, integer: /^[+-]?[0-9]{1,15}$/ };

/** Whether a written answer is of the kind that is asked for; the server looks again. */
function fits({ type, low, high }, answer) {
  if (!(type in NUMBERS)) return true;
  const number = Number(answer.replace(",", "."));
  return NUMBERS[type].test(answer) && !(low !== null && number < low) && !(high !== null && number > high);
}

/** Between what a number has to be, in signs that every language has. */
function limits({ low, high }) {
  if (low !== null && high !== null) return ` (${low} – ${high})`;
  if (low !== null) return ` (≥ ${low})`;
  return high !== null ? ` (≤ ${high})` : "";
}

function room(scene) {
  if (scene.type in NUMBERS) {
    const inputmode = scene.type === "integer" ? "numeric" : "decimal";
    const given = { type: "text", inputmode, maxlength: 32, autocomplete: "off", "data-field": "answer" };
    return element("div", {}, element("input", { ...given, "aria-labelledby": "question" }));
  }
  return element(
    "div",
    {},
    element("textarea", { rows: 5, maxlength: scene.longest, "aria-labelledby": "question", "data-field": "answer" }),
  );
}

/** An option exactly as it came, or words without space around them. */
function given(field) {
  const chosen = field.querySelector("input:checked, input[type=text], textarea");
  if (!chosen) return "";
  return chosen.type === "radio" ? chosen.value : chosen.value.trim();
}
