/** All frames of a step side by side; one of them can be enlarged. */
import { useState } from "preact/hooks";
import type { FrameKind, ViewedFrame } from "../../api/types";
import { frameUrl } from "../../api/viewer";
import { eastNorth, quantity } from "../../format";
import { texts } from "../../texts";
import { Choice } from "../../ui/choice";
import { Dialog } from "../../ui/dialog";

const THUMBNAIL_PX = 320;
const frameKinds = (): FrameKind[] => Object.keys(texts.names.frame) as FrameKind[];

interface Props {
  missionId: string;
  step: number;
  frames: readonly ViewedFrame[];
}

export function Mosaic({ missionId, step, frames }: Props) {
  const [chosen, setChosen] = useState<FrameKind>("colour");
  const [enlargedId, setEnlargedId] = useState<number | null>(null);
  // A camera of one kind shows that, whatever was chosen for others.
  const offered = frameKinds().filter((one) => frames.some(({ kinds }) => kinds.includes(one)));
  const kind = offered.includes(chosen) ? chosen : (offered[0] ?? chosen);
  const shown = frames.filter((frame) => frame.kinds.includes(kind));
  const enlarged = shown.find((frame) => frame.vehicle_id === enlargedId);
  return (
    <div class="mosaic" data-testid="mosaic">
      <Choice
        label={texts.see.frameKinds}
        testId="frame-kind"
        values={frameKinds()}
        chosen={kind}
        labels={texts.names.frame}
        onChoose={setChosen}
      />
      {shown.length === 0 && <p class="empty">{texts.see.noFrames}</p>}
      <ul>
        {shown.map(({ vehicle_id: id, name }) => (
          <li key={id}>
            <button type="button" data-testid={`frame-${id}`} onClick={() => setEnlargedId(id)}>
              <img
                src={frameUrl({ missionId, step, vehicleId: id, kind }, THUMBNAIL_PX)}
                alt={titleOf(id, name, step, kind)}
                loading="lazy"
              />
              <span>{name === "" ? id : name}</span>
            </button>
          </li>
        ))}
      </ul>
      {enlarged && (
        <Dialog
          title={titleOf(enlarged.vehicle_id, enlarged.name, step, kind)}
          testId="frame-large"
          onClose={() => setEnlargedId(null)}
        >
          <img class="frame-large" src={frameUrl({ missionId, step, vehicleId: enlarged.vehicle_id, kind })} alt="" />
          <p class="small">{placeOf(enlarged)}</p>
          <div class="dialog-buttons">
            <button type="button" onClick={() => setEnlargedId(null)}>
              {texts.see.close}
            </button>
          </div>
        </Dialog>
      )}
    </div>
  );
}

/** Title of a frame: in a survey by the name of its picture. */
const titleOf = (id: number, name: string, step: number, kind: FrameKind): string =>
  name === "" ? texts.see.frame(id, step, texts.names.frame[kind]) : name;

function placeOf({ position_enu_m: [east_m, north_m, up_m], width_px, height_px }: ViewedFrame): string {
  return `${eastNorth(east_m, north_m)}, ${texts.see.up(quantity(up_m, 1, "m"))}; ${width_px} × ${height_px} px`;
}
