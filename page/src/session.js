import { ask, showConnection } from "./dialogs.js";

const LONGEST = 64; // characters of a parameter that goes along
const MOST = 40; // parameters that go along, as many as the server reads
const PATIENCE = 15_000; // ms for one request
const FIRST_WAIT = 500; // ms; doubled with each failure
const LONGEST_WAIT = 4_000; // ms

/** Until the server has said in which language, only this can be needed. */
const FIRST_WORDS = {
  offline: "No connection. Trying again …",
  refused: "That could not be taken.",
  incomplete: "This link is incomplete.",
  reload: "Try again",
};

/** The parameters of the URL, as recruitment platforms set them; the server keeps those that it was told to keep. */
function platform() {
  const short = ([name, value]) => name.length <= LONGEST && value.length <= LONGEST;
  return Object.fromEntries([...new URLSearchParams(location.search)].filter(short).slice(0, MOST));
}

/** What the server shows to this tab, and how it is answered. One thing is said at a time. */
export class Session {
  /** What the server sent last: `scene`, its number `turn`, `progress`, and the `participant`. */
  shown = { scene: { kind: "none" }, turn: 0 };
  words = { page: FIRST_WORDS };
  #line = Promise.resolve();

  /** The scene in which this participant is; other tabs cannot act any more. */
  open() {
    return this.#inTurn(() => this.#opened());
  }

  /** Does something in the present scene. Afterwards there is a new one. */
  act(act) {
    const { turn } = this.shown;
    return this.#inTurn(() => this.#said("api/act", { turn, act, platform: platform() }));
  }

  /** Ends it, and has all deleted. Afterwards there is a new scene. */
  withdraw() {
    return this.#inTurn(() => this.#said("api/withdraw", {}));
  }

  #inTurn(todo) {
    const mine = this.#line.then(todo);
    this.#line = mine.catch(() => {});
    return mine;
  }

  #opened() {
    return this.#said("api/open", { platform: platform() });
  }

  /**
   * Says something to the server until it answers. The same is said again after a lost reply, so the server can tell a
   * resend from a second act. Where it refuses, what helps is to ask where we are; where that helps nothing, this never
   * comes back.
   */
  async #said(path, body) {
    const answer = await answerTo(path, JSON.stringify(body), this.words.page);
    if (answer.words) this.#speak(answer.words);
    if (!answer.error) {
      this.shown = answer;
      return;
    }
    const { page } = this.words;
    if (answer.error === "incomplete") await ask(page.incomplete, "");
    else if (answer.error !== "stale") await ask(page.refused, page.reload);
    await this.#opened();
  }

  /** Says to browsers and screen readers in which language the page is. */
  #speak(words) {
    this.words = words;
    document.documentElement.lang = words.language;
    document.documentElement.dir = words.direction;
    document.title = words.title;
  }
}

async function answerTo(path, text, words) {
  for (let wait = FIRST_WAIT; ; wait = Math.min(2 * wait, LONGEST_WAIT)) {
    const answer = await once(path, text);
    showConnection(answer ? "" : words.offline);
    if (answer) return answer;
    await new Promise((resolve) => setTimeout(resolve, wait));
  }
}

/** The answer, or null if there was none, or one that asks for patience. */
async function once(path, body) {
  const headers = { "Content-Type": "application/json" };
  const how = { method: "POST", headers, body, credentials: "same-origin", cache: "no-store", redirect: "error" };
  try {
    const reply = await fetch(path, { ...how, signal: AbortSignal.timeout(PATIENCE) });
    return reply.status === 429 || reply.status >= 500 ? null : await reply.json();
  } catch {
    return null;
  }
}
