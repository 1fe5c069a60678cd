/** Commands under way: the open confirmation, and the results of recent commands. */
import { useEffect, useRef, useState } from "preact/hooks";
import { type ActionAnswer, postAction } from "../api/client";
import type { Action, Mission } from "../api/types";
import { needsConfirmation, type Command, makeCommand } from "../state/commands";
import type { Selection } from "../state/selection";

const REPORTS_KEPT = 3;
const FORBIDDEN = 403;

export interface Report {
  readonly id: number;
  readonly label: string;
  /** Null while the answer is pending. */
  readonly answer: ActionAnswer | null;
}

export interface Commands {
  /** Newest first. */
  readonly reports: readonly Report[];
  /** Command that waits for the operator's confirmation. */
  readonly question: Command | null;
  /** Request an action for the selected vehicles, or for all; dangerous ones ask for confirmation first. */
  request(action: Action): void;
  /** Ask for confirmation of a command before it is sent. */
  ask(command: Command): void;
  confirm(): void;
  cancel(): void;
  /** Hold all vehicles, whatever is selected, open or in progress. */
  holdAll(): void;
  dismissReports(): void;
}

/** `onForbidden` is called when the station refuses commands from this page. */
export function useCommands(mission: Mission | null, selection: Selection, onForbidden: () => void): Commands {
  const [question, setQuestion] = useState<Command | null>(null);
  const [reports, setReports] = useState<readonly Report[]>([]);
  const nextId = useRef(1);
  // Commands of one mission have no meaning for another.
  useEffect(() => {
    setQuestion(null);
    setReports([]);
  }, [mission?.mission_id]);

  const send = async (command: Command): Promise<void> => {
    const id = nextId.current++;
    setReports((before) => [{ id, label: command.label, answer: null }, ...before].slice(0, REPORTS_KEPT));
    const answer = await postAction(command);
    if (!answer.ok && answer.status === FORBIDDEN) onForbidden();
    setReports((before) => before.map((report) => (report.id === id ? { ...report, answer } : report)));
  };
  return {
    reports,
    question,
    request(action) {
      const command = makeCommand(action, mission, selection.ids);
      if (needsConfirmation(action)) setQuestion(command);
      else void send(command);
    },
    ask: setQuestion,
    confirm() {
      setQuestion(null);
      if (question !== null) void send(question);
    },
    cancel: () => setQuestion(null),
    holdAll() {
      setQuestion(null);
      void send(makeCommand("hold", mission, new Set()));
    },
    dismissReports: () => setReports([]),
  };
}
