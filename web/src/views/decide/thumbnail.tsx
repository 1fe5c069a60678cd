/** Image of a finding. The station makes a few images at a time; a refused one is requested again. */
import { useEffect, useState } from "preact/hooks";
import { thumbnailUrl } from "../../api/findings";
import type { Finding } from "../../api/types";
import { useShell } from "../../shell/context";
import { texts } from "../../texts";

const TRIES = 2;
const TRY_AGAIN_AFTER_MS = 1500;

interface Props {
  finding: Finding;
  kind: "integral" | "thermal";
  /** Makes the image a button. */
  onEnlarge?(): void;
}

export function Thumbnail({ finding, kind, onEnlarge }: Props) {
  const { capabilities } = useShell().state;
  const url = thumbnailUrl(finding, kind);
  const [tried, setTried] = useState({ url, times: 0, isWaiting: false });
  const { times, isWaiting } = tried.url === url ? tried : { times: 0, isWaiting: false };
  useEffect(() => {
    if (!isWaiting || times >= TRIES) return undefined;
    const timer = setTimeout(() => setTried({ url, times, isWaiting: false }), TRY_AGAIN_AFTER_MS);
    return () => clearTimeout(timer);
  }, [url, times, isWaiting]);
  if (isWaiting || finding.step < 1 || !capabilities.viewer)
    return <span class="thumbnail is-empty">{texts.decide.noPicture}</span>;
  const image = (
    <img
      class="thumbnail"
      loading="lazy"
      src={url}
      alt={texts.decide.pictureOf(kind, finding.finding_id)}
      onError={() => setTried({ url, times: times + 1, isWaiting: true })}
    />
  );
  if (onEnlarge === undefined) return image;
  return (
    <button
      type="button"
      class="thumbnail-button"
      title={texts.decide.enlarge}
      data-testid={`enlarge-${kind}`}
      onClick={onEnlarge}
    >
      {image}
    </button>
  );
}
