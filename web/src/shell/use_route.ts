/** Hook for the current route; the back button of the browser works. */
import { useEffect, useState } from "preact/hooks";
import { parseRoute, type Route, surveyRoute } from "./route";

export function useRoute(isSurvey: boolean): Route {
  const [route, setRoute] = useState(() => parseRoute(location.hash));
  useEffect(() => {
    const follow = (): void => setRoute(parseRoute(location.hash));
    window.addEventListener("hashchange", follow);
    return () => window.removeEventListener("hashchange", follow);
  }, []);
  return isSurvey ? surveyRoute(route) : route;
}
