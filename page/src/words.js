/** Until the server has said in which language, only this can be needed. */
export const FIRST_WORDS = {
  language: "en",
  direction: "ltr",
  title: "Lockprobe",
  consent: { agree: "", decline: "" },
  debrief: { completion: "", code: "{code}" },
  page: {
    waiting: "One moment …",
    offline: "No connection. Trying again …",
    refused: "That could not be taken.",
    incomplete: "This link is incomplete.",
    reload: "Try again",
  },
};

/**
 * Says to browsers and screen readers in which language the page is.
 *
 * @param {typeof FIRST_WORDS} words
 */
export function speak(words) {
  document.documentElement.lang = words.language;
  document.documentElement.dir = words.direction;
  document.title = words.title;
}

/**
 * A text with its `{names}` filled in; what is in braces and no fact stays as it is.
 *
 * @param {string} text
 * @param {Record<string, unknown>} facts
 */
export function filled(text, facts) {
  return text.replace(/\{(\w+)\}/g, (whole, name) => (Object.hasOwn(facts, name) ? String(facts[name]) : whole));
}
