const TWICE = 500; // ms within which a second click of a double click is not meant
const SAME_KEY = 200; // ms within which the same key again is not meant

let lastKey = { key: "", at: -Infinity };

/**
 * Whether a click or a key is one that somebody meant: not the second of a double click on what stood there before,
 * not a key that is held down.
 *
 * @param {MouseEvent | KeyboardEvent} event
 * @param {number} shown ms since the scene was painted
 */
export function meant(event, shown) {
  if (event instanceof MouseEvent) return event.detail < 2 || shown > TWICE;
  return !event.repeat;
}

/** Keys that are held down, or hit twice at once, choose nothing: neither what is shown nor what comes after it. */
export function guardKeys() {
  const guard = (event) => {
    if (!chooses(event)) return;
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
  return target instanceof HTMLTextAreaElement || (target instanceof HTMLInputElement && target.type === "text");
}

function chooses(event) {
  const typed = isWritten(event.target) && event.key !== "Enter";
  return !typed && (event.key === "Enter" || event.key === " " || event.key.length === 1);
}

/**
 * Keys that stand for things on the page, as long as the page shows them.
 *
 * @param {(key: string, event: KeyboardEvent) => void} chosen Gets the key, letters as capitals.
 * @returns {() => void} Ends it.
 */
export function onKeys(chosen) {
  const listen = (event) => {
    const typed = isWritten(event.target);
    const open = document.querySelector("dialog[open]");
    if (typed || open || event.repeat || event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.key.length === 1) chosen(event.key.toUpperCase(), event);
  };
  addEventListener("keydown", listen);
  return () => removeEventListener("keydown", listen);
}
