/** The line that follows the pointer from a port, and what a port that cannot be joined says. */

import type { ConnectionLineComponentProps } from "@xyflow/react";
import type { ReactElement } from "react";

export function ConnectionLine({ fromX, fromY, toX, toY, connectionStatus, fromNode, toNode }: ConnectionLineComponentProps): ReactElement {
  const same = toNode !== null && toNode.id === fromNode.id;
  return (
    <g className={`connection-line ${same ? "invalid" : (connectionStatus ?? "open")}`}>
      <path d={`M${fromX},${fromY} L${toX},${toY}`} />
      <circle cx={toX} cy={toY} r={5} />
      {same && <text x={toX + 12} y={toY - 10}>A body cannot be connected to itself</text>}
    </g>
  );
}
