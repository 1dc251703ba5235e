/** The choice of a file of this computer. */

import { useEffect, useState, type SyntheticEvent, type ReactElement } from "react";
import { api, problemsOf } from "../api";
import { openFile, openModel, saveTo } from "../commands/files";
import { ProblemLines } from "../panels/field_frame";
import { Icon } from "../shell/icons";
import { useStore } from "../store";
import type { FolderAnswer, Problem } from "../types";
import { Dialog } from "./dialog";

function useFolder(): { folder: FolderAnswer | null; problems: readonly Problem[]; go: (path: string) => void } {
  const [folder, setFolder] = useState<FolderAnswer | null>(null);
  const [problems, setProblems] = useState<readonly Problem[]>([]);
  const go = (path: string): void => {
    api.folder(path).then((answer) => {
      setFolder(answer);
      setProblems([]);
    }, (error: unknown) => { setProblems(problemsOf(error)); });
  };
  useEffect(() => {
    const path = useStore.getState().document?.path ?? "";
    go(path.replace(/[/\\][^/\\]*$/, ""));
  }, []);
  return { folder, problems, go };
}

function joined(folder: string, name: string): string {
  const mark = folder.includes("\\") ? "\\" : "/";
  return folder.endsWith(mark) ? folder + name : folder + mark + name;
}

function Listing({ folder, go, choose }: { readonly folder: FolderAnswer; readonly go: (path: string) => void; readonly choose: (path: string, kind: string) => void }): ReactElement {
  const { parent } = folder;
  return (
    <>
      <p className="folder-path soft">{folder.path}</p>
      <ul className="files listing" aria-label={`Folder ${folder.path}`}>
        {parent !== null && <li><button type="button" onClick={() => { go(parent); }}><Icon name="folder" size={16} /> ..</button></li>}
        {folder.entries.map((each) => (
          <li key={each.name}>
            <button type="button" onClick={() => { const path = joined(folder.path, each.name); if (each.kind === "folder") go(path); else choose(path, each.kind); }}>
              <Icon name={each.kind === "folder" ? "folder" : "file"} size={16} /> {each.name}
            </button>
          </li>
        ))}
        {folder.entries.length === 0 && <li className="soft">No model here.</li>}
      </ul>
    </>
  );
}

export function OpenDialog(): ReactElement {
  const { folder, problems, go } = useFolder();
  const notice = useStore((state) => state.notice);
  const choose = (path: string, kind: string): void => { void openModel(kind === "urdf" ? { urdf: path } : { path }); };
  return (
    <Dialog title="Open a model">
      <p className="soft">Model files (TOML) and robots (URDF). You can also drag a file into the window.</p>
      {folder !== null && <Listing folder={folder} go={go} choose={choose} />}
      <ProblemLines problems={[...problems, ...notice]} />
      <label className="button upload">From this browser…
        <input type="file" accept=".toml,.json" className="hidden" onChange={(event) => { const file = event.target.files?.[0]; if (file !== undefined) void openFile(file); }} />
      </label>
    </Dialog>
  );
}

export function SaveDialog(): ReactElement {
  const { folder, problems, go } = useFolder();
  const document = useStore((state) => state.document);
  const notice = useStore((state) => state.notice);
  const [name, setName] = useState(() => (document?.name ?? "model").replace(/(\.toml)?$/, ".toml").replace(/\s+/g, "_"));
  const exists = folder?.entries.some((each) => each.name === name) ?? false;
  const accept = (event: SyntheticEvent): void => {
    event.preventDefault();
    if (folder !== null) void saveTo(joined(folder.path, name.endsWith(".toml") ? name : `${name}.toml`), exists);
  };
  return (
    <Dialog title="Save as">
      <form onSubmit={accept}>
        <label className="field">File name <input value={name} autoFocus aria-label="File name" onChange={(event) => { setName(event.target.value); }} /></label>
        {folder !== null && <Listing folder={folder} go={go} choose={(path) => { setName(path.split(/[/\\]/).at(-1)!); }} />}
        <ProblemLines problems={[...problems, ...notice]} />
        <button type="submit" className="button primary" disabled={name.trim() === ""}>{exists ? "Replace it" : "Save"}</button>
      </form>
    </Dialog>
  );
}
