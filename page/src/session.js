import { Refusal, said } from "./talk.js";
import { FIRST_WORDS, speak } from "./words.js";

const LONGEST = 64; // characters of a parameter that goes along
const MOST = 40; // parameters that go along, as many as the server reads

/** The parameters of the URL, as recruitment platforms set them; the server keeps those that it was told to keep. */
function platform() {
  const found = [...new URLSearchParams(location.search)].filter(
    ([name, value]) => name.length <= LONGEST && value.length <= LONGEST,
  );
  return Object.fromEntries(found.slice(0, MOST));
}

/**
 * What the server shows to this tab, and how it is answered. One thing is said at a time.
 *
 * @typedef {object} Scene What the server shows; `kind` says which plugin shows it.
 * @property {string} kind
 */
export class Session {
  /** @type {Scene} */
  scene = { kind: "none" };
  /** Number of the scene. */
  turn = 0;
  words = FIRST_WORDS;
  mayWithdraw = false;
  /** @type {{share: number, done: number, of: number} | null} How far this participant is. */
  progress = null;
  #lease = "";
  #trouble;
  #line = Promise.resolve();
  #begunAnew = false;

  /** @param {import("./trouble.js").Trouble} trouble */
  constructor(trouble) {
    this.#trouble = trouble;
  }

  /** The scene in which this participant is; other tabs cannot act any more. */
  open() {
    return this.#inTurn(() => this.#opened());
  }

  /**
   * Does something in the present scene. Afterwards there is a new one.
   *
   * @param {object} act
   */
  act(act) {
    const turn = this.turn;
    return this.#inTurn(() => this.#said("api/act", { lease: this.#lease, turn, act, platform: platform() }));
  }

  /** Ends it, and has all deleted. Afterwards there is a new scene. */
  withdraw() {
    return this.#inTurn(() => this.#said("api/withdraw", { lease: this.#lease }));
  }

  #inTurn(todo) {
    const mine = this.#line.then(todo);
    this.#line = mine.catch(() => {});
    return mine;
  }

  #opened() {
    return this.#said("api/open", { platform: platform() });
  }

  async #said(path, body) {
    try {
      this.#take(await said(path, body, (state) => this.#trouble.connection(state)));
    } catch (refusal) {
      await this.#refused(refusal, path);
    }
  }

  /** What helps: the server is asked where we are. Where that helps nothing, this never comes back. */
  async #refused(refusal, path) {
    if (!(refusal instanceof Refusal)) throw refusal;
    this.#speak(refusal.words);
    const ofOldCookie = refusal.code === "forged" && path === "api/open" && !this.#begunAnew;
    if (ofOldCookie) this.#begunAnew = true; // of another study; the server has had it forgotten
    else if (refusal.code === "incomplete") await this.#trouble.incomplete();
    else if (refusal.code === "wrong-code") await this.#trouble.wrongCode();
    else if (refusal.code === "elsewhere") await this.#trouble.elsewhere();
    else if (refusal.code !== "stale") await this.#trouble.refused();
    await this.#opened();
  }

  #speak(words) {
    if (words) speak((this.words = this.#trouble.words = words));
  }

  #take(answer) {
    this.#speak(answer.words);
    this.#lease = answer.lease;
    this.turn = answer.turn;
    this.scene = answer.scene;
    this.mayWithdraw = answer.withdraw;
    this.progress = answer.progress;
  }
}
