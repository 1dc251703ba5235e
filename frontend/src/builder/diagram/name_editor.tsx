/** A name that is changed in place: Enter accepts, Escape rejects. */

import { useEffect, useRef, useState, type KeyboardEvent, type ReactElement } from "react";
import { acceptName } from "../rename_command";
import { useStore } from "../store";

export function NameEditor({ id, name }: { id: string; name: string }): ReactElement {
  const input = useRef<HTMLInputElement>(null);
  const rejected = useRef(false);
  const [refusal, setRefusal] = useState("");
  useEffect(() => {
    input.current?.focus();
    input.current?.select();
  }, []);
  const close = (): void => { useStore.setState({ renaming: null }); };
  const press = (event: KeyboardEvent): void => {
    event.stopPropagation();
    if (event.key === "Escape") {
      rejected.current = true;
      close();
    } else if (event.key === "Enter") input.current?.blur();
  };
  const leave = (): void => {
    const reason = rejected.current ? "" : acceptName(id, input.current?.value ?? name);
    setRefusal(reason);
    if (reason === "") close();
    else setTimeout(() => { input.current?.focus(); }); // the name waits there for another try, or Escape
  };
  return (
    <>
      <input
        ref={input} className="name-editor nodrag nopan" defaultValue={name} aria-label={`New name of ${name}`} size={Math.max(6, name.length)}
        aria-invalid={refusal === "" ? undefined : true} onKeyDown={press} onBlur={leave} onDoubleClick={(event) => { event.stopPropagation(); }}
      />
      {refusal !== "" && <span role="alert" className="name-refusal">{refusal}</span>}
    </>
  );
}
