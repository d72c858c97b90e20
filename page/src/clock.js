/**
 * How long ago the present scene was painted, by the page's monotonic clock (`performance.now`), in ms.
 *
 * The clock starts with the first frame that shows the scene. A page in the background paints nothing; there it starts
 * when the scene was made.
 */
export class SceneClock {
  #start = performance.now();
  #read = false;

  constructor() {
    requestAnimationFrame(() => {
      if (!this.#read) this.#start = performance.now();
    });
  }

  /** @returns {number} ms, with a tenth of a ms */
  now() {
    this.#read = true;
    return Math.max(0, Math.round((performance.now() - this.#start) * 10) / 10);
  }
}
