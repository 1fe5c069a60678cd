/**
 * Images of a finding in colour and thermal, side by side: of all cameras or of the nearest one, on a focal plane chosen
 * from a strip. Pressing one opens them in a window, as large as the screen allows.
 */
import { useState } from "preact/hooks";
import type { Shot } from "../../api/findings";
import type { Finding } from "../../api/types";
import { quantity } from "../../format";
import { texts } from "../../texts";
import { Choice } from "../../ui/choice";
import { Dialog } from "../../ui/dialog";
import { Thumbnail } from "./thumbnail";

const KINDS = ["integral", "thermal"] as const;
const SOURCES = ["all", "nearest"] as const;
type Source = (typeof SOURCES)[number];

/** Heights of the focal planes above the finding: on it, a standing person, and the canopy above. */
const PLANES_M = [0, 2, 5, 10, 15] as const;

export function FindingPictures({ finding }: { finding: Finding }) {
  const [isLarge, setLarge] = useState(false);
  const [source, setSource] = useState<Source>("all");
  const [above_m, setAbove] = useState<number>(PLANES_M[0]);
  const isNearest = source === "nearest";
  const controls = (testId: string) => (
    <div class="picture-controls">
      <Choice
        label={texts.decide.cameras}
        testId={`${testId}cameras`}
        values={SOURCES}
        chosen={source}
        labels={texts.decide.sources}
        onChoose={setSource}
      />
    </div>
  );
  const shots = KINDS.map((kind): Shot => ({ kind, above_m, isNearest }));
  return (
    <div class="finding-pictures">
      <div class="main-pictures">
        {shots.map((shot) => (
          <button
            key={shot.kind}
            type="button"
            class="thumbnail-button"
            title={texts.decide.enlarge}
            data-testid={`enlarge-${shot.kind}`}
            onClick={() => setLarge(true)}
          >
            <Thumbnail finding={finding} shot={shot} />
            <span class="small">{texts.decide.caption(shot.kind)}</span>
          </button>
        ))}
      </div>
      {controls("")}
      <Planes finding={finding} chosen_m={above_m} isNearest={isNearest} onChoose={setAbove} />
      {isLarge && (
        <Dialog title={texts.decide.finding(finding.finding_id)} testId="finding-large" onClose={() => setLarge(false)}>
          <div class="large-pictures">
            {shots.map((shot) => (
              <figure key={shot.kind}>
                <Thumbnail finding={finding} shot={shot} />
                <figcaption>{texts.decide.caption(shot.kind)}</figcaption>
              </figure>
            ))}
          </div>
          {controls("large-")}
        </Dialog>
      )}
    </div>
  );
}

interface PlanesProps {
  finding: Finding;
  chosen_m: number;
  isNearest: boolean;
  onChoose(above_m: number): void;
}

/** Strip of the focal stack: what stands out on one plane only is there; what is on all of them is in the canopy. */
function Planes({ finding, chosen_m, isNearest, onChoose }: PlanesProps) {
  // Thermal images tell more, where there are temperatures.
  const kind = finding.person_confidence === null ? "integral" : "thermal";
  return (
    <div class="planes" role="group" aria-label={texts.decide.planes} data-testid="planes">
      {PLANES_M.map((above_m) => (
        <button
          key={above_m}
          type="button"
          class="thumbnail-button"
          aria-pressed={above_m === chosen_m}
          data-testid={`plane-${above_m}`}
          onClick={() => onChoose(above_m)}
        >
          <Thumbnail finding={finding} shot={{ kind, above_m, isNearest }} />
          <span class="small">{above_m === 0 ? texts.decide.onGround : `+${quantity(above_m, 0, "m")}`}</span>
        </button>
      ))}
    </div>
  );
}
