/** Asks the server for problems, picture and formulas after each change of the model. */

import { api, problemsOf, ServerError } from "./api";
import { useStore } from "./store";
import type { Model } from "./types";

const WAIT = 60; // [ms] after the last change

let pending: ReturnType<typeof setTimeout> | null = null;
let underWay: AbortController | null = null;

async function check(data: Model): Promise<void> {
  underWay?.abort();
  const own = new AbortController();
  underWay = own;
  try {
    const answer = await api.check(useStore.getState().document?.id ?? "", data, own.signal);
    useStore.setState({ check: answer, checked: data, offline: false });
  } catch (error) {
    if (!own.signal.aborted) takeFailure(data, error);
  }
}

/** Keep the picture of before; without a server look for it again. */
function takeFailure(data: Model, error: unknown): void {
  if (error instanceof ServerError && error.status === 0) {
    useStore.setState({ offline: true });
    pending = setTimeout(() => { void check(useStore.getState().data); }, 2000);
    return;
  }
  const { check: before } = useStore.getState();
  const kept = { picture: before?.picture ?? null, formulas: before?.formulas ?? {} };
  useStore.setState({ checked: data, check: { ...kept, summary: null, values: {}, problems: problemsOf(error) } });
}

/** Check the model now and after each change; return what ends it. */
export function followChanges(): () => void {
  return useStore.subscribe((state, before) => {
    if (state.document === null) return;
    if (state.data === before.data && state.document === before.document) return;
    if (state.data === state.checked) return;
    if (pending !== null) clearTimeout(pending);
    pending = setTimeout(() => { void check(state.data); }, state.document === before.document ? WAIT : 0);
  });
}
