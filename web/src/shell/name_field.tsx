/** Field for the name of the operator, in the header: it covers nothing, and needs no press of a button. */
import { useEffect, useRef } from "preact/hooks";
import { texts } from "../texts";
import type { AskedName } from "./use_asked_name";

const HINT_ID = "name-hint";
const REFUSAL_ID = "name-refusal";

interface Props {
  asked: AskedName;
  /** Called to sign in by another code. */
  onSignIn(): void;
}

export function NameField({ asked, onSignIn }: Props) {
  const input = useRef<HTMLInputElement>(null);
  useEffect(() => {
    if (document.activeElement === document.body) input.current?.focus({ preventScroll: true });
  }, []);
  const { signIn } = texts;
  const isRefused = asked.refusal !== "";
  const leave = (event: FocusEvent & { currentTarget: HTMLElement }): void => {
    const goesTo = event.relatedTarget;
    if (goesTo instanceof Node && event.currentTarget.contains(goesTo)) return;
    // Somebody who changes to another window is still typing, and so is whoever lost the field to a change of the page.
    if (document.activeElement === input.current || input.current?.offsetParent == null) return;
    asked.leave();
  };
  return (
    <form
      class="name-field"
      data-testid="name-field"
      noValidate
      onFocusOut={leave}
      onSubmit={(event) => {
        event.preventDefault();
        asked.submit();
      }}
    >
      <label>
        <span>{signIn.name}</span>
        <input
          ref={input}
          data-testid="sign-in-name"
          autocomplete="nickname"
          maxLength={40}
          title={signIn.leaving}
          aria-describedby={isRefused ? REFUSAL_ID : HINT_ID}
          aria-invalid={isRefused}
          value={asked.typed}
          onInput={(event) => asked.type(event.currentTarget.value)}
        />
      </label>
      <span id={HINT_ID} hidden>
        {signIn.leaving}
      </span>
      <button type="submit" class="primary" data-testid="sign-in-ok">
        {signIn.submit}
      </button>
      <div class={`name-refusal ${isRefused ? "" : "is-empty"}`}>
        <span id={REFUSAL_ID} role="alert" data-testid="name-refusal">
          {asked.refusal}
        </span>
        {isRefused && asked.name !== "" && (
          <button type="button" data-testid="other-code" onClick={onSignIn}>
            {signIn.otherCode}
          </button>
        )}
      </div>
    </form>
  );
}
