/** Makes a video of the wall on the station, shows how far it is, and hands it out. */
import { useEffect, useRef, useState } from "preact/hooks";
import { beginVideo, giveUpVideo, type Video, VIDEO_URL } from "../../api/video";
import { duration, likelihood, quantity } from "../../format";
import { useShell } from "../../shell/context";
import { texts } from "../../texts";
import { useVideo } from "./use_video";

const BYTES_PER_MB = 1e6;

interface Props {
  /** Tiles of the video; none: all of the record. */
  tiles: readonly string[];
}

export function VideoPanel({ tiles }: Props) {
  const { state, notation, mayMakeVideos } = useShell();
  const { video, problem, take } = useVideo();
  const link = useRef<HTMLAnchorElement>(null);
  const [wanted, setWanted] = useState<number | null>(null);
  const isReady = video?.phase === "ready";
  // The page that has asked for it downloads it by itself, also where it was ready before the answer; others have the link.
  useEffect(() => {
    if (!isReady || video.number !== wanted) return;
    setWanted(null);
    link.current?.click();
  }, [isReady, video?.number, wanted]);
  if (video === null) return null;
  const begin = async (): Promise<void> => {
    const answer = await beginVideo(tiles, notation);
    if (answer.ok) setWanted(answer.value.number);
    take(answer);
  };
  const { wall } = texts;
  const isMaking = video.phase === "making";
  if (!mayMakeVideos && !isMaking && !isReady) return null;
  return (
    <section class="wall-video" data-testid="wall-video" data-phase={video.phase}>
      <h3>{wall.video}</h3>
      {isMaking && (
        <p>
          <label>
            {wall.making(likelihood(video.done))}
            <progress max={1} value={video.done} data-testid="video-progress" />
          </label>
        </p>
      )}
      {isReady && (
        <p>
          <a
            ref={link}
            class="button"
            href={VIDEO_URL}
            download={`wall-${state.mission?.mission_id ?? "mission"}.mp4`}
            data-testid="video-download"
          >
            {wall.download}
          </a>{" "}
          <span class="small">{sizeText(video)}</span>
        </p>
      )}
      {isReady && video.unreadable > 0 && <p class="small">{wall.unreadable(video.unreadable)}</p>}
      {mayMakeVideos && (
        <div class="button-row">
          {isMaking ? (
            <button type="button" data-testid="video-cancel" onClick={() => void giveUpVideo().then(take)}>
              {wall.giveUp}
            </button>
          ) : (
            <button type="button" data-testid="video-make" onClick={() => void begin()}>
              {wall.make}
            </button>
          )}
        </div>
      )}
      {mayMakeVideos && !isMaking && <p class="small">{wall.makeHint}</p>}
      <p class="is-bad" role="alert" data-testid="video-problem">
        {problem}
      </p>
    </section>
  );
}

const sizeText = ({ duration_s, bytes }: Video): string =>
  `${duration(duration_s)}, ${quantity(bytes / BYTES_PER_MB, bytes < 10 * BYTES_PER_MB ? 1 : 0, "MB")}`;
