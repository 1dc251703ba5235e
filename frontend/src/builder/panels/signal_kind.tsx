/** The choice among the three forms of a signal. */

import type { ReactElement } from "react";
import type { Entry } from "../model/entries";
import { formOf, FORMS, withForm, type SignalForm } from "../model/signal_forms";
import { edit, endGesture } from "../store";

const TITLES: Readonly<Record<SignalForm, string>> = { value: "value", output: "output", rate: "state" };
const TIPS: Readonly<Record<SignalForm, string>> = {
  value: "A name for a formula.", output: "A name for an output of the mechanism.", rate: "A state, defined by its rate and its initial value.",
};

export function SignalKind({ entry }: { readonly entry: Entry }): ReactElement {
  const form = formOf(entry.value);
  const choose = (each: SignalForm): void => {
    endGesture();
    edit((data) => withForm(data, entry, each));
  };
  return (
    <div className="field">
      <div className="segments" role="radiogroup" aria-label="Kind of signal">
        {FORMS.map((each) => <button key={each} type="button" role="radio" aria-checked={each === form} title={TIPS[each]} onClick={() => { choose(each); }}>{TITLES[each]}</button>)}
      </div>
      <p className="tip">{TIPS[form]}</p>
    </div>
  );
}
