/** How long to simulate, and with what inputs. */

import { useState, type SyntheticEvent, type ReactElement } from "react";
import { simulate, simulationOptions } from "../commands/jobs";
import { textOf } from "../model/entries";
import { isArray } from "../model/pointers";
import { useStore } from "../store";
import { Dialog } from "./dialog";

export function SimulateDialog(): ReactElement {
  const before = simulationOptions();
  const listed = useStore((state) => state.data["inputs"]);
  const names = isArray(listed) ? listed.map(textOf) : [];
  const [end, setEnd] = useState(String(before.t_end));
  const [inputs, setInputs] = useState(before.inputs);
  const seconds = Number(end);
  const valid = Number.isFinite(seconds) && seconds > 0;
  const accept = (event: SyntheticEvent): void => {
    event.preventDefault();
    if (!valid) return;
    useStore.setState({ dialog: null });
    simulate({ t_end: seconds, inputs });
  };
  return (
    <Dialog title="Simulate">
      <form onSubmit={accept} className="form">
        <label className="field">Duration [s]<input value={end} autoFocus aria-label="Duration" aria-invalid={!valid} onChange={(event) => { setEnd(event.target.value); }} /></label>
        {names.map((name) => (
          <label className="field" key={name}>Input {name}
            <input value={inputs[name] ?? ""} placeholder="0, or a formula in t and the coordinates" aria-label={`Input ${name}`} onChange={(event) => { setInputs({ ...inputs, [name]: event.target.value }); }} />
          </label>
        ))}
        <button type="submit" className="button primary" disabled={!valid}>Simulate</button>
      </form>
    </Dialog>
  );
}
