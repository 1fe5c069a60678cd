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
  const announcedUntil = useRef<number | null>(null);

  useEffect(() => {
    setAcknowledged(NOTHING);
    announcedUntil.current = null;
  }, [mission?.mission_id]);
  useEffect(() => {
    if (mission === null) return;
    // What happened before this page was opened is shown, but not announced any more.
    const latest = notices.at(-1)?.id ?? 0;
    const until = announcedUntil.current ?? latest;
    announcedUntil.current = latest;
    const worst = alerts.find((alert) => alert.id > until);
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
