/** Commands under way: the open confirmation, and the results of recent commands. */
import { useEffect, useRef, useState } from "preact/hooks";
import { type ActionAnswer, postAction } from "../api/client";
import { type HoldStream, holdAll } from "../api/hold";
import type { Action, Mission } from "../api/types";
import { needsConfirmation, type Command, makeCommand } from "../state/commands";
import type { Selection } from "../state/selection";
import { texts } from "../texts";

const REPORTS_KEPT = 3;
/** Time after which a command without an answer is reported as not confirmed. */
const CONFIRMED_WITHIN_MS = 2000;
const FORBIDDEN = 403;

export interface Report {
  readonly id: number;
  readonly label: string;
  /** Null while the answer is pending. */
  readonly answer: ActionAnswer | null;
  /** Time of the answer, by the clock of the page; 0 while it is pending. */
  readonly answeredAtMs: number;
  /** Whether the answer has been pending for so long that the operator must not rely on it. */
  readonly isOverdue: boolean;
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
  /** Launch; the operator has confirmed that already. */
  launch(): void;
  /** Hold all vehicles, whatever is selected, open or in progress. */
  holdAll(): void;
  dismissReports(): void;
}

const notSent = (): ActionAnswer => ({ ok: false, message: texts.requests.disconnected });

interface Page {
  readonly mission: Mission | null;
  readonly selection: Selection;
  readonly isConnected: boolean;
  /** Way of holds beside their requests. */
  readonly stream: HoldStream;
  /** Called when the station refuses commands from this page. */
  onForbidden(): void;
  /** Called when the station prepares another sortie for this page. */
  onNewSortie(): void;
  /** Called when the mission has been launched from this page. */
  onLaunched(): void;
}

export function useCommands(page: Page): Commands {
  const { mission, selection, isConnected, stream, onForbidden, onNewSortie, onLaunched } = page;
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
    const change = (changes: Partial<Report>): void =>
      setReports((before) => before.map((report) => (report.id === id ? { ...report, ...changes } : report)));
    const report: Report = { id, label: command.label, answer: null, answeredAtMs: 0, isOverdue: false };
    setReports((before) => [report, ...before].slice(0, REPORTS_KEPT));
    // A hold is sent whatever the connection seems to be like; anything else would arrive when it is not expected.
    const mayArrive = isConnected || command.action === "hold";
    const overdue = setTimeout(() => change({ isOverdue: true }), CONFIRMED_WITHIN_MS);
    const isHoldOfAll = command.action === "hold" && command.vehicleIds === null;
    const sent = (): Promise<ActionAnswer> => (isHoldOfAll ? holdAll(stream) : postAction(command));
    const answer = mayArrive ? await sent() : notSent();
    clearTimeout(overdue);
    if (!answer.ok && answer.status === FORBIDDEN) onForbidden();
    change({ answer, answeredAtMs: performance.now() });
    if (answer.ok && command.action === "new_sortie") onNewSortie();
    if (answer.ok && command.action === "start") onLaunched();
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
    launch: () => void send(makeCommand("start", mission, new Set())),
    holdAll() {
      setQuestion(null);
      void send(makeCommand("hold", mission, new Set()));
    },
    dismissReports: () => setReports([]),
  };
}
