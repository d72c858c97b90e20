import { actButton, element, heading, noticeOf, paragraphs } from "../element.js";
import { filled } from "../words.js";

/** A question: one of some options, or words. */
export function questionOf(scene, words, answer) {
  const title = heading(scene.question);
  title.id = "question";
  const field = scene.options.length ? choices(scene.options, "answer", "question") : room(scene);
  const required = scene.kind === "check" || scene.required;
  const missing = element("p", { class: "missing", role: "alert" });
  const send = (event) => {
    event.preventDefault();
    const answered = given(field);
    answer(event, (rt) => {
      if ((required && !answered) || (answered && !fits(scene, answered))) {
        const wanted = scene.type === "integer" ? words.page.integer : words.page.number;
        missing.textContent = answered ? filled(wanted, { limits: limits(scene) }) : words.page.required;
        field.querySelector("input, textarea").focus();
        return null;
      }
      return { kind: "answer", answer: answered, rt };
    });
  };
  const skip = (event) => answer(event, (rt) => ({ kind: "answer", answer: "", rt }));
  const keyed = (key) => {
    const input = field.querySelectorAll("input[type=radio]")[Number(key) - 1];
    if (!input) return;
    input.checked = true;
    missing.replaceChildren();
    input.focus();
  };
  const acts = element(
    "div",
    { class: "acts" },
    actButton("answer", words.page.send, null, "first"),
    required ? null : actButton("skip", words.page.skip, skip),
  );
  return { part: form(send, missing, title, field, missing, acts), keyed };
}

/** Questions on the instructions, all of which have to be answered at once. */
export function answersOf(scene, words, answer) {
  const fields = scene.questions.map(({ question, options }, i) =>
    element(
      "fieldset",
      { class: "question", "data-question": i + 1 },
      element("legend", {}, question),
      choices(options, `answer-${i}`),
    ),
  );
  const missing = element("p", { class: "missing", role: "alert" });
  const send = (event) => {
    event.preventDefault();
    answer(event, (rt) => {
      const chosen = fields.map((field) => field.querySelector("input:checked"));
      const open = chosen.indexOf(null);
      if (open < 0) return { kind: "answers", answers: chosen.map((input) => input.value), rt };
      missing.textContent = words.page.all_required;
      fields[open].querySelector("input").focus();
      return null;
    });
  };
  const acts = element("div", { class: "acts" }, actButton("answers", words.page.send, null, "first"));
  const text = [heading(scene.title), ...noticeOf(scene), ...paragraphs(scene.paragraphs)];
  return { part: form(send, missing, ...text, ...fields, missing, acts) };
}

/** A form; what is missing is said until something is written or chosen. */
function form(onsubmit, missing, ...children) {
  const oninput = () => missing.replaceChildren();
  return element("form", { class: "words", novalidate: true, onsubmit, oninput }, ...children);
}

function choices(texts, name, labelled) {
  const rows = texts.map((text) =>
    element(
      "label",
      { class: "option", "data-option": text },
      element("input", { type: "radio", name, value: text }),
      element("span", {}, text),
    ),
  );
  const group = labelled ? { role: "radiogroup", "aria-labelledby": labelled } : {};
  return element("div", { class: "options", ...group }, ...rows);
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

/** Room for a number or for words. */
function room(scene) {
  const own = { "aria-labelledby": "question", "data-field": "answer" };
  if (!(scene.type in NUMBERS)) {
    return element("div", {}, element("textarea", { rows: 5, maxlength: scene.longest, ...own }));
  }
  const inputmode = scene.type === "integer" ? "numeric" : "decimal";
  return element("div", {}, element("input", { type: "text", inputmode, maxlength: 32, autocomplete: "off", ...own }));
}

/** An option exactly as it came, or words without space around them. */
function given(field) {
  const chosen = field.querySelector("input:checked, input[type=text], textarea");
  if (!chosen) return "";
  return chosen.type === "radio" ? chosen.value : chosen.value.trim();
}
