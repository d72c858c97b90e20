import { actButton, acts, element, filled, heading, noticeOf, paragraphs } from "../element.js";

/** A question: one of some options, or words. */
export function questionOf(scene, words, answer) {
  const title = heading(scene.question);
  title.id = "question";
  const field = scene.options.length ? choices(scene.options, "answer", "question") : room(scene);
  const required = scene.kind === "check" || scene.required;
  const send = (event) =>
    answer(event, (rt) => {
      const answered = given(field);
      const input = field.querySelector("input, textarea");
      if (input.validity.valid && (answered || !required)) return { kind: "answer", answer: answered, rt };
      const wanted = scene.type === "integer" ? words.page.integer : words.page.number;
      say(input.validity.valid ? words.page.required : filled(wanted, { limits: limits(scene) }));
      input.focus();
      return null;
    });
  const skip = (event) => answer(event, (rt) => ({ kind: "answer", answer: "", rt }));
  const keyed = (key) => {
    const input = field.querySelectorAll("input[type=radio]")[Number(key) - 1];
    if (!input) return;
    input.checked = true;
    say("");
    input.focus();
  };
  const buttons = [actButton("answer", words.page.send, null, "first")];
  if (!required) buttons.push(actButton("skip", words.page.skip, skip));
  const { part, say } = form(send, buttons, title, field);
  return { part, keyed };
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
  const send = (event) =>
    answer(event, (rt) => {
      const chosen = fields.map((field) => field.querySelector("input:checked"));
      const open = chosen.indexOf(null);
      if (open < 0) return { kind: "answers", answers: chosen.map((input) => input.value), rt };
      say(words.page.all_required);
      fields[open].querySelector("input").focus();
      return null;
    });
  const text = [heading(scene.title), ...noticeOf(scene), ...paragraphs(scene.paragraphs)];
  const { part, say } = form(send, [actButton("answers", words.page.send, null, "first")], ...text, ...fields);
  return { part };
}

/** A form, and what says what is missing until something is written or chosen. */
function form(send, buttons, ...children) {
  const missing = element("p", { class: "missing", role: "alert" });
  const say = (text) => (missing.textContent = text);
  const onsubmit = (event) => {
    event.preventDefault();
    send(event);
  };
  const how = { class: "words", novalidate: true, onsubmit, oninput: () => say("") };
  return { part: element("form", how, ...children, missing, acts(...buttons)), say };
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

/** Between what a number has to be, in signs that every language has. */
function limits({ low, high }) {
  return low === null && high === null ? "" : ` (${low ?? "…"} – ${high ?? "…"})`;
}

/** Room for a number or for words; the browser knows what a number is, and the server looks again. */
function room({ type, longest, low, high }) {
  const own = { "aria-labelledby": "question", "data-field": "answer" };
  const number = { type: "number", step: type === "integer" ? 1 : "any", min: low, max: high, autocomplete: "off" };
  const field =
    type === "text"
      ? element("textarea", { rows: 5, maxlength: longest, ...own })
      : element("input", { ...number, ...own });
  return element("div", {}, field);
}

/** An option exactly as it came, or words without space around them. */
function given(field) {
  const chosen = field.querySelector("input:checked, input[type=number], textarea");
  return chosen?.type === "radio" ? chosen.value : (chosen?.value.trim() ?? "");
}
