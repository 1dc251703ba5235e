/** A joint, spring, force or constraint: a line with a badge. */

import { EdgeLabelRenderer, Position, type EdgeProps } from "@xyflow/react";
import { memo, type MouseEvent, type ReactElement } from "react";
import { Icon } from "../shell/icons";
import { select, useStore } from "../store";
import type { JointFlowEdge } from "./flow";
import { NameEditor } from "./name_editor";

const LANE = 44;

const OUTWARD: Readonly<Record<Position, readonly [number, number]>> = {
  [Position.Left]: [-1, 0], [Position.Right]: [1, 0], [Position.Top]: [0, -1], [Position.Bottom]: [0, 1],
};

export interface Curve {
  readonly path: string;
  readonly middle: readonly [number, number];
}

type Ends = Pick<EdgeProps, "sourceX" | "sourceY" | "targetX" | "targetY" | "sourcePosition" | "targetPosition">;

/** Return the line of an edge, set off from the others of the same two nodes. */
export function curveOf(ends: Ends, lane: number, lanes: number, flipped: boolean): Curve {
  const { sourceX, sourceY, targetX, targetY } = ends;
  const [dx, dy] = [targetX - sourceX, targetY - sourceY];
  const length = Math.hypot(dx, dy) || 1;
  const reach = Math.min(170, Math.max(36, 0.42 * length));
  const off = (lane - (lanes - 1) / 2) * LANE * (flipped ? -1 : 1) * (4 / 3);
  const [nx, ny] = [(-dy / length) * off, (dx / length) * off];
  const [ax, ay] = OUTWARD[ends.sourcePosition];
  const [bx, by] = OUTWARD[ends.targetPosition];
  const first = [sourceX + ax * reach + nx, sourceY + ay * reach + ny] as const;
  const second = [targetX + bx * reach + nx, targetY + by * reach + ny] as const;
  const path = `M${sourceX},${sourceY} C${first.join()} ${second.join()} ${targetX},${targetY}`;
  const middle = [(sourceX + targetX + 3 * (first[0] + second[0])) / 8, (sourceY + targetY + 3 * (first[1] + second[1])) / 8] as const;
  return { path, middle };
}

function treeText(rotation: boolean | null, translation: boolean | null): string {
  if (rotation === null || translation === null) return "";
  if (rotation && translation) return "in both trees";
  if (!rotation && !translation) return "closes a loop";
  return rotation ? "in the rotation tree only" : "in the translation tree only";
}

function treeClass(rotation: boolean | null, translation: boolean | null): string {
  if (rotation === null || translation === null) return "";
  return rotation && translation ? " tree" : rotation || translation ? " half-tree" : " chord";
}

export const JointEdge = memo(function JointEdge(props: EdgeProps<JointFlowEdge>): ReactElement | null {
  const { id, data, selected, source, target } = props;
  const renaming = useStore((state) => state.renaming === id);
  if (data === undefined) return null;
  const { edge, severity, highlighted, rotation, translation } = data;
  const { path, middle } = curveOf(props, edge.lane, edge.lanes, source > target);
  const trees = treeText(rotation, translation);
  const state = `${selected === true ? " selected" : ""}${highlighted ? " highlighted" : ""}${severity === null ? "" : ` ${severity}`}`;
  const click = (event: MouseEvent): void => {
    const { selection } = useStore.getState();
    if (!event.shiftKey && !event.ctrlKey && !event.metaKey) select([id], `${edge.type} ${edge.name} selected`);
    else select(selection.includes(id) ? selection.filter((each) => each !== id) : [...selection, id]);
  };
  return (
    <>
      <path d={path} className="edge-reach" />
      <path d={path} className={`edge-line ${edge.section}${treeClass(rotation, translation)}${state}`} data-testid={`edge-${edge.name}`} />
      <EdgeLabelRenderer>
        <div
          className={`edge-badge nodrag nopan ${edge.section}${treeClass(rotation, translation)}${state}`} data-testid={`badge-${edge.name}`}
          style={{ transform: `translate(-50%, -50%) translate(${middle[0].toFixed(1)}px, ${middle[1].toFixed(1)}px)` }}
          onClick={click} data-entry={id} title={`${edge.type.replaceAll("_", " ")} ${edge.name}${trees === "" ? "" : `, ${trees}`}`}
          onDoubleClick={(event) => { event.stopPropagation(); useStore.setState({ renaming: id }); }}
        >
          <Icon name={edge.type} fallback={edge.section} size={16} />
          {renaming ? <NameEditor id={id} name={edge.name} /> : <span>{edge.name}</span>}
          <TreeMark rotation={rotation} translation={translation} />
          {severity !== null && <span className={`badge-flag ${severity}`}><Icon name={severity} size={13} /></span>}
        </div>
      </EdgeLabelRenderer>
    </>
  );
});

/** Letters that say in which trees a joint is, so that the pattern of the line is not all there is. */
function TreeMark({ rotation, translation }: { rotation: boolean | null; translation: boolean | null }): ReactElement | null {
  if (rotation === null || translation === null || (rotation && translation)) return null;
  return <small className="tree-mark">{rotation ? "R only" : translation ? "T only" : "loop"}</small>;
}
