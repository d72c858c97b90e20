let pressed = "mouse"; // with what was pressed last: where clicks do not say it themselves

addEventListener("pointerdown", (event) => (pressed = event.pointerType || pressed), { capture: true });

/**
 * With what somebody chose, and how large the window is. Nothing else is said of a device.
 *
 * @param {MouseEvent | KeyboardEvent} event
 * @returns {{pointer: "mouse" | "touch" | "pen" | "keyboard", viewport: [number, number]}} in CSS pixels
 */
export function deviceOf(event) {
  const viewport = [Math.round(innerWidth), Math.round(innerHeight)];
  if (!(event instanceof MouseEvent) || event.detail === 0) return { pointer: "keyboard", viewport };
  const kind = event.pointerType || pressed;
  return { pointer: ["touch", "pen"].includes(kind) ? kind : "mouse", viewport };
}
