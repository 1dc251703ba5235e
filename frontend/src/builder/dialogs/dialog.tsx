/** A modal window of the page. */

import { useEffect, useRef, type ReactElement, type ReactNode } from "react";
import { Icon } from "../shell/icons";
import { useStore } from "../store";

export function Dialog({ title, children, name = "" }: { readonly title: string; readonly children: ReactNode; readonly name?: string }): ReactElement {
  const dialog = useRef<HTMLDialogElement>(null);
  useEffect(() => {
    const element = dialog.current;
    element?.showModal();
    return () => { element?.close(); };
  }, []);
  const close = (): void => { useStore.setState({ dialog: useStore.getState().document === null ? "start" : null }); };
  return (
    <dialog ref={dialog} className={`dialog ${name}`} aria-label={title} onCancel={(event) => { event.preventDefault(); close(); }}>
      <header><h2>{title}</h2><button type="button" className="icon-button" aria-label="Close" onClick={close}><Icon name="close" /></button></header>
      <div className="dialog-body">{children}</div>
    </dialog>
  );
}
