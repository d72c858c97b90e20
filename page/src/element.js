/**
 * An element. Text is only ever text: nothing that came from a file or a server is read as HTML.
 *
 * @param {string} tag
 * @param {Record<string, unknown>} [attributes] `on…` are listeners; false and null leave an attribute out.
 * @param {...(Node | string | null)} children
 */
export function element(tag, attributes = {}, ...children) {
  return made(document.createElement(tag), attributes, children);
}

/** The same for drawings. */
export function drawn(tag, attributes = {}, ...children) {
  return made(document.createElementNS("http://www.w3.org/2000/svg", tag), attributes, children);
}

function made(node, attributes, children) {
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith("on")) node.addEventListener(name.slice(2), value);
    else if (![null, undefined, false].includes(value)) node.setAttribute(name, value === true ? "" : String(value));
  }
  node.append(...children.filter((child) => child !== null && child !== undefined));
  return node;
}

/** A text with its `{names}` filled in; what is in braces and no fact stays as it is. */
export function filled(text, facts) {
  return text.replace(/\{(\w+)\}/g, (whole, name) => (Object.hasOwn(facts, name) ? String(facts[name]) : whole));
}

export function paragraphs(texts) {
  return texts.map((text) => element("p", {}, text));
}

/** What went wrong before, set apart from what stands under it. */
export function noticeOf({ notice }) {
  return notice?.length ? [element("div", { class: "notice", role: "note" }, ...paragraphs(notice))] : [];
}

/** The heading of a scene. It takes the focus, so that a screen reader begins there. */
export function heading(text) {
  return element("h1", { tabindex: -1 }, text);
}

/** A button; `act` is by what programs find it. Without `onclick` it sends its form. */
export function actButton(act, text, onclick, looks) {
  const does = onclick ? { type: "button", onclick } : { type: "submit" };
  return element("button", { ...does, class: looks, "data-act": act }, text);
}

/** Buttons side by side. */
export function acts(...buttons) {
  return element("div", { class: "acts" }, ...buttons);
}
