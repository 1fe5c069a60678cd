/** Current view and its parameters, kept in the hash of the URL. */

export const VIEW_NAMES = ["plan", "prepare", "fly", "see", "wall", "understand", "decide"] as const;
export type ViewName = (typeof VIEW_NAMES)[number];

export interface Route {
  readonly view: ViewName;
  /** Parameters of the view, for example the selected finding of Decide. */
  readonly params: Readonly<Record<string, string>>;
}

const DEFAULT_VIEW: ViewName = "fly";
const DEFAULT_VIEW_OF_SURVEYS: ViewName = "decide";
const PREFIX = "#/";

const isViewName = (name: string): name is ViewName => (VIEW_NAMES as readonly string[]).includes(name);

/** Parse a hash such as `#/decide?finding=3`; an unknown one leads to the default view. */
export function parseRoute(hash: string): Route {
  const [path = "", query = ""] = hash.slice(PREFIX.length).split("?", 2);
  if (!hash.startsWith(PREFIX) || !isViewName(path)) return { view: DEFAULT_VIEW, params: {} };
  return { view: path, params: Object.fromEntries(new URLSearchParams(query)) };
}

/** Open a view where the address names none, in place of the default one. */
export function openUnnamed(view: ViewName): void {
  if (!location.hash.startsWith(PREFIX)) location.replace(routeHash(view));
}

/** Whether a view has something to show without vehicles. */
export const isViewOfSurveys = (view: ViewName): boolean => view === "see" || view === "decide";

/** Route of a survey: views of vehicles lead to its default view. */
export const surveyRoute = (route: Route): Route =>
  isViewOfSurveys(route.view) ? route : { view: DEFAULT_VIEW_OF_SURVEYS, params: {} };

/** Hash of a route, the inverse of {@link parseRoute}. */
export function routeHash(view: ViewName, params: Route["params"] = {}): string {
  const query = new URLSearchParams(params).toString();
  return `${PREFIX}${view}${query === "" ? "" : `?${query}`}`;
}
