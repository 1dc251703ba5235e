/** A joint, spring, force or constraint: a line with a badge. */

import { EdgeLabelRenderer, Position, type EdgeProps } from "@xyflow/react";
import { memo, useEffect, type MouseEvent, type ReactElement } from "react";
import { curveOf, pathOf, pointAt } from "../model/curves";
import type { Side } from "../model/layout";
import { count } from "../shell/counts";
import { Icon } from "../shell/icons";
import { select, useStore } from "../store";
import type { JointFlowEdge } from "./flow";
import { NameEditor } from "./name_editor";

const SIDES: Readonly<Record<Position, Side>> = {
  [Position.Left]: "left", [Position.Right]: "right", [Position.Top]: "top", [Position.Bottom]: "bottom",
};

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
  const { id, data, selected } = props;
  const renaming = useStore((state) => state.renaming === id);
  const glowing = useStore(({ glowing: ids }) => ids.includes(id));
  useEffect(() => { count("edge"); });
  if (data === undefined) return null;
  const { edge, severity, highlighted, rotation, translation } = data;
  const curve = curveOf(
    { x: props.sourceX, y: props.sourceY, side: SIDES[props.sourcePosition] },
    { x: props.targetX, y: props.targetY, side: SIDES[props.targetPosition] },
    edge,
  );
  const path = pathOf(curve);
  const middle = pointAt(curve, data.part);
  const trees = treeText(rotation, translation);
  const state = `${selected === true ? " selected" : ""}${highlighted ? " highlighted" : glowing ? " glowing" : ""}${severity === null ? "" : ` ${severity}`}`;
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
          {data.couplings.map((each) => (
            <button key={each.id} type="button" className="coupling-mark" aria-label={`To ${each.name}`} title={`${each.type.replaceAll("_", " ")} ${each.name}`} data-testid={`mark-${edge.name}-${each.name}`} onClick={(event) => { event.stopPropagation(); select([each.id], `${each.name} selected`); }}>
              <Icon name={each.type} fallback={each.section} size={14} />
            </button>
          ))}
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
