/** Window that asks for the operator code and for a name, which the audit log records. */
import { useState } from "preact/hooks";
import { texts } from "../texts";
import { Dialog } from "../ui/dialog";
import type { Access } from "./use_session";

export function SignIn({ access, onClose }: { access: Access; onClose(): void }) {
  const [code, setCode] = useState(access.code);
  const [name, setName] = useState(access.lastName);
  const [refusal, setRefusal] = useState<string | null>(null);
  const submit = async (event: Event): Promise<void> => {
    event.preventDefault();
    const reason = await access.signIn(code.trim(), name.trim());
    setRefusal(reason);
    if (reason === null) onClose();
  };
  const { signIn } = texts;
  return (
    <Dialog title={signIn.title} testId="sign-in" onClose={onClose}>
      <form class="form" onSubmit={(event) => void submit(event)}>
        <label>
          {signIn.name}
          <input
            data-testid="sign-in-name"
            autocomplete="nickname"
            required
            maxLength={40}
            value={name}
            onInput={(event) => setName(event.currentTarget.value)}
          />
        </label>
        <label>
          {signIn.code}
          <input
            data-testid="sign-in-code"
            type="password"
            autocomplete="off"
            required
            maxLength={200}
            value={code}
            onInput={(event) => setCode(event.currentTarget.value)}
          />
        </label>
        <p class="is-bad" role="alert" data-testid="sign-in-refusal">
          {refusal}
        </p>
        <div class="dialog-buttons">
          <button type="button" data-testid="sign-in-cancel" onClick={onClose}>
            {signIn.observe}
          </button>
          <button type="submit" class="primary" data-testid="sign-in-ok">
            {signIn.submit}
          </button>
        </div>
      </form>
    </Dialog>
  );
}
