/** What is running: its stage, percentage, time, and Cancel. */

import { useEffect, useState, type ReactElement } from "react";
import { cancelJobs, labelOfJob, laneOf } from "../commands/jobs";
import { ProblemLines } from "../panels/field_frame";
import { Icon } from "../shell/icons";
import { useStore, type Run } from "../store";

export function Progress(): ReactElement {
  const { computation, equations } = useStore((state) => state.runs);
  return (
    <>
      <div className="progress-list">
        {equations !== undefined && <Running run={equations} />}
        {computation !== undefined && <Running run={computation} />}
      </div>
      <Failed />
    </>
  );
}

function Running({ run }: { readonly run: Run }): ReactElement {
  const elapsed = useElapsed(run.turn);
  const percent = run.state?.percent ?? null;
  return (
    <div className="progress" role="status" data-testid="progress">
      <b>{labelOfJob(run.kind)}</b>
      <span className="soft">{run.state?.stage ?? "starting"}{percent === null ? "" : ` ${Math.round(percent)} %`}</span>
      <progress aria-label={labelOfJob(run.kind)} max={100} {...(percent === null ? {} : { value: percent })} />
      <span className="soft number">{elapsed.toFixed(0)} s</span>
      <button type="button" className="button small" onClick={() => { cancelJobs([laneOf(run.kind)]); }}>Cancel</button>
    </div>
  );
}

function useElapsed(turn: number): number {
  const [elapsed, setElapsed] = useState(0);
  useEffect(() => {
    const begun = performance.now();
    const timer = setInterval(() => { setElapsed((performance.now() - begun) / 1000); }, 1000);
    return () => { clearInterval(timer); };
  }, [turn]);
  return elapsed;
}

/** What went wrong with the last command, until it is closed. */
function Failed(): ReactElement | null {
  const notice = useStore((state) => state.notice);
  if (notice.length === 0) return null;
  return (
    <div className="notice" data-testid="notice">
      <ProblemLines problems={notice} />
      <button type="button" className="icon-button" aria-label="Close the message" onClick={() => { useStore.setState({ notice: [] }); }}><Icon name="close" size={15} /></button>
    </div>
  );
}
