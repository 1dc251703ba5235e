/** The start: examples, recent files, drafts, a new model. */

import { useEffect, useId, useState, type ReactElement } from "react";
import { api, problemsOf } from "../api";
import { COMMANDS } from "../commands/all";
import { mergedDrafts, openDraft } from "../commands/drafts";
import { newModel, openModel } from "../commands/files";
import { ProblemLines } from "../panels/field_frame";
import { Icon } from "../shell/icons";
import { ServerBar } from "../shell/server_bar";
import { useShownTheme } from "../shell/theme";
import { useStore } from "../store";
import type { Draft, Example, Problem, RecentFile } from "../types";

interface Offers {
  readonly examples: readonly Example[];
  readonly files: readonly RecentFile[];
  readonly drafts: readonly Draft[];
}

function useOffers(): { offers: Offers | null; problems: readonly Problem[] } {
  const [offers, setOffers] = useState<Offers | null>(null);
  const [problems, setProblems] = useState<readonly Problem[]>([]);
  useEffect(() => {
    Promise.all([api.examples(), api.recent(), api.recovery()]).then(
      ([examples, files, drafts]) => { setOffers({ examples, files, drafts: mergedDrafts(drafts) }); },
      (error: unknown) => { setProblems(problemsOf(error)); },
    );
  }, []);
  return { offers, problems };
}

export function StartScreen(): ReactElement {
  const { offers, problems } = useOffers();
  const hasDocument = useStore((state) => state.document !== null);
  const notice = useStore((state) => state.notice);
  return (
    <main className="start" data-testid="start">
      <div className="start-inner">
        <header className="start-head">
          <div>
            <h1>symbody <span>ModelBuilder</span></h1>
            <p className="soft">Draw a mechanism, read its equations, watch it move.</p>
          </div>
          <div className="row">
            <button type="button" className="button primary" onClick={() => { void newModel(); }}><Icon name="plus" size={17} /> New model</button>
            <button type="button" className="button" onClick={() => { COMMANDS.open.run(); }}><Icon name="open" size={17} /> Open…</button>
            {hasDocument && <button type="button" className="button" onClick={() => { useStore.setState({ dialog: null }); }}><Icon name="close" size={17} /> Back</button>}
          </div>
        </header>
        <ServerBar />
        <ProblemLines problems={[...problems, ...notice]} />
        {offers !== null && offers.drafts.length > 0 && <Drafts drafts={offers.drafts} />}
        {offers !== null && offers.files.length > 0 && <Recent files={offers.files} />}
        {GROUPS.map(([group, title]) => <Cards key={group} title={title} examples={offers?.examples.filter((each) => each.group === group) ?? []} />)}
      </div>
    </main>
  );
}

const GROUPS: readonly (readonly [string, string])[] = [
  ["examples", "Examples"], ["linkages", "Gallery: linkages"], ["drives", "Gallery: drives and robots"], ["motions", "Gallery: motions"], ["contacts", "Gallery: contacts"],
];

function Cards({ title, examples }: { readonly title: string; readonly examples: readonly Example[] }): ReactElement | null {
  const id = useId();
  if (examples.length === 0) return null;
  return (
    <section aria-labelledby={id}>
      <h2 id={id}>{title}</h2>
      <ul className="cards">{examples.map((each) => <ExampleCard key={each.name} example={each} />)}</ul>
    </section>
  );
}

function ExampleCard({ example }: { readonly example: Example }): ReactElement {
  const theme = useShownTheme();
  const [drawn, setDrawn] = useState(true);
  const picture = `/cards/${example.name}${theme === "light" ? "" : "_dark"}.webp`;
  return (
    <li>
      <button type="button" className="card" data-testid={`example-${example.name}`} onClick={() => { void openModel({ example: example.name }); }}>
        <div className="card-picture">{drawn && <img src={picture} alt="" loading="lazy" onError={() => { setDrawn(false); }} />}</div>
        <b>{example.title}</b>
        <span className="soft">{example.summary}</span>
      </button>
    </li>
  );
}

function whenText(when: string): string {
  const date = new Date(when);
  return Number.isNaN(date.getTime()) ? when : date.toLocaleString(undefined, { dateStyle: "medium", timeStyle: "short" });
}

function Drafts({ drafts }: { readonly drafts: readonly Draft[] }): ReactElement {
  return (
    <section aria-labelledby="drafts-head" className="drafts">
      <h2 id="drafts-head">Unsaved edits</h2>
      <ul className="files">{drafts.map((each) => <li key={each.id}><button type="button" onClick={() => { void openDraft(each); }}><Icon name="file" size={16} /> <b>{each.name}</b> <span className="soft">{each.path ?? "not saved yet"} · {whenText(each.when)}</span></button></li>)}</ul>
    </section>
  );
}

function Recent({ files }: { readonly files: readonly RecentFile[] }): ReactElement {
  return (
    <section aria-labelledby="recent-head">
      <h2 id="recent-head">Recent files</h2>
      <ul className="files">{files.slice(0, 6).map((each) => <li key={each.path}><button type="button" onClick={() => { void openModel({ path: each.path }); }}><Icon name="file" size={16} /> <b>{each.name}</b> <span className="soft">{each.path} · {whenText(each.when)}</span></button></li>)}</ul>
    </section>
  );
}
