/** What can be drawn over time, as a tree: headings, and below some the elements that have several curves. */

export interface Offered {
  readonly name: string;
  readonly unit: string;
  /** The heading and the element, as the server says; formulas that a user adds have none. */
  readonly title?: string;
  readonly group?: string;
}

export interface Branch {
  readonly title: string;
  readonly curves: readonly Offered[];
  readonly branches: readonly Branch[];
}

const OTHERS = "Others";

/** Return the tree of curves, headings in the order in which they are first met. */
export function curveTree(curves: readonly Offered[]): Branch[] {
  return byTitle(curves, ({ title }) => title ?? OTHERS).map(({ title, curves: own }) => {
    const alone = own.filter(({ group }) => (group ?? "") === "");
    return { title, curves: alone, branches: byTitle(own.filter((each) => !alone.includes(each)), ({ group }) => group ?? "") };
  });
}

function byTitle(curves: readonly Offered[], titleOf: (each: Offered) => string): Branch[] {
  const titles = [...new Set(curves.map(titleOf))];
  return titles.map((title) => ({ title, curves: curves.filter((each) => titleOf(each) === title), branches: [] }));
}

/** Return the name of a curve below its element: the entry alone. */
export function shortName({ name, group }: Offered): string {
  return (group ?? "") === "" ? name : name.slice(name.lastIndexOf(" ") + 1);
}

/** Return what is ticked at first: positions and speeds, up to six. */
export function firstTicks(tree: readonly Branch[]): string[] {
  return tree.filter((each) => each.title === "Positions" || each.title === "Speeds").flatMap((each) => each.curves.slice(0, 3)).map((each) => each.name);
}
