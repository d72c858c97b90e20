import { element } from "../element.js";

/**
 * What the last action did, as the participant sees it: asked before a joint can be chosen, and answered once.
 *
 * @param {Record<string, string>} words
 * @param {(claimed: "moved" | "blocked", event: Event) => void} said
 * @returns {HTMLElement}
 */
export function claimOf(words, said) {
  const button = (claimed, text, key) =>
    element(
      "button",
      {
        type: "button",
        "data-claim": claimed,
        "aria-keyshortcuts": key,
        "aria-pressed": "false",
        onclick: (event) => said(claimed, event),
      },
      text,
    );
  return element(
    "div",
    { class: "claim", role: "group", "aria-labelledby": "claim-question" },
    element("h2", { id: "claim-question", tabindex: -1 }, words.question),
    element(
      "div",
      { class: "acts" },
      button("moved", words.said_moved, "1"),
      button("blocked", words.said_blocked, "2"),
    ),
  );
}

/**
 * @param {HTMLElement} claim
 * @param {"moved" | "blocked"} claimed
 */
export function showClaimed(claim, claimed) {
  for (const button of claim.querySelectorAll("button")) {
    button.setAttribute("aria-pressed", String(button.dataset.claim === claimed));
    button.setAttribute("aria-disabled", "true");
  }
}
