/** One tile that fills the screen, for the briefing room. */
import { useContext, useEffect, useRef } from "preact/hooks";
import { useShell } from "../../shell/context";
import { texts } from "../../texts";
import { DialogCorner } from "../../ui/dialog";
import { TilePicture } from "./tile";
import { type Tile, titleOf } from "./tiles";
import { useWall } from "./use_wall";

interface Props {
  tile: Tile;
  rate_hz: number | null;
  onClose(): void;
}

export function Follow({ tile, rate_hz, onClose }: Props) {
  const { notation } = useShell();
  const dialog = useRef<HTMLDialogElement>(null);
  const stage = useRef<HTMLDivElement>(null);
  const corner = useContext(DialogCorner);
  const wall = useWall([tile.name], true, rate_hz);
  useEffect(() => {
    const [element, filled] = [dialog.current, stage.current];
    element?.showModal();
    // Refused where the page was opened at this tile, without a click: it then fills the window.
    filled?.requestFullscreen?.().catch(() => undefined);
    return () => {
      if (document.fullscreenElement === filled) void document.exitFullscreen().catch(() => undefined);
      element?.close();
    };
  }, []);
  return (
    <dialog ref={dialog} class="wall-follow" data-testid="follow" aria-label={titleOf(tile)} onClose={onClose}>
      <div ref={stage} class="wall-stage">
        <TilePicture {...{ tile, wall, notation }} isLarge />
        <div class="wall-stage-buttons">
          <button type="button" data-testid="follow-close" onClick={onClose}>
            {texts.wall.close}
          </button>
          {corner}
        </div>
      </div>
    </dialog>
  );
}
