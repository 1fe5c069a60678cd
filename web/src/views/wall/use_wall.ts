/** Hook: the live pictures of the tiles that a view watches, for as long as it is visible. */
import { useEffect, useRef, useState } from "preact/hooks";
import { NOTHING, WallSocket, type WallState, wallUrl } from "../../api/wall";

export function useWall(tiles: readonly string[], large: boolean, rate_hz: number | null): WallState {
  const [state, setState] = useState(NOTHING);
  const [isHidden, setHidden] = useState(document.hidden);
  const socket = useRef<WallSocket | null>(null);
  const watched = isHidden ? [] : tiles;
  useEffect(() => {
    const follow = (): void => setHidden(document.hidden);
    document.addEventListener("visibilitychange", follow);
    socket.current = new WallSocket(wallUrl(), { tiles: watched, large, rate_hz }, setState);
    return () => {
      document.removeEventListener("visibilitychange", follow);
      socket.current?.close();
      socket.current = null;
    };
  }, []);
  useEffect(() => socket.current?.choose({ tiles: watched, large, rate_hz }), [watched.join(), large, rate_hz]);
  return state;
}
