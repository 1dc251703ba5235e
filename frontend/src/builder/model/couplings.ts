/** What couples coordinates, and the joints whose coordinates they are. */

import type { EntryId } from "./entries";
import type { Wire } from "./wires";

/** A coupling and a joint, by one coordinate of the joint that the coupling contains. */
export interface CouplingLink {
  readonly coupling: EntryId;
  readonly joint: EntryId;
  readonly coordinate: string;
}

/** Return whether a wire leads from a joint that is drawn to a coupling. */
function isLink({ source, target }: Wire, couplings: ReadonlySet<EntryId>, drawn: ReadonlySet<EntryId>): boolean {
  return couplings.has(target) && target.startsWith("constraint/") && source.startsWith("joint/") && drawn.has(source);
}

/** Return the links of couplings to joints, one a coordinate, and the wires that are none. */
export function splitWires(wires: readonly Wire[], couplings: ReadonlySet<EntryId>, drawn: ReadonlySet<EntryId>): { links: CouplingLink[]; others: Wire[] } {
  const links = wires.filter((each) => isLink(each, couplings, drawn)).flatMap(({ source, target, roots }) => (
    [...new Set(roots)].map((coordinate) => ({ coupling: target, joint: source, coordinate }))
  ));
  return { links, others: wires.filter((each) => !isLink(each, couplings, drawn)) };
}
