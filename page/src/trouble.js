import { element } from "./element.js";
import { FIRST_WORDS } from "./words.js";

/** What is said when something is wrong: no network, another tab, a request that was not taken. */
export class Trouble {
  words = FIRST_WORDS;
  #place;

  /** @param {HTMLElement} place A region that screen readers watch. */
  constructor(place) {
    this.#place = place;
  }

  /**
   * @param {"well" | "slow" | "down"} state Whether the server answers, takes its time, or cannot be reached.
   */
  connection(state) {
    const text = { well: "", slow: this.words.page.waiting, down: this.words.page.offline }[state];
    if (text === this.#place.textContent) return;
    this.#place.replaceChildren(...(text ? [element("p", { class: "bar" }, text)] : []));
  }

  /** The study is open in a newer tab.
   * @returns {Promise<void>} When it is to go on here. */
  elsewhere() {
    return this.#asked(this.words.page.elsewhere, this.words.page.here);
  }

  /** The server would not take something.
   * @returns {Promise<void>} When it is to be tried again. */
  refused() {
    return this.#asked(this.words.page.refused, this.words.page.reload);
  }

  /** The code with which one joins was another.
   * @returns {Promise<void>} When it is to be tried again. */
  wrongCode() {
    return this.#asked(this.words.page.wrong_code, this.words.page.reload);
  }

  /** The link is not the one that the recruitment platform made: trying again helps nothing.
   * @returns {Promise<void>} Never. */
  incomplete() {
    return this.#asked(this.words.page.incomplete, "");
  }

  #asked(text, button) {
    const before = document.activeElement;
    return new Promise((resolve) => {
      const stay = () => dialog.isConnected && dialog.showModal(); // Escape is no answer
      const dialog = element("dialog", { class: "box-of-words", "aria-labelledby": "trouble-text", onclose: stay });
      const done = () => {
        dialog.remove();
        if (before instanceof HTMLElement) before.focus();
        resolve();
      };
      const go = { type: "button", class: "first", "data-act": "here", onclick: done };
      dialog.append(
        element("p", { id: "trouble-text" }, text),
        button ? element("div", { class: "acts" }, element("button", go, button)) : "",
      );
      document.body.append(dialog);
      dialog.showModal();
    });
  }
}
