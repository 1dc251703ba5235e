/** Asks the server for problems, picture and formulas after each change of the model. */

import { api, problemsOf, ServerError } from "./api";
import { keepWires } from "./model/wires";
import { useStore, type State } from "./store";
import type { Model } from "./types";

const ABSENT: readonly number[] = [0, 401];
const WAIT = 60; // [ms] after the last change
const REST = 400; // [ms] after the last change of parameters, whose picture comes before
const SEEK_WAIT = 1500; // [ms]
const LOOK_WAIT = 4; // of these waits: how often a server that answered is looked at while the page is seen

let pending: ReturnType<typeof setTimeout> | null = null;
let underWay: AbortController | null = null;
let drawing: AbortController | null = null;
/** The newest model whose parameters changed while another one was drawn. */
let waiting: Model | null = null;

async function check(data: Model): Promise<void> {
  underWay?.abort();
  const own = new AbortController();
  underWay = own;
  try {
    const answer = await api.check(useStore.getState().document?.id ?? "", data, own.signal);
    if (own.signal.aborted) return;
    keepWires(data, answer.wires);
    useStore.setState({ check: answer, checked: data });
  } catch (error) {
    if (!own.signal.aborted) takeFailure(data, error);
  }
}

/** Keep the picture of before; without a server the check waits for it. */
function takeFailure(data: Model, error: unknown): void {
  if (error instanceof ServerError && ABSENT.includes(error.status)) return;
  const { check: before } = useStore.getState();
  const kept = { picture: before?.picture ?? null, formulas: before?.formulas ?? {}, wires: before?.wires ?? [] };
  useStore.setState({ checked: data, check: { ...kept, summary: null, values: {}, problems: problemsOf(error) } });
}

/** Show the picture of a model whose parameters alone differ from one that was checked: one at a time, the newest next. */
async function redraw(data: Model): Promise<void> {
  if (drawing !== null) {
    waiting = data;
    return;
  }
  drawing = new AbortController();
  try {
    const { picture, values } = await api.redraw(useStore.getState().document?.id ?? "", data, drawing.signal);
    const { check: before, checked } = useStore.getState();
    // a check that came meanwhile knows more
    if (picture !== null && before !== null && checked !== data) useStore.setState({ check: { ...before, picture, values } });
  } catch {
    // the check says what is wrong
  } finally {
    drawing = null;
  }
  const next = waiting;
  waiting = null;
  if (next !== null) void redraw(next);
}

/** Have the server prepare for changes of parameters, which are about to come. */
export function expectChanges(): void {
  const { data, check: now } = useStore.getState();
  if (now?.summary != null) void redraw(data);
}

/** Return whether models differ in no section, or in this one alone. */
function differIn(section: string, one: Model, other: Model): boolean {
  const names = new Set([...Object.keys(one), ...Object.keys(other)]);
  return [...names].every((name) => name === section || one[name] === other[name]);
}

function isRearranged(data: Model, before: Model): boolean {
  return differIn("layout", data, before);
}

function isOfParameters(state: State, before: State): boolean {
  if (state.document !== before.document || before.check?.picture == null) return false;
  return differIn("parameters", state.data, before.data);
}

/** Whether there is something to check: another model, another document, or the server again. */
function isNews(state: State, before: State): boolean {
  const reached = state.server === "here" && before.server !== "here";
  return state.document !== null && state.data !== state.checked && (state.data !== before.data || state.document !== before.document || reached);
}

/** Return how long a check waits [ms]: until the keys rest where a picture comes before. */
function waitOf(state: State, before: State): number {
  if (state.document !== before.document) return 0;
  return isOfParameters(state, before) ? REST : WAIT;
}

/** Check the model now and after each change; return what ends it. */
export function followChanges(): () => void {
  return useStore.subscribe((state, before) => {
    if (!isNews(state, before)) return;
    if (before.checked === before.data && state.document === before.document && isRearranged(state.data, before.data)) {
      useStore.setState({ checked: state.data }); // where the nodes are says nothing of the mechanism
      return;
    }
    if (pending !== null) clearTimeout(pending);
    underWay?.abort();
    const wait = waitOf(state, before);
    if (wait === REST) void redraw(state.data);
    pending = setTimeout(() => { void check(state.data); }, wait);
  });
}

/** Look whether the server answers, more often while it does not: nothing says Ready of a server that ended. Return what ends it. */
export function seekServer(): () => void {
  let waits = 0;
  const timer = setInterval(() => {
    waits += 1;
    const due = waits % LOOK_WAIT === 0 && document.visibilityState === "visible";
    if (useStore.getState().server !== "here" || due) void api.recent().catch(() => undefined);
  }, SEEK_WAIT);
  return () => { clearInterval(timer); };
}
