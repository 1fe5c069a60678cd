/** The chosen view, as soon as it has been loaded. */
import { texts } from "../texts";
import { usePart } from "../ui/part";
import type { ViewName } from "./route";
import { VIEWS } from "./views";

export function LoadedView({ name }: { name: ViewName }) {
  const View = usePart(VIEWS[name]);
  return View === null ? <p class="empty">{texts.nav.loading}</p> : <View />;
}
