import { element } from "./element.js";

/**
 * The way out: a button at the foot of the page, and a dialog that asks whether it is meant.
 *
 * @param {HTMLElement} foot
 * @param {Record<string, string>} words
 * @param {() => Promise<void>} withdraw
 */
export function offerToWithdraw(foot, words, withdraw) {
  const sure = async (event) => {
    if (yes.getAttribute("aria-disabled")) return;
    yes.setAttribute("aria-disabled", "true");
    await withdraw();
    dialog.close();
  };
  const yes = element(
    "button",
    { type: "button", class: "danger", "data-act": "withdraw-yes", onclick: sure },
    words.withdraw_yes,
  );
  const no = element(
    "button",
    { type: "button", "data-act": "withdraw-no", onclick: () => dialog.close() },
    words.withdraw_no,
  );
  const dialog = element(
    "dialog",
    { class: "box-of-words", "aria-labelledby": "withdraw-title" },
    element("h2", { id: "withdraw-title" }, words.withdraw),
    element("p", {}, words.withdraw_sure),
    element("div", { class: "acts" }, no, yes),
  );
  const ask = element(
    "button",
    { type: "button", class: "quiet", "data-act": "withdraw", onclick: () => dialog.showModal() },
    words.withdraw,
  );
  foot.replaceChildren(ask, dialog);
}
