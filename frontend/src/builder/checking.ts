/** Asks the server for problems, picture and formulas after each change of the model. */

import { api, problemsOf, ServerError } from "./api";
import { useStore } from "./store";
import type { Model } from "./types";

const ABSENT: readonly number[] = [0, 401];
const WAIT = 60; // [ms] after the last change
const SEEK_WAIT = 1500; // [ms]

let pending: ReturnType<typeof setTimeout> | null = null;
let underWay: AbortController | null = null;

async function check(data: Model): Promise<void> {
  underWay?.abort();
  const own = new AbortController();
  underWay = own;
  try {
    const answer = await api.check(useStore.getState().document?.id ?? "", data, own.signal);
    useStore.setState({ check: answer, checked: data });
  } catch (error) {
    if (!own.signal.aborted) takeFailure(data, error);
  }
}

/** Keep the picture of before; without a server the check waits for it. */
function takeFailure(data: Model, error: unknown): void {
  if (error instanceof ServerError && ABSENT.includes(error.status)) return;
  const { check: before } = useStore.getState();
  const kept = { picture: before?.picture ?? null, formulas: before?.formulas ?? {} };
  useStore.setState({ checked: data, check: { ...kept, summary: null, values: {}, problems: problemsOf(error) } });
}

/** Check the model now and after each change; return what ends it. */
export function followChanges(): () => void {
  return useStore.subscribe((state, before) => {
    if (state.document === null) return;
    const reached = state.server === "here" && before.server !== "here";
    if (state.data === before.data && state.document === before.document && !reached) return;
    if (state.data === state.checked) return;
    if (pending !== null) clearTimeout(pending);
    pending = setTimeout(() => { void check(state.data); }, state.document === before.document ? WAIT : 0);
  });
}

/** Look for a server that does not answer, until it is reached again; return what ends it. */
export function seekServer(): () => void {
  const timer = setInterval(() => {
    if (useStore.getState().server !== "here") void api.recent().catch(() => undefined);
  }, SEEK_WAIT);
  return () => { clearInterval(timer); };
}
