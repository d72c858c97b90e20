/** What stands over the scene: no network, another tab, a request that was not taken, and the way out. */
import { actButton, acts, element } from "./element.js";

/** The state of the connection, in a region that screen readers watch; empty while the server answers. */
export function showConnection(text) {
  const place = document.getElementById("trouble");
  if (text !== place.textContent) place.replaceChildren(...(text ? [element("p", { class: "bar" }, text)] : []));
}

/** Says what is wrong until it is to go on; without a button, which would help nothing, for ever. */
export function ask(text, button) {
  const before = document.activeElement;
  return new Promise((resolve) => {
    const stay = () => dialog.isConnected && dialog.showModal(); // Escape is no answer
    const dialog = element("dialog", { "aria-labelledby": "trouble-text", onclose: stay });
    const done = () => {
      dialog.remove();
      if (before instanceof HTMLElement) before.focus();
      resolve();
    };
    dialog.append(element("p", { id: "trouble-text" }, text));
    if (button) dialog.append(acts(actButton("here", button, done, "first")));
    document.body.append(dialog);
    dialog.showModal();
  });
}

/** The way out: a button at the foot of the page, and a dialog that asks whether it is meant. */
export function offerToWithdraw(foot, words, withdraw) {
  const sure = async () => {
    if (yes.getAttribute("aria-disabled")) return;
    yes.setAttribute("aria-disabled", "true");
    await withdraw();
    dialog.close();
  };
  const yes = actButton("withdraw-yes", words.withdraw_yes, sure, "danger");
  const dialog = element(
    "dialog",
    { "aria-labelledby": "withdraw-title" },
    element("h2", { id: "withdraw-title" }, words.withdraw),
    element("p", {}, words.withdraw_sure),
    acts(
      actButton("withdraw-no", words.withdraw_no, () => dialog.close()),
      yes,
    ),
  );
  foot.replaceChildren(
    actButton("withdraw", words.withdraw, () => dialog.showModal(), "quiet"),
    dialog,
  );
}
