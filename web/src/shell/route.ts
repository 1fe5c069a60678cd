/** Where the operator is on the page: a view and its parameters, kept in the URL's hash. Pure functions. */

export const VIEW_NAMES = ["plan", "prepare", "fly", "see", "understand", "decide"] as const;
export type ViewName = (typeof VIEW_NAMES)[number];

export interface Route {
  readonly view: ViewName;
  /** For example the finding that Decide shows; each view names its own. */
  readonly params: Readonly<Record<string, string>>;
}

const DEFAULT_VIEW: ViewName = "fly";
const PREFIX = "#/";

const isViewName = (name: string): name is ViewName => (VIEW_NAMES as readonly string[]).includes(name);

/** Read a hash such as `#/decide?finding=3`; anything unknown leads to the default view. */
export function parseRoute(hash: string): Route {
  const [path = "", query = ""] = hash.slice(PREFIX.length).split("?", 2);
  if (!hash.startsWith(PREFIX) || !isViewName(path)) return { view: DEFAULT_VIEW, params: {} };
  return { view: path, params: Object.fromEntries(new URLSearchParams(query)) };
}

/** The hash of a route, the inverse of {@link parseRoute}. */
export function routeHash(view: ViewName, params: Route["params"] = {}): string {
  const query = new URLSearchParams(params).toString();
  return `${PREFIX}${view}${query === "" ? "" : `?${query}`}`;
}
