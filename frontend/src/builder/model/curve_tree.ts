/** What can be drawn over time, as a tree: kinds of quantities, of reactions also the joint. */


export interface Offered {
  readonly name: string;
  readonly unit: string;
}

export interface Branch {
  readonly title: string;
  readonly curves: readonly Offered[];
  readonly branches: readonly Branch[];
}

const ENERGIES = new Set(["kinetic_energy", "potential_energy", "energy"]);
const TITLES = ["Positions", "Speeds", "Accelerations", "Inputs", "Energies", "Forces and torques", "Reactions", "Multipliers and constraint error", "Others"] as const;
type Kind = (typeof TITLES)[number];

const ENDINGS: readonly (readonly [RegExp, Kind])[] = [
  [/^reaction /, "Reactions"], [/^effort /, "Forces and torques"], [/^lambda_|^constraint_violation$/, "Multipliers and constraint error"], [/_ddot$/, "Accelerations"], [/_dot$/, "Speeds"],
];

/** Return the branch of a quantity: by its name, else by what the model says of it. */
function kindOf({ name }: Offered, known: ReadonlyMap<string, Kind>): Kind {
  if (ENERGIES.has(name)) return "Energies";
  return known.get(name) ?? ENDINGS.find(([pattern]) => pattern.test(name))?.[1] ?? "Others";
}

/** Return the tree of curves; empty branches are left out. */
export function curveTree(curves: readonly Offered[], names: { readonly coordinates: readonly string[]; readonly speeds: readonly string[]; readonly inputs: readonly string[] }): Branch[] {
  const known = new Map<string, Kind>();
  for (const each of names.inputs) known.set(each, "Inputs");
  for (const each of names.speeds) known.set(each, "Speeds");
  for (const each of names.coordinates) known.set(each, "Positions");
  return TITLES.map((title) => {
    const own = curves.filter((each) => kindOf(each, known) === title);
    return title === "Reactions" ? { title, curves: [], branches: byJoint(own) } : { title, curves: own, branches: [] };
  }).filter((each) => each.curves.length + each.branches.length > 0);
}

/** Return reactions by their joint, whose name may have blanks. */
function byJoint(curves: readonly Offered[]): Branch[] {
  const jointOf = ({ name }: Offered): string => name.replace(/^reaction /, "").replace(/ [FM][xyz]$/, "");
  const joints = [...new Set(curves.map(jointOf))];
  return joints.map((title) => ({ title, curves: curves.filter((each) => jointOf(each) === title), branches: [] }));
}

/** Return what is ticked at first: positions and speeds, up to six. */
export function firstTicks(tree: readonly Branch[]): string[] {
  return tree.filter((each) => each.title === "Positions" || each.title === "Speeds").flatMap((each) => each.curves.slice(0, 3)).map((each) => each.name);
}
