/** Hook for the role of this screen: by the operator code of the station, or by an account. */
import { useEffect, useRef, useState } from "preact/hooks";
import { type Answer, joinByInvitation, readSession, signIn, signInByAccount, signOut } from "../api/client";
import { untilAnswered } from "../api/persistence";
import type { Connection } from "../api/socket";
import type { Session } from "../api/types";
import { readStored, store } from "../storage";

const NAME_KEY = "aos-gcs-operator";
const CODE_PREFIX = "#code=";
const INVITATION_PREFIX = "#invite=";

export interface Access {
  /** Null until the station has sent it. */
  readonly session: Session | null;
  /** Whether the sign-in of an operator has expired. */
  readonly isExpired: boolean;
  /** Code from the address that the station has printed for operators; empty without it. */
  readonly code: string;
  /** Invitation from the address that was sent to a person; empty without it. */
  readonly invitation: string;
  /** Name that was used last on this screen. */
  readonly lastName: string;
  /** Resolves to the reason of a refusal, or null. */
  signIn(code: string, name: string): Promise<string | null>;
  /** Sign in who used this screen last, by the code of the address, which stays for somebody else at the same screen. */
  signInAgain(): Promise<string | null>;
  signInByAccount(name: string, password: string): Promise<string | null>;
  /** Make an account by the invitation, and sign in with it. */
  join(name: string, password: string): Promise<string | null>;
  signOut(): Promise<void>;
  /** Read the role again, until the station answers. */
  refresh(): void;
}

/** Take a secret out of the address, so that neither the address bar nor the history keeps it. */
function takeSecret(prefix: string): string {
  if (!location.hash.startsWith(prefix)) return "";
  const secret = decodeURIComponent(location.hash.slice(prefix.length));
  history.replaceState(null, "", location.pathname);
  return secret;
}

/** The role of this screen; `onChange` is called after each sign-in and sign-out. */
export function useSession(connection: Connection, onChange: () => void): Access {
  const [session, setSession] = useState<Session | null>(null);
  const [isExpired, setExpired] = useState(false);
  const [code, setCode] = useState(() => takeSecret(CODE_PREFIX));
  const [invitation, setInvitation] = useState(() => takeSecret(INVITATION_PREFIX));
  // A newer reading, a sign-in or a sign-out makes the answers of earlier readings worthless.
  const readings = useRef(0);
  const supersede = (): number => (readings.current += 1);
  const refresh = (): void => {
    const own = supersede();
    void untilAnswered(readSession, () => readings.current === own).then((found) => {
      if (found === null) return;
      if (session !== null && session.name !== "") setExpired(found.name === "");
      setSession(found);
    });
  };
  // A restarted station may have forgotten its operators.
  useEffect(() => {
    // The station refuses the stream to those who have to sign in first: that looks like a lost connection.
    if (connection === "open" || connection === "lost") refresh();
    return () => void supersede();
  }, [connection]);
  const take = (answer: Answer<Session>, name: string): string | null => {
    if (!answer.ok) return answer.message;
    supersede();
    store(NAME_KEY, name);
    setInvitation("");
    setExpired(false);
    setSession(answer.value);
    onChange();
    return null;
  };
  const lastName = readStored(NAME_KEY) ?? "";
  /** Take the answer to what somebody has typed: a code of the address is not needed any more. */
  const takeTyped = (answer: Answer<Session>, name: string): string | null => {
    if (answer.ok) setCode("");
    return take(answer, name);
  };
  return {
    session,
    isExpired,
    code,
    invitation,
    lastName,
    async signIn(given, name) {
      return takeTyped(await signIn(given, name), name);
    },
    async signInAgain() {
      return take(await signIn(code, lastName), lastName);
    },
    async signInByAccount(name, password) {
      return takeTyped(await signInByAccount(name, password), name);
    },
    async join(name, password) {
      return takeTyped(await joinByInvitation(invitation, name, password), name);
    },
    async signOut() {
      const answer = await signOut();
      if (!answer.ok) return;
      supersede();
      setCode("");
      setSession(answer.value);
      onChange();
    },
    refresh,
  };
}
