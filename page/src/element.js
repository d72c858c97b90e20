/**
 * An element. Text is only ever text: nothing that came from a file or a server is read as HTML.
 *
 * @param {string} tag
 * @param {Record<string, unknown>} [attributes] `on…` are listeners; false and null leave an attribute out.
 * @param {...(Node | string | null)} children
 * @returns {HTMLElement}
 */
export function element(tag, attributes = {}, ...children) {
  return filled(document.createElement(tag), attributes, children);
}

/**
 * The same for drawings.
 *
 * @param {string} tag
 * @param {Record<string, unknown>} [attributes]
 * @param {...(Node | string | null)} children
 * @returns {SVGElement}
 */
export function drawn(tag, attributes = {}, ...children) {
  return filled(document.createElementNS("http://www.w3.org/2000/svg", tag), attributes, children);
}

function filled(made, attributes, children) {
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith("on")) made.addEventListener(name.slice(2), value);
    else if (value !== null && value !== undefined && value !== false)
      made.setAttribute(name, value === true ? "" : String(value));
  }
  made.append(...children.filter((child) => child !== null && child !== undefined));
  return made;
}

/**
 * @param {readonly string[]} texts
 * @returns {HTMLElement[]}
 */
export function paragraphs(texts) {
  return texts.map((text) => element("p", {}, text));
}

/**
 * What went wrong before, set apart from what stands under it.
 *
 * @param {{notice?: readonly string[]}} scene
 * @returns {HTMLElement[]}
 */
export function noticeOf({ notice }) {
  return notice?.length ? [element("div", { class: "notice", role: "note" }, ...paragraphs(notice))] : [];
}

/**
 * The heading of a scene. It takes the focus, so that a screen reader begins there.
 *
 * @param {string} text
 */
export function heading(text) {
  return element("h1", { tabindex: -1 }, text);
}

/**
 * A button that does something in a scene; without `onclick` it sends its form.
 *
 * @param {string} act By which programs find it.
 * @param {string} text
 * @param {((event: Event) => void) | null} onclick
 * @param {string} [looks]
 */
export function actButton(act, text, onclick, looks) {
  const does = onclick ? { type: "button", onclick } : { type: "submit" };
  return element("button", { ...does, class: looks, "data-act": act }, text);
}
