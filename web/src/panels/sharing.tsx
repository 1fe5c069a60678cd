/** Live sharing: which systems of others receive, which do not and why. */
import type { Mission } from "../api/types";
import { timeOfDay } from "../format";
import { said, texts } from "../texts";
import { Panel } from "../ui/panel";

type Channel = Mission["sharing"][number];

export function SharingPanel({ channels }: { channels: readonly Channel[] }) {
  if (channels.length === 0) return null;
  return (
    <Panel title={texts.sharing.panel} testId="sharing" class="sharing">
      {channels.map((channel) => (
        <p key={channel.name} data-testid={`sharing-${channel.name}`} title={channel.target}>
          <strong>{channel.name}</strong> <span class={isTrouble(channel) ? "is-bad" : ""}>{said(channel.text)}.</span>{" "}
          {sentText(channel)}
        </p>
      ))}
    </Panel>
  );
}

const isTrouble = ({ state }: Channel): boolean => state === "failed" || state === "refused";

/** When the latest message was sent, how many were given up, and how many of others could not be used. */
export function sentText(channel: Pick<Channel, "sent_utc_s" | "lost" | "refused" | "refused_text">): string {
  const { sent_utc_s, lost, refused, refused_text } = channel;
  const parts = sent_utc_s === null ? [] : [texts.sharing.sentAt(timeOfDay(sent_utc_s))];
  if (lost > 0) parts.push(texts.sharing.lost(lost));
  if (refused > 0) parts.push(texts.sharing.refused(refused, refused_text));
  return parts.join(" ");
}
