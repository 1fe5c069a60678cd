/** Results of recent commands in a corner of other views: accepted ones disappear, refusals stay. */
import { useEffect, useState } from "preact/hooks";
import { texts } from "../texts";
import type { Commands, Report } from "./commands";
import { Reports } from "./reports";

const SHOWN_MS = 8000;

export function Toast({ commands }: { commands: Commands }) {
  const [readUpTo, setReadUpTo] = useState(0);
  const [newest] = commands.reports;
  const doneId = newest !== undefined && hasSucceeded(newest) ? newest.id : 0;
  useEffect(() => {
    if (doneId === 0) return undefined;
    const timer = setTimeout(() => setReadUpTo(doneId), SHOWN_MS);
    return () => clearTimeout(timer);
  }, [doneId]);
  const shown = commands.reports.filter((report) => report.id > readUpTo || !hasSucceeded(report));
  if (shown.length === 0) return null;
  return (
    <aside class="toast" aria-label={texts.actions.results}>
      <Reports reports={shown} isBrief />
      <button type="button" data-testid="reports-dismiss" onClick={commands.dismissReports}>
        {texts.actions.dismiss}
      </button>
    </aside>
  );
}

/** Whether every vehicle has accepted the command. */
function hasSucceeded({ answer }: Report): boolean {
  return answer !== null && answer.ok && answer.value.results.every((result) => result.accepted);
}
