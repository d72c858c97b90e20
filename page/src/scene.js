import { ParameterType } from "jspsych";

import { meant, onKeys, sceneClock } from "./choosing.js";
import { boxOf } from "./scenes/box.js";
import { questionsOf } from "./scenes/questions.js";
import { textOf } from "./scenes/read.js";

/**
 * What shows each kind of scene, if it is no text: a function of the scene, the texts and `answer`, which a click, a key
 * or a form calls. It gives the `part` of the page and, where it needs them, `begin` (called with the clock when it is
 * painted) and `keyed` (called with each key). Text scenes that end the study never answer.
 */
const SHOWN = { box: boxOf, check: questionsOf, ask: questionsOf, comprehension: questionsOf };

/** One scene as a trial of jsPsych: it is painted, its clock starts, and the first answer that is meant is told. */
export class ScenePlugin {
  static info = {
    name: "lockprobe-scene",
    version: "2.0.0",
    parameters: {
      /** What the server shows. */
      scene: { type: ParameterType.OBJECT },
      /** Texts. */
      words: { type: ParameterType.OBJECT },
      /** Tells the server what was done; afterwards there is a new scene. */
      act: { type: ParameterType.FUNCTION },
    },
    data: {
      /** What was done, with its times since the scene was painted, ms. */
      done: { type: ParameterType.OBJECT },
    },
  };

  async trial(display, { scene, words, act }, onLoad) {
    let clock, resolve;
    const chosen = new Promise((done) => (resolve = done));
    let open = true;
    // `make` gives what was done, from the ms since the scene was painted; nothing if something is missing
    const answer = (event, make) => {
      const rt = clock();
      const done = open && meant(event, rt) ? make(rt) : null;
      if (!done) return;
      open = false;
      for (const part of display.querySelectorAll("button, form, .acts")) part.setAttribute("aria-disabled", "true");
      resolve(done);
    };
    const { part, begin, keyed } = (SHOWN[scene.kind] ?? textOf)(scene, words, answer);
    await Promise.all([...part.querySelectorAll("img")].map((image) => image.decode().catch(() => {})));
    display.append(part);
    clock = sceneClock();
    const endKeys = keyed ? onKeys(keyed) : () => {};
    if (begin) begin(clock);
    else part.querySelector("h1").focus();
    onLoad();
    const done = await chosen;
    endKeys();
    await act(done);
    return { done };
  }
}
