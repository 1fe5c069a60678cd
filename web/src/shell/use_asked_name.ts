/**
 * Hook for the name of whoever has opened the operators' address on a screen that knows no name yet: the code came with
 * the address, so leaving the field of the name signs in.
 */
import { useState } from "preact/hooks";
import { texts } from "../texts";
import type { Access } from "./use_session";

export interface AskedName {
  readonly typed: string;
  /** Name that would be signed in; empty while nothing is typed. */
  readonly name: string;
  /** Why the station, or the page, has not accepted the name; empty otherwise. */
  readonly refusal: string;
  type(text: string): void;
  /** Sign in by what is typed. A name on its way, or one refused and not changed since, is not sent again. */
  leave(): void;
  /** Sign in by what is typed, also once more; an empty name is refused. */
  submit(): void;
}

/** The name that is asked for, or null where somebody is signed in, or has to sign in otherwise. */
export function useAskedName(access: Access): AskedName | null {
  const [isFirstVisit] = useState(access.code !== "" && access.lastName === "");
  const [typed, setTyped] = useState("");
  const [refusal, setRefusal] = useState("");
  const [isSending, setSending] = useState(false);
  const { session } = access;
  // While the role is unknown the name can be typed and sent, too.
  const isNeeded = session === null || (session.sign_in_required && !session.accounts && session.name === "");
  if (!isFirstVisit || access.code === "" || access.invitation !== "" || !isNeeded) return null;
  const name = typed.trim();
  const send = async (): Promise<void> => {
    setSending(true);
    setRefusal((await access.signIn(access.code, name)) ?? "");
    setSending(false);
  };
  return {
    typed,
    name,
    refusal,
    type(text) {
      // What is on its way stays what is shown.
      if (isSending) return;
      setTyped(text);
      setRefusal("");
    },
    leave() {
      if (name !== "" && refusal === "" && !isSending) void send();
    },
    submit() {
      if (name === "") setRefusal(texts.signIn.nameMissing);
      else if (!isSending) void send();
    },
  };
}
