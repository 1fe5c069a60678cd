/** Images of a finding; pressing one opens both in a window, as large as the screen allows. */
import { useState } from "preact/hooks";
import type { Finding } from "../../api/types";
import { texts } from "../../texts";
import { Dialog } from "../../ui/dialog";
import { Thumbnail } from "./thumbnail";

const KINDS = ["integral", "thermal"] as const;

export function FindingPictures({ finding }: { finding: Finding }) {
  const [isLarge, setLarge] = useState(false);
  return (
    <>
      {KINDS.map((kind) => (
        <Thumbnail key={kind} finding={finding} kind={kind} onEnlarge={() => setLarge(true)} />
      ))}
      {isLarge && (
        <Dialog title={texts.decide.finding(finding.finding_id)} testId="finding-large" onClose={() => setLarge(false)}>
          <div class="large-pictures">
            {KINDS.map((kind) => (
              <figure key={kind}>
                <Thumbnail finding={finding} kind={kind} />
                <figcaption>{texts.decide.caption(kind)}</figcaption>
              </figure>
            ))}
          </div>
        </Dialog>
      )}
    </>
  );
}
