/** Requests to the server, also after it was started again on the same port. */

import { useStore, type ServerState } from "./store";

const TOKEN_TAG = 'meta[name="symbody-token"]';

function tokenIn(page: Document): string {
  return page.querySelector<HTMLMetaElement>(TOKEN_TAG)?.content ?? "";
}

let token = tokenIn(document);
let renewal: Promise<boolean> | null = null;

function noteServer(server: ServerState): void {
  if (useStore.getState().server !== server) useStore.setState({ server });
}

/** What the page says of a server that does not answer it, and what to do. */
export const ABSENCES: Readonly<Record<Exclude<ServerState, "here">, { readonly what: string; readonly fix: string }>> = {
  gone: {
    what: "the server of this page does not answer",
    fix: `restart it with symbody builder --port ${location.port}; this page keeps your edits`,
  },
  other: {
    what: "symbody builder was restarted, and this page belongs to the previous run",
    fix: "open the address that the new run prints in this browser; this page then continues with all edits",
  },
};

async function post(name: string, body: object, signal?: AbortSignal): Promise<Response> {
  return fetch(`/api/${name}`, {
    method: "POST",
    headers: { "Content-Type": "application/json", "X-Symbody-Token": token },
    body: JSON.stringify(body),
    ...(signal === undefined ? {} : { signal }),
  });
}

/**
 * Return the answer to a request, or null where no server is reached.
 *
 * A server that was started again knows neither this page's token nor its document. Its page, and with it the
 * token, is shown to who has its key: to this browser, as soon as the new address was opened in it.
 */
export async function request(name: string, body: object, signal?: AbortSignal): Promise<Response | null> {
  try {
    const response = await post(name, body, signal);
    if (response.status !== 401) {
      noteServer("here");
      return response;
    }
    renewal ??= renew().finally(() => { renewal = null; });
    const renewed = await renewal;
    noteServer(renewed ? "here" : "other");
    return renewed ? await post(name, body, signal) : response;
  } catch (error) {
    if (error instanceof DOMException && error.name === "AbortError") throw error;
    noteServer("gone");
    return null;
  }
}

/** Take the token of the run that answers now, and go on with the document there; return whether that is possible. */
async function renew(): Promise<boolean> {
  const response = await fetch("/", { headers: { Accept: "text/html" } });
  if (!response.ok) return false;
  const fresh = tokenIn(new DOMParser().parseFromString(await response.text(), "text/html"));
  if (fresh === "" || fresh === token) return false;
  token = fresh;
  const { document: shown } = useStore.getState();
  if (shown !== null && !(await adopt(shown.id, shown.path, shown.name, shown.fingerprint))) {
    // the new run may not write there: the document goes on without a file
    await adopt(shown.id, null, shown.name, null);
    useStore.setState({ document: { ...shown, path: null, fingerprint: null } });
  }
  return true;
}

/** Make a document known to the server that an earlier run opened; return whether its file is within reach. */
export async function adopt(id: string, path: string | null, name: string, fingerprint: string | null): Promise<boolean> {
  return (await post("adopt", { document: id, path, name, fingerprint })).ok;
}
