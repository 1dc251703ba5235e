/** The notices of the packages and fonts that a page contains, and the file of all of them. */

import { readdir, readFile, writeFile } from "node:fs/promises";
import { fileURLToPath } from "node:url";

const ROOT = new URL("../", import.meta.url);
const REPOSITORY = new URL("../../", import.meta.url);
const FILE = new URL("LICENSES.txt", ROOT); // in git, and in `license-files` of pyproject.toml
const LINE = "-".repeat(78);
const FONT = { file: "src/symbody/display/maths_font_license.txt", style: "src/symbody/display/maths.css" };

async function read(address) {
  return (await readFile(address, "utf8")).replaceAll("\r\n", "\n").trim();
}

/** Return the names of what stands in a page: packages by the files that a bundle was made of, and fonts.
 *
 * Packages may be published with others already inside (dagre with graphlib), so the dependencies of each are taken too;
 * those of types alone leave nothing in a page.
 */
export async function contained(moduleIds) {
  const names = new Set();
  for (const id of moduleIds) {
    const path = id.replaceAll("\\", "/");
    const library = /\/node_modules\/three\/examples\/jsm\/libs\/.*/.exec(path);
    if (library !== null) throw new Error(`${library[0]} has a licence of its own: add its notice`);
    const name = /.*\/node_modules\/((?:@[^/]+\/)?[^/]+)\//.exec(path)?.[1];
    if (name !== undefined) names.add(name);
    else if (path.includes(FONT.style)) names.add(FONT.file);
  }
  for (const name of [...names].filter((each) => each !== FONT.file)) {
    const { dependencies } = JSON.parse(await read(new URL(`node_modules/${name}/package.json`, ROOT)));
    for (const each of Object.keys(dependencies ?? {})) if (!each.startsWith("@types/")) names.add(each);
  }
  return [...names].sort();
}

async function noticeOf(name) {
  if (name === FONT.file) return read(new URL(FONT.file, REPOSITORY));
  const folder = new URL(`node_modules/${name}/`, ROOT);
  const { version, license } = JSON.parse(await read(new URL("package.json", folder)));
  const text = (await readdir(folder)).find((each) => /^licen[cs]e/i.test(each));
  if (text === undefined) throw new Error(`${name} carries no licence text`);
  return `${name} ${version} (${license})\n\n${await read(new URL(text, folder))}`;
}

/** Return the notices of a page as one text that may stand in a comment of HTML, CSS or JavaScript. */
export async function notices(names) {
  const own = `symbody (BSD-3-Clause)\n\n${await read(new URL("LICENSE", REPOSITORY))}`;
  const texts = [own, ...(await Promise.all(names.map(noticeOf)))];
  const text = ["Licences of what this file contains", ...texts].join(`\n\n${LINE}\n\n`);
  if (/--!?>|\*\//.test(text)) throw new Error("a licence text would end the comment that it stands in");
  return text;
}

/** Check the file of all notices of packages against what the pages contain, or write it. */
export async function keepLicenses(names, write) {
  const packages = names.filter((name) => name !== FONT.file);
  const head = "The pages of symbody contain these packages. `npm run licenses` writes this file.";
  const text = [head, ...(await Promise.all(packages.map(noticeOf)))].join(`\n\n${LINE}\n\n`) + "\n";
  if (write) await writeFile(FILE, text);
  else if (text.trim() !== (await read(FILE).catch(() => "")))
    throw new Error(`${fileURLToPath(FILE)} is not that of the packages in the pages: npm run licenses`);
  console.log(`licences: ${packages.join(", ")}`);
}
