/** Results of recent commands in a corner of other views: accepted ones disappear, refusals stay. */
import { texts } from "../texts";
import type { Commands, Report } from "./commands";
import { Reports } from "./reports";

const SHOWN_MS = 8000;

/** It is drawn anew as the page ages, so that nothing has to end by a timer of its own. */
export function Toast({ commands }: { commands: Commands }) {
  const isNew = ({ answeredAtMs }: Report): boolean => performance.now() - answeredAtMs < SHOWN_MS;
  const shown = commands.reports.filter((report) => !hasSucceeded(report) || isNew(report));
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
