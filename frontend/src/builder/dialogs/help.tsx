/** Keys and gestures. */

import type { ReactElement } from "react";
import { COMMANDS, printedKeys, type Command } from "../commands/all";
import { Dialog } from "./dialog";

const GESTURES: readonly (readonly [string, string])[] = [
  ["Drag from the palette", "A new element where it is dropped"],
  ["Drag from port to port", "Joins two frames: choose by what"],
  ["Drag an end of an edge", "Joins another frame"],
  ["Double-click the diagram", "Add an element there"],
  ["Double-click a name", "Rename"],
  ["Drag over the diagram", "Select what is within"],
  ["Shift-click", "Select further elements"],
  ["Arrow keys", "Move by a step of the grid; Shift: five; Alt: one point"],
  ["Alt while dragging", "Off the grid"],
  ["Middle or right button, wheel", "Pan the diagram; with Ctrl the wheel zooms"],
  ["Drag a body in the picture", "The loops follow; where it is left the mechanism starts; Esc: back"],
  ["Drag the background of the picture, or any part with Alt", "Rotate the view"],
  ["Tab, Enter", "From element to element; select"],
];

export function HelpDialog(): ReactElement {
  const commands = Object.values(COMMANDS as Record<string, Command>).filter((each) => each.keys.length > 0);
  return (
    <Dialog title="Keys and gestures" name="help">
      <dl className="keys">{commands.map((each) => <div key={each.title}><dt>{each.keys.map((keys) => <kbd key={keys}>{printedKeys(keys)}</kbd>)}</dt><dd>{each.title}</dd></div>)}</dl>
      <h3>Gestures</h3>
      <dl className="keys">{GESTURES.map(([gesture, meaning]) => <div key={gesture}><dt>{gesture}</dt><dd>{meaning}</dd></div>)}</dl>
      <p className="soft">The picture has keys of its own while it has the focus: press ? there.</p>
    </Dialog>
  );
}
