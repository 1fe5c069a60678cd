/** Tabs of the views; they are links, so that they work by keyboard and can be opened on another screen. */
import { texts } from "../texts";
import { VIEW_KEYS } from "./keys";
import { isViewOfSurveys, routeHash, VIEW_NAMES, type ViewName } from "./route";

export function Nav({ current, isSurvey }: { current: ViewName; isSurvey: boolean }) {
  return (
    <nav class="nav" aria-label={texts.nav.label}>
      {VIEW_NAMES.filter((view) => !isSurvey || isViewOfSurveys(view)).map((view) => {
        const key = VIEW_KEYS[view].toUpperCase();
        return (
          <a
            key={view}
            href={routeHash(view)}
            class="tab"
            aria-current={view === current ? "page" : undefined}
            aria-keyshortcuts={key}
            title={texts.nav.key(key)}
            data-testid={`view-${view}`}
          >
            {texts.nav.view[view]}
            <kbd aria-hidden="true">{key}</kbd>
          </a>
        );
      })}
    </nav>
  );
}
