/** Writes the licence texts of every package that the pages contain. */

import { mkdir, readdir, readFile, writeFile } from "node:fs/promises";
import { fileURLToPath, pathToFileURL } from "node:url";

const root = new URL("../", import.meta.url);
const file = new URL("../../src/symbody/visual/pages/LICENSES.txt", import.meta.url);

async function read(address) {
  return readFile(address, "utf8");
}

/** Return the names of the packages that a build contains: the dependencies, and theirs. */
async function bundledPackages() {
  const { dependencies } = JSON.parse(await read(new URL("package.json", root)));
  const names = new Set();
  const pending = Object.keys(dependencies);
  while (pending.length > 0) {
    const name = pending.pop();
    if (names.has(name)) continue;
    names.add(name);
    const manifest = JSON.parse(await read(new URL(`node_modules/${name}/package.json`, root)));
    pending.push(...Object.keys(manifest.dependencies ?? {}));
  }
  return [...names].sort();
}

async function licenseOf(name) {
  const folder = new URL(`node_modules/${name}/`, root);
  const { version, license } = JSON.parse(await read(new URL("package.json", folder)));
  const text = (await readdir(folder)).find((each) => /^licen[cs]e/i.test(each));
  if (text === undefined) throw new Error(`${name} carries no licence text`);
  return `${name} ${version} (${license})\n\n${(await read(new URL(text, folder))).trim()}\n`;
}

export async function writeLicenses() {
  const names = await bundledPackages();
  const texts = await Promise.all(names.map(licenseOf));
  const head = "The pages of symbody contain these packages.\n";
  await mkdir(new URL(".", file), { recursive: true });
  await writeFile(file, [head, ...texts].join(`\n${"-".repeat(78)}\n\n`));
  console.log(`LICENSES.txt: ${names.join(", ")}`);
}

if (import.meta.url === pathToFileURL(process.argv[1]).href) {
  await writeLicenses();
  console.log(fileURLToPath(file));
}
