/**
 * Builds the participants' page into src/lockprobe/people/web/static: `npm ci && npm run build`.
 *
 * What is built is committed, so nobody needs Node to install or run Lockprobe. `page.json` says of which sources it
 * was made; a test compares.
 */
import { createHash } from "node:crypto";
import { mkdir, readFile, readdir, writeFile } from "node:fs/promises";
import { dirname, join, relative, sep } from "node:path";
import { fileURLToPath } from "node:url";

import { build } from "esbuild";

const here = dirname(fileURLToPath(import.meta.url));
const into = join(here, "..", "src", "lockprobe", "people", "web", "static");
const TARGET = ["chrome109", "firefox115", "safari16"];

/** Everything that decides what is built, in a fixed order. */
async function sources() {
  const folders = [join(here, "src"), join(here, "licenses")];
  const found = (await Promise.all(folders.map((at) => readdir(at, { recursive: true, withFileTypes: true })))).flat();
  const files = found.filter((entry) => entry.isFile()).map((entry) => join(entry.parentPath, entry.name));
  const names = files.map((file) => relative(here, file).split(sep).join("/"));
  return [...names, "build.mjs", "package.json", "package-lock.json"].sort();
}

/** SHA-256 over names and contents, each ended by a zero byte. */
async function fingerprint() {
  const hash = createHash("sha256");
  for (const name of await sources()) {
    hash
      .update(name)
      .update("\0")
      .update(await readFile(join(here, name)))
      .update("\0");
  }
  return hash.digest("hex").slice(0, 12);
}

/** The licences of what went into the bundle, by the packages' own files. */
async function licences(inputs) {
  const names = new Set();
  for (const input of Object.keys(inputs)) {
    const found = /node_modules\/((?:@[^/]+\/)?[^/]+)\//.exec(input);
    if (found) names.add(found[1]);
  }
  const parts = ["page.js contains these packages of others.\n"];
  for (const name of [...names].sort()) {
    const folder = join(here, "node_modules", name);
    const about = JSON.parse(await readFile(join(folder, "package.json"), "utf8"));
    const files = (await readdir(folder)).filter((file) => /^licen[cs]e/i.test(file)).sort();
    // jsPsych and seedrandom ship their licences only in their repositories
    const file = files.length ? join(folder, files[0]) : join(here, "licenses", `${name}.txt`);
    const text = await readFile(file, "utf8");
    parts.push(`${"-".repeat(80)}\n${name} ${about.version} (${about.license})\n\n${text.trim()}\n`);
  }
  return parts.join("\n");
}

await mkdir(into, { recursive: true });
const made = await build({
  absWorkingDir: here,
  entryPoints: { page: "src/main.js" },
  outdir: into,
  bundle: true,
  minify: true,
  format: "esm",
  target: TARGET,
  legalComments: "none",
  metafile: true,
});
await build({
  absWorkingDir: here,
  entryPoints: ["src/page.css"],
  outdir: into,
  bundle: true,
  minify: true,
  target: TARGET,
});
for (const name of ["index.html", "icon.svg"]) {
  await writeFile(join(into, name), await readFile(join(here, "src", name)));
}
await writeFile(join(into, "LICENSES.txt"), await licences(made.metafile.inputs));

const files = {};
for (const name of ["LICENSES.txt", "icon.svg", "index.html", "page.css", "page.js"]) {
  files[name] = createHash("sha256")
    .update(await readFile(join(into, name)))
    .digest("hex");
}
await writeFile(join(into, "page.json"), `${JSON.stringify({ version: await fingerprint(), files }, null, 2)}\n`);
