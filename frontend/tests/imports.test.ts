/** Imports run one way: no file reaches itself through them, and no folder imports one that it must not. */

import { readdirSync, readFileSync } from "node:fs";
import { dirname, relative, resolve } from "node:path";
import ts from "typescript";
import { expect, test } from "vitest";

const SOURCE = resolve(import.meta.dirname, "../src");

/** Folders of src, and which others each may import. */
const ALLOWED: Readonly<Record<string, readonly string[]>> = {
  viewer: [],
  player: ["viewer"],
  live: ["player", "viewer"],
  widget: ["player", "viewer"],
  builder: ["player", "viewer"],
};

function sourceFiles(): string[] {
  const names = readdirSync(SOURCE, { recursive: true, encoding: "utf8" });
  return names.filter((name) => /\.tsx?$/.test(name) && !name.endsWith(".d.ts")).map((name) => resolve(SOURCE, name));
}

/** Files and the files of src that each imports, types too. */
function importsOf(files: readonly string[]): Map<string, string[]> {
  const all = new Set(files);
  const target = (file: string, name: string): string[] => {
    const base = resolve(dirname(file), name);
    return [base, `${base}.ts`, `${base}.tsx`, `${base}/index.ts`].filter((each) => all.has(each));
  };
  const imported = (file: string): string[] => ts.preProcessFile(readFileSync(file, "utf8")).importedFiles
    .flatMap(({ fileName }) => (fileName.startsWith(".") ? target(file, fileName) : []));
  return new Map(files.map((file) => [file, imported(file)]));
}

/** The first circle in a graph, as the nodes on the way; empty if there is none. */
function firstCircle(graph: ReadonlyMap<string, readonly string[]>): string[] {
  const done = new Set<string>();
  const visit = (node: string, path: readonly string[]): string[] => {
    if (path.includes(node)) return [...path.slice(path.indexOf(node)), node];
    if (done.has(node)) return [];
    for (const next of graph.get(node) ?? []) {
      const circle = visit(next, [...path, node]);
      if (circle.length > 0) return circle;
    }
    done.add(node);
    return [];
  };
  for (const node of graph.keys()) {
    const circle = visit(node, []);
    if (circle.length > 0) return circle;
  }
  return [];
}

const GRAPH = importsOf(sourceFiles());

test("no file imports itself through others", () => {
  expect(GRAPH.size).toBeGreaterThan(50);
  expect(firstCircle(GRAPH).map((file) => relative(SOURCE, file))).toEqual([]);
});

test("a circle is seen", () => {
  const graph = new Map([["a", ["b"]], ["b", ["c"]], ["c", ["d", "b"]], ["d", []]]);
  expect(firstCircle(graph)).toEqual(["b", "c", "b"]);
});

test("a folder imports those below it alone", () => {
  const folder = (file: string): string => relative(SOURCE, file).split(/[/\\]/)[0]!;
  const wrong = [...GRAPH].flatMap(([file, targets]) => targets
    .filter((each) => folder(each) !== folder(file) && ALLOWED[folder(file)]?.includes(folder(each)) !== true)
    .map((each) => `${relative(SOURCE, file)} -> ${relative(SOURCE, each)}`));
  expect(wrong).toEqual([]);
});
