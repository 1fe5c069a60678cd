/** The latest integral, thermal or anomaly image, small and enlarged. */
import { useState } from "preact/hooks";
import type { PictureKind } from "../api/types";
import type { State } from "../state/state";
import { texts } from "../texts";
import { Dialog } from "./dialog";

const KINDS: readonly PictureKind[] = ["integral", "thermal", "anomaly"];

export function PicturePanel({ pictures }: { pictures: State["pictures"] }) {
  const [kind, setKind] = useState<PictureKind>("integral");
  const [isLarge, setLarge] = useState(false);
  const picture = pictures[kind];
  const image = picture && (
    <img
      src={picture.url}
      alt={texts.pictures.alt(kind, picture.step)}
      data-testid="picture"
      data-step={picture.step}
    />
  );
  const choices = (
    <div class="tabs" role="group" aria-label={texts.pictures.panel}>
      {KINDS.map((one) => (
        <button
          key={one}
          type="button"
          data-testid={`picture-${one}`}
          aria-pressed={one === kind}
          onClick={() => setKind(one)}
        >
          {texts.pictures.kind[one]}
        </button>
      ))}
    </div>
  );
  return (
    <section class="pictures panel" aria-label={texts.pictures.panel} data-testid="pictures">
      <div class="panel-head">{choices}</div>
      <div class="picture-frame">
        {image ?? <p class="empty">{texts.pictures.none}</p>}
        {picture && (
          <div class="picture-foot">
            <span>{texts.pictures.step(picture.step)}</span>
            <button type="button" data-testid="picture-enlarge" onClick={() => setLarge(true)}>
              {texts.pictures.enlarge}
            </button>
          </div>
        )}
      </div>
      {isLarge && (
        <Dialog title={texts.pictures.panel} testId="picture-dialog" onClose={() => setLarge(false)}>
          <div class="panel-head">
            {choices}
            <button type="button" data-testid="picture-close" onClick={() => setLarge(false)}>
              {texts.pictures.close}
            </button>
          </div>
          <div class="picture-frame is-large">{image}</div>
        </Dialog>
      )}
    </section>
  );
}
