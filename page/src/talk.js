/** What the server would not take. */
export class Refusal extends Error {
  /**
   * @param {number} status
   * @param {string} code One of the server's codes, for example `stale`.
   * @param {string} message In words, for those who look into it; participants read texts of their own.
   * @param {object} [words] Texts, where the page has none yet.
   */
  constructor(status, code, message, words) {
    super(message);
    this.status = status;
    this.code = code;
    this.words = words;
  }
}

const PATIENCE = 15_000; // ms for one request
const SLOW = 1_500; // ms after which it is said that it takes a moment
const FIRST_WAIT = 500; // ms; doubled with each failure
const LONGEST_WAIT = 8_000; // ms

/**
 * Says something to the server until it answers. The same is said again after a lost reply, so the server can tell a
 * resend from a second act.
 *
 * @param {string} path
 * @param {object} body
 * @param {(state: "well" | "slow" | "down") => void} tell How the connection is.
 * @returns {Promise<object>}
 * @throws {Refusal} If the server answers that it will not.
 */
export async function said(path, body, tell) {
  const text = JSON.stringify(body);
  for (let wait = FIRST_WAIT; ; wait = Math.min(2 * wait, LONGEST_WAIT)) {
    const slow = wait === FIRST_WAIT ? setTimeout(() => tell("slow"), SLOW) : 0;
    const answer = await once(path, text);
    clearTimeout(slow);
    if (answer) {
      tell("well");
      if (answer instanceof Refusal) throw answer;
      return answer;
    }
    tell("down");
    await pause(wait);
  }
}

/** The answer, or null if there was none, or one that asks for patience. */
async function once(path, text) {
  try {
    const reply = await fetch(path, {
      method: "POST",
      headers: { "Content-Type": "application/json" },
      body: text,
      credentials: "same-origin",
      cache: "no-store",
      redirect: "error",
      signal: AbortSignal.timeout(PATIENCE),
    });
    if (reply.status === 429 || reply.status >= 500) return null;
    const answer = await reply.json();
    return reply.ok ? answer : new Refusal(reply.status, String(answer.error), String(answer.message), answer.words);
  } catch {
    return null;
  }
}

/** Waits, but no longer than until the network is back. */
function pause(ms) {
  return new Promise((resolve) => {
    const done = () => {
      removeEventListener("online", done);
      clearTimeout(timer);
      resolve();
    };
    const timer = setTimeout(done, ms);
    addEventListener("online", done);
  });
}
