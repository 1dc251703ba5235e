/** Builds the player page, the notebook widget and the builder's page, each with its licences, into the Python package. */

import { createHash } from "node:crypto";
import { mkdir, readFile, rm, writeFile } from "node:fs/promises";
import { fileURLToPath } from "node:url";
import { build } from "vite";
import { contained, keepLicenses, notices } from "./licenses.mjs";

const root = fileURLToPath(new URL("..", import.meta.url));
const pages = fileURLToPath(new URL("../../src/symbody/visual/pages/", import.meta.url));
const MOST_BYTES = 900_000;
const MOST_BUILDER_BYTES = 1_800_000;
const names = new Set(); // of packages and fonts in any page

/** Return the notices of what bundles contain. */
async function noticesOf(chunks) {
  const inside = await contained(chunks.flatMap((each) => each.moduleIds));
  for (const name of inside) names.add(name);
  return notices(inside);
}

/** Return the code and the style of one entry, each as one text, and the notices of what is in them. */
async function bundle(entry, format) {
  const results = await build({
    root,
    configFile: false,
    logLevel: "warn",
    define: { "process.env.NODE_ENV": '"production"' },
    build: {
      write: false,
      target: "es2022",
      cssMinify: true,
      assetsInlineLimit: 1e9,
      rolldownOptions: { output: { minify: true } }, // a library is left long otherwise
      lib: { entry, formats: [format], name: "symbody", fileName: "bundle", cssFileName: "bundle" },
    },
  });
  const outputs = [results].flat().flatMap((each) => each.output);
  const chunks = outputs.filter((each) => each.type === "chunk");
  if (chunks.length !== 1) throw new Error(`${entry} gives ${chunks.length} files, not one`);
  const style = outputs.filter((each) => each.type === "asset" && each.fileName.endsWith(".css"));
  return { script: chunks[0].code.trim(), style: style.map((each) => String(each.source)).join("\n"), licenses: await noticesOf(chunks) };
}

/** Write a page of its own: the template with the code and the style of an entry, and words of this page. */
async function writePage(name, entry, words) {
  const { script, style, licenses } = await bundle(entry, "iife");
  // nothing in the code may end its element
  const safe = script.replaceAll("</script", "<\\/script").replaceAll("<!--", "<\\!--");
  const hash = `sha256-${createHash("sha256").update(safe, "utf8").digest("base64")}`;
  const template = await readFile(`${root}/page.html`, "utf8");
  const filled = { ...words, LICENSES: licenses, STYLE: style, SCRIPT_HASH: hash, SCRIPT: safe };
  await write(name, template.replace(/%([A-Z_]+)%/g, (_, word) => filled[word]));
}

async function writeWidget() {
  const { script, licenses } = await bundle("src/widget/widget.ts", "es");
  await write("widget.js", `/*\n${licenses}\n*/\n${script}`);
}

/** Write the builder's page: a page of its own and its assets, served from the root of its server. */
async function writeBuilder() {
  const outDir = fileURLToPath(new URL("../../src/symbody/builder/pages/", import.meta.url));
  const results = await build({
    root: `${root}/src/builder`,
    base: "/",
    configFile: false,
    logLevel: "warn",
    define: { "process.env.NODE_ENV": '"production"' },
    build: { outDir, emptyOutDir: true, target: "es2022", assetsInlineLimit: 0, chunkSizeWarningLimit: 2000, modulePreload: { polyfill: false } },
  });
  const outputs = [results].flat().flatMap((each) => each.output);
  const bytes = outputs.reduce((sum, each) => sum + Buffer.byteLength(each.type === "chunk" ? each.code : each.source), 0);
  if (bytes > MOST_BUILDER_BYTES) throw new Error(`the builder's page has ${bytes} bytes, at most ${MOST_BUILDER_BYTES}`);
  const page = `${outDir}index.html`;
  const comment = `<!--\n${await noticesOf(outputs.filter((each) => each.type === "chunk"))}\n-->\n`;
  await writeFile(page, (await readFile(page, "utf8")).replace("</head>", () => `${comment}</head>`));
  console.log(`builder: ${(bytes / 1000).toFixed(0)} kB in ${outputs.length} files`);
}

async function write(name, text) {
  const bytes = Buffer.byteLength(text);
  if (bytes > MOST_BYTES) throw new Error(`${name} has ${bytes} bytes, at most ${MOST_BYTES}`);
  await writeFile(`${pages}${name}`, text);
  console.log(`${name}: ${(bytes / 1000).toFixed(0)} kB`);
}

await rm(pages, { recursive: true, force: true });
await mkdir(pages, { recursive: true });
await writePage("player.html", "src/player/main.ts", { PURPOSE: "This page shows a moving mechanism", PROGRAM_HASH: "", PROGRAM: "" });
// What the package replaces: the hash of a program, formulas, the program.
await writePage("live.html", "src/live/main.ts", {
  PURPOSE: "This page computes the motion of a mechanism",
  PROGRAM_HASH: " 'sha256-program'",
  PROGRAM: '<template id="symbody-formulas"></template>\n<script id="symbody-program">0</script>\n',
});
await writeWidget();
await writeBuilder();
await keepLicenses([...names].sort(), process.argv.includes("--licenses"));
