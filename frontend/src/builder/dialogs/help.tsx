/** Keys and gestures. */

import type { ReactElement } from "react";
import { COMMANDS, printedKeys, type Command } from "../commands/all";
import { Dialog } from "./dialog";

const GESTURES: readonly (readonly [string, string])[] = [
  ["Drag from the palette", "Add an element where you drop it"],
  ["Drag from port to port", "Connect two frames: choose the element"],
  ["Drag an end of an edge", "Connect to another frame"],
  ["Double-click the diagram", "Add an element there"],
  ["Double-click a name", "Rename"],
  ["Drag over the diagram", "Select everything inside"],
  ["Shift-click", "Add elements to the selection"],
  ["Arrow keys", "Move by one grid step; Shift: five steps; Alt: one point"],
  ["Alt while dragging", "Off the grid"],
  ["Middle or right button, wheel", "Pan the diagram; with Ctrl the wheel zooms"],
  ["Drag a body in the picture", "The loops stay closed; the mechanism starts from the position where you release the body; Esc: cancel"],
  ["Drag the background of the picture, or any part with Alt", "Rotate the view"],
  ["Tab, Enter", "Move between elements; select"],
];

export function HelpDialog(): ReactElement {
  const commands = Object.values(COMMANDS as Record<string, Command>).filter((each) => each.keys.length > 0);
  return (
    <Dialog title="Keys and gestures" name="help">
      <dl className="keys">{commands.map((each) => <div key={each.title}><dt>{each.keys.map((keys) => <kbd key={keys}>{printedKeys(keys)}</kbd>)}</dt><dd>{each.title}</dd></div>)}</dl>
      <h3>Gestures</h3>
      <dl className="keys">{GESTURES.map(([gesture, meaning]) => <div key={gesture}><dt>{gesture}</dt><dd>{meaning}</dd></div>)}</dl>
      <p className="soft">While the picture has the focus it has its own keys: press ? there.</p>
    </Dialog>
  );
}
