/** Coordinates as sliders: one is dragged, and the loops follow. */

import { useEffect, useRef, useState, type ReactElement } from "react";
import { api, problemsOf } from "../api";
import { joinPointer, withValue } from "../model/pointers";
import { edit, endGesture, useStore } from "../store";
import type { Model, PoseAnswer } from "../types";
import { sentence } from "../panels/field_frame";
import { pictureNow } from "./shown";

interface Drag {
  readonly of: Model;
  readonly values: Readonly<Record<string, number>>;
  readonly fixed: string | null;
  readonly problem: string;
}

function showPose({ positions, quaternions }: PoseAnswer): void {
  const { shown } = pictureNow;
  if (shown === null) return;
  shown.source.show({ positions, quaternions });
  shown.player.refresh();
}

/** Send the newest of the wanted values, one request at a time. */
function usePoses(values: Readonly<Record<string, number>>): { drag: Drag | null; move: (name: string, value: number) => void; reset: () => void } {
  const data = useStore((state) => state.data);
  const [drag, setDrag] = useState<Drag | null>(null);
  const next = useRef<{ name: string; value: number } | null>(null);
  const busy = useRef(false);
  const last = useRef(values);
  useEffect(() => {
    setDrag(null);
    last.current = values;
  }, [data, values]);
  const send = async (): Promise<void> => {
    while (next.current !== null) {
      const { name, value } = next.current;
      next.current = null;
      try {
        const answer = await api.pose(useStore.getState().document?.id ?? "", data, { [name]: value }, last.current);
        last.current = answer.values;
        setDrag({ of: data, values: answer.values, fixed: name, problem: "" });
        showPose(answer);
      } catch (error) {
        setDrag((before) => ({ of: data, values: before?.values ?? last.current, fixed: name, problem: problemsOf(error)[0]?.what ?? "" }));
      }
    }
  };
  const move = (name: string, value: number): void => {
    useStore.setState({ showsMotion: false, analysisPicture: null });
    next.current = { name, value };
    if (busy.current) return;
    busy.current = true;
    void send().finally(() => { busy.current = false; });
  };
  const reset = (): void => {
    setDrag(null);
    last.current = values;
    pictureNow.shown?.source.show(null);
    pictureNow.shown?.player.refresh();
  };
  return { drag: drag?.of === data ? drag : null, move, reset };
}

const NOTHING: Readonly<Record<string, number>> = {};

export function Positions(): ReactElement {
  const values = useStore((state) => state.check?.values) ?? NOTHING;
  const summary = useStore((state) => state.check?.summary);
  const { drag, move, reset } = usePoses(values);
  const names = summary?.coordinates.filter((each) => values[each] !== undefined) ?? [];
  if (names.length === 0) return <p className="soft pad">Coordinates appear here as soon as the mechanism can be assembled. Drag one, and the loops follow.</p>;
  const keep = (): void => {
    if (drag?.fixed == null) return;
    const pointer = `/initial${joinPointer(drag.fixed)}`;
    const value = String(Number((drag.values[drag.fixed] ?? 0).toPrecision(6)));
    endGesture();
    edit((data) => withValue(data, pointer, value));
  };
  return (
    <div className="positions" data-testid="positions">
      {names.map((name) => <Slider key={name} name={name} start={values[name]!} now={(drag?.values ?? values)[name] ?? 0} move={move} />)}
      {drag !== null && drag.problem !== "" && <p className="field-problem warning" role="alert">{sentence(drag.problem)}</p>}
      <div className="row">
        <button type="button" className="button small" disabled={drag === null} onClick={reset}>Back to the start</button>
        <button type="button" className="button small" disabled={drag === null} onClick={keep}>Start from here</button>
      </div>
    </div>
  );
}

function Slider({ name, start, now, move }: { readonly name: string; readonly start: number; readonly now: number; readonly move: (name: string, value: number) => void }): ReactElement {
  const reach = Math.max(Math.PI, 1.5 * Math.abs(start));
  return (
    <label className="slider">
      <span>{name}</span>
      <input type="range" aria-label={name} min={start - reach} max={start + reach} step="any" value={now} onChange={(event) => { move(name, Number(event.target.value)); }} />
      <output>{now.toFixed(4)}</output>
    </label>
  );
}
