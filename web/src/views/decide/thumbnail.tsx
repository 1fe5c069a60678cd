/** Image of a finding. The station makes a few images at a time; a refused one is requested again. */
import { useEffect, useState } from "preact/hooks";
import { type Shot, thumbnailUrl } from "../../api/findings";
import type { Finding } from "../../api/types";
import { useShell } from "../../shell/context";
import { texts } from "../../texts";

const TRIES = 3;
const TRY_AGAIN_AFTER_MS = 1500;

interface Props {
  finding: Finding;
  shot: Shot;
}

export function Thumbnail({ finding, shot }: Props) {
  const { capabilities } = useShell().state;
  const url = thumbnailUrl(finding, shot);
  const [tried, setTried] = useState({ url, times: 0, isWaiting: false });
  const { times, isWaiting } = tried.url === url ? tried : { times: 0, isWaiting: false };
  useEffect(() => {
    if (!isWaiting || times >= TRIES) return undefined;
    const timer = setTimeout(() => setTried({ url, times, isWaiting: false }), TRY_AGAIN_AFTER_MS);
    return () => clearTimeout(timer);
  }, [url, times, isWaiting]);
  if (isWaiting || finding.step < 1 || !capabilities.viewer)
    return <span class="thumbnail is-empty">{texts.decide.noPicture}</span>;
  return (
    <img
      class="thumbnail"
      loading="lazy"
      src={url}
      alt={texts.decide.pictureOf(shot.kind, finding.finding_id)}
      onError={() => setTried({ url, times: times + 1, isWaiting: true })}
    />
  );
}
