import { actButton, acts, element, heading, noticeOf, paragraphs } from "../element.js";

/** Questions, all answered at once: of a page with a title, or one that is the title itself. */
export function questionsOf(scene, { page: words }, answer) {
  const alone = !scene.title;
  const fields = scene.questions.map((asked, i) => fieldOf(asked, i, alone, scene.longest));
  const send = (event) =>
    answer(event, (rt) => {
      const answers = fields.map(given);
      const open = answers.findIndex((said, i) => scene.questions[i].required && !said);
      if (open < 0) return { kind: "answers", answers, rt };
      say(alone ? words.required : words.all_required);
      fields[open].querySelector("input, textarea").focus();
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

/** One question: options to choose from, or room for words. */
function fieldOf({ question, options }, i, alone, longest) {
  const choices = options.map((text) =>
    element(
      "label",
      { class: "option", "data-option": text },
      element("input", { type: "radio", name: `answer-${i}`, value: text }),
      element("span", {}, text),
    ),
  );
  const written = { rows: 5, maxlength: longest, "aria-labelledby": `question-${i}`, "data-field": "answer" };
  const room = choices.length ? element("div", { class: "options" }, ...choices) : element("textarea", written);
  const title = alone ? heading(question) : question;
  return element(
    "fieldset",
    { class: "question", "data-question": i + 1 },
    element("legend", { id: `question-${i}` }, title),
    room,
  );
}

/** An option exactly as it came, or words without space around them; empty for none. */
function given(field) {
  return field.querySelector("input:checked")?.value ?? field.querySelector("textarea")?.value.trim() ?? "";
}
