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
    if (own.signal.aborted) return;
    const lost = error instanceof ServerError && error.status === 0;
    const { check: before } = useStore.getState();
    if (lost) {
      useStore.setState({ offline: true });
      pending = setTimeout(() => { void check(useStore.getState().data); }, 2000);
      return;
    }
    useStore.setState({
      checked: data,
      check: { summary: null, picture: before?.picture ?? null, values: {}, formulas: before?.formulas ?? {}, problems: problemsOf(error) },
    });
  }
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
