"use strict";
/* The experimenter's page. The token comes behind # in the address, or by hand; this tab keeps it, and nothing else
   does. What the server sends is shown as text. */

const KEY = "lockprobe-admin-token";
const EVERY = 10_000; // milliseconds between two looks

const at = (id) => document.getElementById(id);
const storage = window.sessionStorage;
let timer = 0;

function tokenOfAddress() {
  const found = new URLSearchParams(location.hash.slice(1)).get("token");
  if (found) {
    storage.setItem(KEY, found);
    history.replaceState(null, "", location.pathname);
  }
}

function say(text, wrong = false) {
  const status = at("status");
  if (status.textContent !== text) status.textContent = text;
  status.classList.toggle("wrong", wrong);
}

function made(name, text = "", attributes = {}) {
  const element = document.createElement(name);
  element.textContent = text;
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  return element;
}

async function ask(path, body) {
  const headers = { Authorization: `Bearer ${storage.getItem(KEY)}` };
  if (body) headers["Content-Type"] = "application/json";
  const answer = await fetch(path, {
    method: body ? "POST" : "GET",
    headers,
    body: body && JSON.stringify(body),
    credentials: "omit",
    cache: "no-store",
  });
  if (answer.status === 401) {
    leave("That is not the token of this study.");
    return null;
  }
  const said = await answer.json();
  if (!answer.ok) throw new Error(said.message);
  return said;
}

async function look(path = "api/admin/progress", body = null) {
  clearTimeout(timer);
  if (!storage.getItem(KEY)) return false;
  let fine = false;
  try {
    const progress = await ask(path, body);
    if (progress) {
      show(progress);
      fine = true;
    }
  } catch (error) {
    say(error instanceof TypeError ? "The server does not answer; trying again." : error.message, true);
  }
  clearTimeout(timer); // another look may have begun meanwhile
  if (storage.getItem(KEY)) timer = setTimeout(look, EVERY);
  return fine;
}

function leave(text = "") {
  clearTimeout(timer);
  storage.removeItem(KEY);
  at("study").hidden = true;
  at("door").hidden = false;
  at("when").textContent = "";
  at("token").value = "";
  at("token").focus();
  say(text, Boolean(text));
}

function show(progress) {
  at("door").hidden = true;
  at("study").hidden = false;
  at("reminders").replaceChildren(...progress.reminders.map((text) => made("li", text)));
  if (at("link").value !== progress.study_url) at("link").value = progress.study_url;
  showTotals(progress);
  at("conditions").tBodies[0].replaceChildren(...progress.conditions.map(conditionRow));
  showParticipants(progress.participants);
  showFiles(progress.downloads);
  at("everything").disabled = progress.joined === 0;
  at("when").textContent = `As of ${new Date().toLocaleTimeString()}`; // not spoken every time
  say("");
}

function showTotals(progress) {
  const checks = progress.checks_right + progress.checks_wrong;
  const totals = [
    ["Joined (without withdrawn)", progress.joined],
    ["Finished", progress.finished],
    ["Place given away", progress.late],
    ["Screened out", progress.screened],
    ["Withdrawn", progress.withdrawn],
    ["Checks right", checks ? `${progress.checks_right}/${checks}` : "–"],
  ];
  at("totals").replaceChildren(
    ...totals.map(([name, value]) => {
      const group = document.createElement("div");
      group.append(made("dt", name), made("dd", String(value)));
      return group;
    }),
  );
}

function conditionRow(condition) {
  const row = document.createElement("tr");
  row.append(made("th", condition.condition, { scope: "row" }));
  for (const key of ["slots", "finished", "under_way", "free"]) {
    row.append(made("td", String(condition[key]), { class: "number" }));
  }
  const cell = made("td", "", { class: "wide", "aria-hidden": "true" });
  cell.append(made("progress", "", { max: condition.slots, value: condition.finished }));
  row.append(cell);
  return row;
}

/** Rows stay where they are while somebody reads them, and the focus in them. */
function showParticipants(participants) {
  const body = at("participants").tBodies[0];
  const rows = new Map([...body.rows].map((row) => [row.dataset.participant, row]));
  for (const participant of participants) {
    const row = rows.get(participant.identity) ?? body.appendChild(participantRow(participant.identity));
    rows.delete(participant.identity);
    fill(row, participant);
  }
  for (const row of rows.values()) row.remove();
  at("nobody").hidden = participants.length > 0;
  at("participants").hidden = participants.length === 0;
}

function participantRow(identity) {
  const row = made("tr", "", { role: "row" }); // roles: on a phone rows are stacked, and browsers forget tables then
  row.dataset.participant = identity;
  const name = made("th", "", { scope: "row", role: "rowheader" });
  name.append(made("code", identity));
  const cell = (head, more = {}) => made("td", "", { role: "cell", "data-head": head, ...more });
  const last = cell("");
  const button = made("button", "Withdraw …", {
    type: "button",
    class: "quiet",
    "aria-label": `Withdraw participant ${identity}`,
  });
  button.addEventListener("click", () => withdraw(identity));
  last.append(button);
  row.append(name, cell("Boxes", { class: "number" }), cell("Where"), cell("Checks"), cell("Last act"), last);
  return row;
}

function fill(row, participant) {
  const checks = participant.checks_right + participant.checks_wrong;
  const broken = participant.broken ? `, ${participant.broken} broken` : "";
  const texts = [
    `${participant.boxes_done} of ${participant.boxes}${broken}`,
    participant.stage,
    checks ? `${participant.checks_right} of ${checks} right` : "none yet",
    new Date(participant.last_act * 1000).toLocaleString(),
  ];
  texts.forEach((text, place) => {
    row.cells[place + 1].textContent = text;
  });
}

/** Who has an ID of the recruitment platform; the page shows none, it only finds them. */
async function find(event) {
  event.preventDefault();
  const id = at("id").value.trim();
  if (!id) return;
  try {
    const answer = await ask("api/admin/find", { id });
    if (!answer) return;
    const rows = [...at("participants").tBodies[0].rows];
    for (const row of rows) row.classList.toggle("found", answer.participants.includes(row.dataset.participant));
    const names = answer.participants.join(", ");
    at("found").textContent = names ? `Participant ${names}` : "Nobody here joined with that ID.";
    rows.find((row) => row.classList.contains("found"))?.scrollIntoView({ block: "center" });
  } catch (error) {
    at("found").textContent = error instanceof TypeError ? "The server does not answer." : error.message;
  }
}

/** Each table with what a row of it is, and the file that describes its columns. */
function showFiles(downloads) {
  if (at("files").hasChildNodes()) return; // they stay what they are
  at("data").hidden = downloads.length === 0;
  const tables = downloads.filter(({ name }) => name.endsWith(".csv"));
  at("files").replaceChildren(
    ...tables.map(({ name, about }) => {
      const line = made("li");
      const columns = fileButton(`${name}-metadata.json`, "columns", `Download the columns of ${name}, described`);
      line.append(fileButton(name, name), columns, made("span", about));
      return line;
    }),
  );
}

function fileButton(name, text, label = `Download ${name}`) {
  return made("button", text, { type: "button", class: "quiet", "data-file": name, "aria-label": label });
}

/** The token goes in a header, so a plain link could not do it. What comes of it is said beside the buttons. */
async function download(button) {
  const name = button.dataset.file;
  if (button.getAttribute("aria-disabled")) return;
  button.setAttribute("aria-disabled", "true");
  at("prepared").textContent = `Preparing ${name} …`;
  try {
    const answer = await fetch(`api/admin/data/${name}`, {
      headers: { Authorization: `Bearer ${storage.getItem(KEY)}` },
      credentials: "omit",
      cache: "no-store",
    });
    if (!answer.ok) throw new Error(`${name} cannot be had: ${(await answer.json()).message}.`);
    const link = made("a", "", { href: URL.createObjectURL(await answer.blob()), download: name });
    link.click();
    URL.revokeObjectURL(link.href);
    at("prepared").textContent = `${name} is downloaded.`;
  } catch (error) {
    at("prepared").textContent = error instanceof TypeError ? "The server does not answer." : error.message;
  } finally {
    button.removeAttribute("aria-disabled");
  }
}

async function copy() {
  at("link").select();
  try {
    await navigator.clipboard.writeText(at("link").value);
    say("Copied.");
  } catch {
    say("It is selected: copy it with the keyboard.");
  }
}

function withdraw(identity) {
  const dialog = at("sure");
  at("whom").textContent = identity;
  dialog.returnValue = "no";
  dialog.onclose = async () => {
    if (dialog.returnValue !== "yes") return;
    if (await look("api/admin/withdraw", { participant: identity })) {
      say(`Everything that was kept of participant ${identity} has been deleted.`);
      at("participants-title").focus();
    }
  };
  dialog.showModal();
}

at("door").addEventListener("submit", (event) => {
  event.preventDefault();
  storage.setItem(KEY, at("token").value.trim());
  look();
});
at("find").addEventListener("submit", find);
at("data").addEventListener("click", (event) => {
  const button = event.target.closest("button[data-file]");
  if (button) download(button);
});
at("copy").addEventListener("click", copy);
at("leave").addEventListener("click", () => leave());
document.addEventListener("visibilitychange", () => {
  if (document.hidden) clearTimeout(timer);
  else look();
});
window.addEventListener("hashchange", () => {
  tokenOfAddress();
  look();
});

tokenOfAddress();
if (storage.getItem(KEY)) look();
else at("token").focus();
