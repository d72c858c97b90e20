/** What counts as a choice that somebody meant, when it was made since the scene was painted, and with what. */

const TWICE = 500; // ms within which a second click of a double click is not meant
const SAME_KEY = 200; // ms within which the same key again is not meant

let lastKey = { key: "", at: -Infinity };
let pressed = "mouse"; // with what was pressed last: where clicks do not say it themselves

addEventListener("pointerdown", (event) => (pressed = event.pointerType || pressed), { capture: true });

/**
 * Whether a click or a key is one that somebody meant: not the second of a double click on what stood there before,
 * not a key that is held down.
 *
 * @param {Event} event
 * @param {number} shown ms since the scene was painted
 */
export function meant(event, shown) {
  if (event instanceof MouseEvent) return event.detail < 2 || shown > TWICE;
  return !event.repeat;
}

/** Keys that are held down, or hit twice at once, choose nothing: neither what is shown nor what comes after it. */
export function guardKeys() {
  const guard = (event) => {
    const typed = isWritten(event.target) && event.key !== "Enter";
    if (typed || !(event.key === "Enter" || event.key.length === 1)) return;
    const again = event.key === lastKey.key && event.timeStamp - lastKey.at < SAME_KEY;
    lastKey = { key: event.key, at: event.timeStamp };
    if (event.repeat || again) {
      event.preventDefault();
      event.stopImmediatePropagation();
    }
  };
  addEventListener("keydown", guard, { capture: true });
}

/** Whether keys write there. */
function isWritten(target) {
  return target instanceof HTMLTextAreaElement;
}

/** Keys that stand for things on the page, letters as capitals, until what is returned is called. */
export function onKeys(chosen) {
  const listen = (event) => {
    const open = document.querySelector("dialog[open]");
    if (isWritten(event.target) || open || event.repeat || event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.key.length === 1) chosen(event.key.toUpperCase(), event);
  };
  addEventListener("keydown", listen);
  return () => removeEventListener("keydown", listen);
}

/**
 * Tells how many ms ago the present scene was painted, with a tenth, by the page's monotonic clock. It starts with the
 * first frame that shows the scene; a page in the background paints nothing, and there it starts when it was made.
 */
export function sceneClock() {
  let start = performance.now();
  let read = false;
  requestAnimationFrame(() => {
    if (!read) start = performance.now();
  });
  return () => {
    read = true;
    return Math.max(0, Math.round((performance.now() - start) * 10) / 10);
  };
}

/** With what somebody chose, and how large the window is, in CSS pixels. Nothing else is said of a device. */
export function deviceOf(event) {
  const viewport = [Math.round(innerWidth), Math.round(innerHeight)];
  if (!(event instanceof MouseEvent) || event.detail === 0) return { pointer: "keyboard", viewport };
  const kind = event.pointerType || pressed;
  return { pointer: ["touch", "pen"].includes(kind) ? kind : "mouse", viewport };
}
