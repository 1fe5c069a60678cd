/** Open alerts in a component: each is announced once, when it comes. */
import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import type { State } from "../state/state";
import { texts } from "../texts";
import { acknowledge, type Acknowledged, type Alert, openAlerts } from "../state/alerts";
import { announce, type Voice } from "./voice";

const NOTHING: Acknowledged = new Map();

export function useAlerts(
  { notices, connection, mission }: State,
  voice: Voice,
): [readonly Alert[], (alerts: readonly Alert[]) => void] {
  const [acknowledged, setAcknowledged] = useState(NOTHING);
  const alerts = useMemo(() => openAlerts(notices, acknowledged), [notices, acknowledged]);
  const announcedUntil_s = useRef<number | null>(null);

  useEffect(() => {
    setAcknowledged(NOTHING);
    announcedUntil_s.current = null;
  }, [mission?.mission_id]);
  useEffect(() => {
    if (mission === null) return;
    // What happened before this page was opened is shown, but not announced any more.
    const until_s = announcedUntil_s.current ?? mission.elapsed_s;
    const worst = alerts.find((alert) => alert.elapsed_s > until_s);
    announcedUntil_s.current = Math.max(until_s, ...notices.map((notice) => notice.elapsed_s));
    if (worst !== undefined) announce(voice, worst.severity, sentence(worst));
  }, [alerts]);
  useEffect(() => {
    if (connection === "lost") announce(voice, "critical", texts.alerts.connectionLost);
  }, [connection]);

  return [alerts, (those) => setAcknowledged((before) => acknowledge(before, those))];
}

/** An alert in words. */
export function sentence({ vehicleId, text }: Alert): string {
  return vehicleId === null ? text : `${texts.alerts.vehicle(vehicleId)}: ${text}`;
}
