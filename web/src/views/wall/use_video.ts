/** Follows the video that the station makes, whoever has asked for it. */
import { useEffect, useState } from "preact/hooks";
import type { Answer } from "../../api/client";
import { readVideo, type Video } from "../../api/video";
import { said } from "../../texts";

const INTERVAL_MS = 1000;
/** The same while nothing is being made: somebody else may begin. */
const IDLE_INTERVAL_MS = 10_000;

interface Followed {
  /** Null until the station has told. */
  readonly video: Video | null;
  /** Why there is no video, or why the latest request was refused; empty otherwise. */
  readonly problem: string;
  /** Take the answer to a request. */
  take(answer: Answer<Video>): void;
}

export function useVideo(): Followed {
  const [video, setVideo] = useState<Video | null>(null);
  const [refusal, setRefusal] = useState("");
  const take = (answer: Answer<Video>): void => {
    setRefusal(answer.ok ? "" : answer.message);
    if (answer.ok) setVideo(answer.value);
  };
  const isMaking = video?.phase === "making";
  useEffect(() => {
    let isGone = false;
    const look = async (): Promise<void> => {
      const answer = await readVideo();
      // Without an answer the next look follows all the same: links come back.
      if (!isGone && answer.ok) setVideo(answer.value);
    };
    if (!isMaking) void look();
    const timer = setInterval(() => void look(), isMaking ? INTERVAL_MS : IDLE_INTERVAL_MS);
    return () => {
      isGone = true;
      clearInterval(timer);
    };
  }, [isMaking]);
  const reason = video?.phase === "failed" ? said(video.reason) : "";
  return { video, problem: refusal || reason, take };
}
