/** Hook for the role of this screen: an operator, who has signed in with the code of the station, or an observer. */
import { useEffect, useRef, useState } from "preact/hooks";
import { readSession, signIn, signOut } from "../api/client";
import { untilAnswered } from "../api/persistence";
import type { Connection } from "../api/socket";
import type { Session } from "../api/types";

const NAME_KEY = "aos-gcs-operator";
const CODE_PREFIX = "#code=";

export interface Access {
  /** Null until the station has sent it. */
  readonly session: Session | null;
  /** Whether the sign-in of an operator has expired. */
  readonly isExpired: boolean;
  /** Code from the address that the station has printed for operators; empty without it. */
  readonly code: string;
  /** Name that was used last on this screen. */
  readonly lastName: string;
  /** Resolves to the reason of a refusal, or null. */
  signIn(code: string, name: string): Promise<string | null>;
  signOut(): Promise<void>;
  /** Read the role again, until the station answers. */
  refresh(): void;
}

/** Take the operator code out of the address, so that neither the address bar nor the history keeps it. */
function takeCode(): string {
  if (!location.hash.startsWith(CODE_PREFIX)) return "";
  const code = decodeURIComponent(location.hash.slice(CODE_PREFIX.length));
  history.replaceState(null, "", location.pathname);
  return code;
}

/** The role of this screen; `onChange` is called after each sign-in and sign-out. */
export function useSession(connection: Connection, onChange: () => void): Access {
  const [session, setSession] = useState<Session | null>(null);
  const [isExpired, setExpired] = useState(false);
  const [code, setCode] = useState(takeCode);
  // A newer reading, a sign-in or a sign-out makes the answers of earlier readings worthless.
  const readings = useRef(0);
  const supersede = (): number => (readings.current += 1);
  const refresh = (): void => {
    const own = supersede();
    void untilAnswered(readSession, () => readings.current === own).then((found) => {
      if (found === null) return;
      if (session?.role === "operator") setExpired(found.role === "observer");
      setSession(found);
    });
  };
  // A restarted station may have forgotten its operators.
  useEffect(() => {
    if (connection === "open") refresh();
    return () => void supersede();
  }, [connection]);
  return {
    session,
    isExpired,
    code,
    lastName: localStorage.getItem(NAME_KEY) ?? "",
    async signIn(given, name) {
      const answer = await signIn(given, name);
      if (!answer.ok) return answer.message;
      supersede();
      localStorage.setItem(NAME_KEY, name);
      setCode("");
      setExpired(false);
      setSession(answer.value);
      onChange();
      return null;
    },
    async signOut() {
      const answer = await signOut();
      if (!answer.ok) return;
      supersede();
      setSession(answer.value);
      onChange();
    },
    refresh,
  };
}
