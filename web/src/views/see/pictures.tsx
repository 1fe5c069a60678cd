/** The latest picture of a kind. */
import { useState } from "preact/hooks";
import type { PictureKind } from "../../api/types";
import type { State } from "../../state/state";
import { texts } from "../../texts";
import { Choice } from "../../ui/choice";
import { Panel } from "../../ui/panel";

const KINDS = Object.keys(texts.pictures.kind) as PictureKind[];

export function PicturePanel({ pictures }: { pictures: State["pictures"] }) {
  const [kind, setKind] = useState<PictureKind>("integral");
  const picture = pictures[kind];
  const choice = (
    <Choice
      label={texts.pictures.panel}
      testId="picture"
      values={KINDS}
      chosen={kind}
      words={texts.pictures.kind}
      onChoose={setKind}
    />
  );
  return (
    <Panel title={texts.pictures.panel} testId="pictures" class="pictures" aside={choice}>
      <div class="picture-frame">
        {picture ? (
          <>
            <img
              src={picture.url}
              alt={texts.pictures.alt(kind, picture.step)}
              data-testid="picture"
              data-step={picture.step}
            />
            <span class="picture-foot">{texts.pictures.step(picture.step)}</span>
          </>
        ) : (
          <p class="empty">{texts.pictures.none}</p>
        )}
      </div>
    </Panel>
  );
}
