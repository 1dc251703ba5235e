/** How long to simulate, with what inputs, and how closely. */

import { useState, type Dispatch, type ReactElement, type ReactNode, type SetStateAction, type SyntheticEvent } from "react";
import { simulate } from "../commands/jobs";
import { textOf } from "../model/entries";
import { isArray } from "../model/pointers";
import { useStore, type SimulationOptions } from "../store";
import { Dialog } from "./dialog";

const MOST_SAMPLES = 200_000;
const SOLVERS = [["", "Automatic"], ["explicit", "Explicit, order 8"], ["stiff", "Stiff, implicit"]] as const;

/** Return what the texts of the window mean, with what is wrong of each. */
function read(end: string, step: string, rtol: string): { t_end: number; step: number | null; rtol: number; wrong: Readonly<Record<"end" | "step" | "rtol", string>> } {
  const [t_end, each, tolerance] = [Number(end), step.trim() === "" ? null : Number(step), Number(rtol)];
  const few = each === null || (each > 0 && each <= t_end && t_end / each < MOST_SAMPLES);
  const wrong = {
    end: t_end > 0 && t_end <= 1e6 ? "" : "A number of seconds above 0.",
    step: few ? "" : "A number of seconds above 0 and below the duration; or empty: every step of the solver.",
    rtol: tolerance > 0 && tolerance < 1 ? "" : "A number between 0 and 1, such as 1e-8.",
  };
  return { t_end, step: each, rtol: tolerance, wrong };
}

export function SimulateDialog(): ReactElement {
  const before = useStore((state) => state.simulation);
  const listed = useStore((state) => state.data["inputs"]);
  const names = isArray(listed) ? listed.map(textOf) : [];
  const [end, setEnd] = useState(String(before.t_end));
  const [step, setStep] = useState(before.step === null ? "" : String(before.step));
  const [rtol, setRtol] = useState(before.rtol.toExponential());
  const [solver, setSolver] = useState(before.solver);
  const [inputs, setInputs] = useState(before.inputs);
  const { wrong, ...numbers } = read(end, step, rtol);
  const valid = Object.values(wrong).every((each) => each === "");
  const accept = (event: SyntheticEvent): void => {
    event.preventDefault();
    if (!valid) return;
    useStore.setState({ dialog: null });
    simulate({ ...numbers, inputs, solver });
  };
  return (
    <Dialog title="Simulate">
      <form onSubmit={accept} className="form simulate">
        <Line label="Duration" unit="s" wrong={wrong.end}><input value={end} autoFocus aria-label="Duration" aria-invalid={wrong.end !== ""} onChange={(event) => { setEnd(event.target.value); }} /></Line>
        <Line label="Output step" unit="s" wrong={wrong.step}><input value={step} placeholder="every step of the solver" aria-label="Output step" aria-invalid={wrong.step !== ""} onChange={(event) => { setStep(event.target.value); }} /></Line>
        <Line label="Solver"><select value={solver} aria-label="Solver" onChange={(event) => { setSolver(event.target.value as SimulationOptions["solver"]); }}>{SOLVERS.map(([word, text]) => <option key={word} value={word}>{text}</option>)}</select></Line>
        <Line label="Relative tolerance" wrong={wrong.rtol}><input value={rtol} aria-label="Relative tolerance" aria-invalid={wrong.rtol !== ""} onChange={(event) => { setRtol(event.target.value); }} /></Line>
        <InputLines names={names} inputs={inputs} setInputs={setInputs} />
        <div className="row"><button type="submit" className="button primary" disabled={!valid}>Simulate</button></div>
      </form>
    </Dialog>
  );
}

function InputLines({ names, inputs, setInputs }: { readonly names: readonly string[]; readonly inputs: SimulationOptions["inputs"]; readonly setInputs: Dispatch<SetStateAction<SimulationOptions["inputs"]>> }): ReactElement {
  return (
    <>
      {names.map((name) => (
        <Line key={name} label={`Input ${name}`}>
          <input value={inputs[name] ?? ""} placeholder="0, or a formula in t and the coordinates" aria-label={`Input ${name}`} onChange={(event) => { setInputs({ ...inputs, [name]: event.target.value }); }} />
        </Line>
      ))}
    </>
  );
}

function Line({ label, unit = "", wrong = "", children }: { readonly label: string; readonly unit?: string; readonly wrong?: string; readonly children: ReactNode }): ReactElement {
  return (
    <label className="field">
      <span className="label">{label}{unit !== "" && <span className="unit">{unit}</span>}</span>
      {children}
      {wrong !== "" && <span className="field-problem error" role="alert">{wrong}</span>}
    </label>
  );
}
