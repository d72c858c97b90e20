/**
 * The participants' page. The server says what is shown and decides what happens; the page shows one scene after the
 * other with jsPsych, and tells the server what was done.
 */
import { initJsPsych } from "jspsych";

import { guardKeys } from "./choosing.js";
import { offerToWithdraw } from "./dialogs.js";
import { element, filled } from "./element.js";
import { ScenePlugin } from "./scene.js";
import { Session } from "./session.js";

const place = document.getElementById("scene");
const foot = document.getElementById("foot");
const session = new Session();
const jsPsych = initJsPsych({ display_element: place });

/** What is the same in every scene: how far one is, the way out, and what those see who drive the page. */
function frame() {
  const { scene, turn, progress } = session.shown;
  const words = session.words.page;
  place.dataset.scene = scene.kind;
  place.dataset.turn = String(turn);
  place.removeAttribute("tabindex"); // jsPsych sets it; nothing here needs it
  if (scene.kind !== "box") document.getElementById("spoken").textContent = "";
  document.getElementById("progress").replaceChildren(...(progress ? wayOf(progress, words) : []));
  if (!session.shown.participant) foot.replaceChildren();
  else if (!foot.hasChildNodes()) offerToWithdraw(foot, words, withdraw);
}

/** How far a participant is in the whole study: a bar, and the boxes that are done. */
function wayOf({ share, done, of }, words) {
  const text = filled(words.progress, { done, of });
  return [
    element("progress", { value: share, "aria-label": text }),
    element("span", { "aria-hidden": "true" }, text),
  ];
}

/** Ends whatever is shown: the loop goes on with the scene that the server shows then. */
async function withdraw() {
  await session.withdraw();
  jsPsych.finishTrial({ withdrawn: true });
}

addEventListener("pageshow", (event) => {
  if (event.persisted) location.reload(); // from the browser's memory: the server knows where we are
});
guardKeys();
await session.open();
const act = (done) => session.act(done);
const shown = { type: ScenePlugin, act, scene: () => session.shown.scene, words: () => session.words, on_start: frame };
await jsPsych.run([{ timeline: [shown], loop_function: () => true }]);
