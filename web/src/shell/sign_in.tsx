/** Windows for signing in: with the operator code and a name for the audit log, with an account, or by an invitation. */
import type { ComponentChildren } from "preact";
import { useState } from "preact/hooks";
import { texts } from "../texts";
import { Dialog } from "../ui/dialog";
import type { Access } from "./use_session";

/** Who is signed in stays so, and can hold all vehicles, until somebody else has signed in or goes on as an observer. */
export function SignIn({ access, typedName, onClose }: { access: Access; typedName: string; onClose(): void }) {
  if (access.invitation !== "") return <Join access={access} onClose={onClose} />;
  return access.session?.accounts ? (
    <ByAccount access={access} onClose={onClose} />
  ) : (
    <ByCode access={access} typedName={typedName} onClose={onClose} />
  );
}

function ByCode({ access, typedName, onClose }: { access: Access; typedName: string; onClose(): void }) {
  const [code, setCode] = useState(access.code);
  const [name, setName] = useState(isSignedIn(access) ? "" : typedName || access.lastName);
  const { signIn } = texts;
  return (
    <SignInForm
      title={signIn.title}
      submit={signIn.submit}
      onSubmit={() => access.signIn(code.trim(), name.trim())}
      onClose={onClose}
      cancel={signIn.observe}
      onCancel={() => void access.signOut()}
      signedIn={access.session?.name ?? ""}
    >
      <label>
        {signIn.name}
        <Name value={name} onChange={setName} />
      </label>
      <label>
        {signIn.code}
        <Secret testId="sign-in-code" autocomplete="off" value={code} onChange={setCode} />
      </label>
    </SignInForm>
  );
}

function ByAccount({ access, onClose }: { access: Access; onClose(): void }) {
  const [name, setName] = useState(isSignedIn(access) ? "" : access.lastName);
  const [password, setPassword] = useState("");
  const { signIn, team } = texts;
  return (
    <SignInForm
      title={team.account.title}
      submit={signIn.submit}
      onSubmit={() => access.signInByAccount(name.trim(), password)}
      onClose={onClose}
      cancel={access.session?.role === "visitor" ? null : signIn.observe}
      onCancel={() => void access.signOut()}
      signedIn={access.session?.name ?? ""}
    >
      <label>
        {team.account.name}
        <Name value={name} onChange={setName} autocomplete="username" />
      </label>
      <label>
        {team.account.password}
        <Secret testId="sign-in-password" autocomplete="current-password" value={password} onChange={setPassword} />
      </label>
    </SignInForm>
  );
}

function Join({ access, onClose }: { access: Access; onClose(): void }) {
  const [name, setName] = useState("");
  const [password, setPassword] = useState("");
  const { account } = texts.team;
  return (
    <SignInForm
      title={account.join}
      submit={account.joinSubmit}
      onSubmit={() => access.join(name.trim(), password)}
      onClose={onClose}
      cancel={null}
      onCancel={() => undefined}
      signedIn=""
    >
      <p>{account.joinHint}</p>
      <label>
        {account.name}
        <Name value={name} onChange={setName} autocomplete="username" />
      </label>
      <label>
        {account.newPassword}
        <Secret testId="sign-in-password" autocomplete="new-password" value={password} onChange={setPassword} />
      </label>
    </SignInForm>
  );
}

interface FormProps {
  title: string;
  submit: string;
  /** Text of the button that goes on without signing in; null where that is no choice. */
  cancel: string | null;
  /** Called by that button where somebody is signed in. */
  onCancel(): void;
  /** Who is signed in; empty without anybody. */
  signedIn: string;
  onSubmit(): Promise<string | null>;
  onClose(): void;
  children: ComponentChildren;
}

const isSignedIn = ({ session }: Access): boolean => session !== null && session.name !== "";

function SignInForm({ title, submit, cancel, onCancel, signedIn, onSubmit, onClose, children }: FormProps) {
  const [refusal, setRefusal] = useState<string | null>(null);
  const send = async (event: Event): Promise<void> => {
    event.preventDefault();
    const reason = await onSubmit();
    setRefusal(reason);
    if (reason === null) onClose();
  };
  return (
    <Dialog title={title} testId="sign-in" onClose={onClose}>
      <form class="form" onSubmit={(event) => void send(event)}>
        {signedIn !== "" && <p data-testid="sign-in-until">{texts.signIn.until(signedIn)}</p>}
        {children}
        <p class="is-bad" role="alert" data-testid="sign-in-refusal">
          {refusal}
        </p>
        <div class="dialog-buttons">
          {cancel !== null && (
            <button
              type="button"
              data-testid="sign-in-cancel"
              onClick={() => {
                if (signedIn !== "") onCancel();
                onClose();
              }}
            >
              {cancel}
            </button>
          )}
          <button type="submit" class="primary" data-testid="sign-in-ok">
            {submit}
          </button>
        </div>
      </form>
    </Dialog>
  );
}

interface FieldProps {
  value: string;
  autocomplete?: string;
  onChange(value: string): void;
}

function Name({ value, autocomplete = "nickname", onChange }: FieldProps) {
  return (
    <input
      data-testid="sign-in-name"
      autocomplete={autocomplete}
      required
      maxLength={40}
      value={value}
      onInput={(event) => onChange(event.currentTarget.value)}
    />
  );
}

function Secret({ testId, value, autocomplete = "off", onChange }: FieldProps & { testId: string }) {
  return (
    <input
      data-testid={testId}
      type="password"
      autocomplete={autocomplete}
      required
      maxLength={200}
      value={value}
      onInput={(event) => onChange(event.currentTarget.value)}
    />
  );
}
