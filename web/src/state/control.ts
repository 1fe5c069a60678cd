/** Rules about who has control, as an operator sees it. */
import type { Control } from "../api/types";

export interface ControlView {
  /** Operator who has control, if that is not this one; null while nobody has. */
  readonly other: string | null;
  readonly isMine: boolean;
  /** Whether the other one is gone, so that control can be taken without a reason. */
  readonly isFree: boolean;
  /** Operator who asks this one for control. */
  readonly asking: string | null;
  readonly haveAsked: boolean;
}

/** What an operator has to know; null where they are alone, or nobody signs in. */
export function controlView(control: Control | null, own: string): ControlView | null {
  if (control === null || own === "") return null;
  const { holder, holder_present, operators, requests } = control;
  const others = operators.filter((name) => name !== own);
  const isOthers = holder !== null && holder !== own;
  if (others.length === 0 && !isOthers) return null;
  const isMine = holder === own;
  return {
    other: isOthers ? holder : null,
    isMine,
    isFree: !isMine && !holder_present,
    asking: isMine ? (requests.find((name) => name !== own) ?? null) : null,
    haveAsked: requests.includes(own),
  };
}
