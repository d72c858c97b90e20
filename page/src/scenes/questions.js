import { actButton, acts, element, filled, heading, noticeOf, paragraphs } from "../element.js";

/** Questions, all answered at once: of a page with a title, or one that is the title itself. */
export function questionsOf(scene, { page: words }, answer) {
  const alone = !scene.title;
  const fields = scene.questions.map((asked, i) => fieldOf(asked, i, alone, scene.longest));
  const send = (event) =>
    answer(event, (rt) => {
      const wrong = fields.findIndex((field, i) => !isAnswered(scene.questions[i], field));
      if (wrong < 0) return { kind: "answers", answers: fields.map(given), rt };
      const input = inputOf(fields[wrong]);
      say(input.validity.valid ? words[alone ? "required" : "all_required"] : numberWanted(scene.questions[wrong], words));
      input.focus();
      return null;
    });
  const skip = (event) => answer(event, (rt) => ({ kind: "answers", answers: [""], rt }));
  const keyed = (key) => {
    const input = alone && fields[0].querySelectorAll("input[type=radio]")[Number(key) - 1];
    if (!input) return;
    input.checked = true;
    say("");
    input.focus();
  };
  const missing = element("p", { class: "missing", role: "alert" });
  const say = (text) => (missing.textContent = text);
  const onsubmit = (event) => {
    event.preventDefault();
    send(event);
  };
  const optional = alone && !scene.questions[0].required;
  const part = element(
    "form",
    { class: "words", novalidate: true, onsubmit, oninput: () => say("") },
    alone ? null : heading(scene.title),
    ...noticeOf(scene),
    ...paragraphs(scene.paragraphs),
    ...fields,
    missing,
    acts(actButton("answers", words.send, null, "first"), ...(optional ? [actButton("skip", words.skip, skip)] : [])),
  );
  return { part, keyed };
}

/** One question: options to choose from, or room for a number or for words. */
function fieldOf({ question, options, type, low, high }, i, alone, longest) {
  const own = { "aria-labelledby": `question-${i}`, "data-field": "answer" };
  const number = { type: "number", step: type === "integer" ? 1 : "any", min: low, max: high, autocomplete: "off" };
  const choices = options.map((text) =>
    element(
      "label",
      { class: "option", "data-option": text },
      element("input", { type: "radio", name: `answer-${i}`, value: text }),
      element("span", {}, text),
    ),
  );
  const written = () =>
    type === "text"
      ? element("textarea", { rows: 5, maxlength: longest, ...own })
      : element("input", { ...number, ...own });
  const room = choices.length ? element("div", { class: "options" }, ...choices) : written();
  const title = alone ? heading(question) : question;
  return element(
    "fieldset",
    { class: "question", "data-question": i + 1 },
    element("legend", { id: `question-${i}` }, title),
    room,
  );
}

/** Where an answer is given: what was chosen or could be, or what is written in. */
function inputOf(field) {
  return field.querySelector("input:checked") ?? field.querySelector("input, textarea");
}

/** An option exactly as it came, or words without space around them. */
function given(field) {
  const input = inputOf(field);
  if (input.type === "radio") return input.checked ? input.value : "";
  return input.value.trim();
}

/** Whether a question has what it needs; the browser knows what a number is, and the server looks again. */
function isAnswered({ required }, field) {
  return inputOf(field).validity.valid && (given(field) !== "" || !required);
}

/** Between what a number has to be, in signs that every language has. */
function numberWanted({ type, low, high }, words) {
  const limits = low === null && high === null ? "" : ` (${low ?? "…"} – ${high ?? "…"})`;
  return filled(type === "integer" ? words.integer : words.number, { limits });
}
