/** Hook for open alerts; each new one is announced once. */
import { useEffect, useMemo, useRef } from "preact/hooks";
import { ranges } from "../format";
import { findingOfTrack } from "../state/findings";
import type { State } from "../state/state";
import { said, texts } from "../texts";
import { type Alert, openAlerts } from "../state/alerts";
import { spokenFinding } from "./finding_text";
import { announce, type Voice } from "./voice";

export function useAlerts({ notices, connection, mission }: State, isSilent: boolean, voice: Voice): readonly Alert[] {
  const acknowledgements = mission?.acknowledgements;
  const alerts = useMemo(() => openAlerts(notices, acknowledgements ?? []), [notices, acknowledgements]);
  const announcedUntil = useRef<number | null>(null);

  useEffect(() => {
    announcedUntil.current = null;
  }, [mission?.mission_id]);
  useEffect(() => {
    if (mission === null) return;
    // Events before this page was opened are shown, but not announced.
    const latest = notices.at(-1)?.notice_id ?? 0;
    const until = announcedUntil.current ?? latest;
    announcedUntil.current = latest;
    const worst = alerts.find((alert) => alert.id > until);
    if (worst === undefined) return;
    const finding = findingOfTrack(mission.findings, worst.trackId);
    announce(voice, worst.severity, finding === null ? alertText(worst) : spokenFinding(finding));
  }, [alerts]);
  useEffect(() => {
    if (connection === "lost") announce(voice, "critical", texts.alerts.connectionLost);
  }, [connection]);
  useEffect(() => {
    if (isSilent) announce(voice, "critical", texts.alerts.missionSilent);
  }, [isSilent]);

  return alerts;
}

/** Alert as one sentence. */
export function alertText({ vehicleIds, text: english }: Alert): string {
  const [first, ...others] = vehicleIds;
  const text = said(english);
  if (first === undefined) return text;
  return others.length === 0
    ? texts.alerts.vehicle(first, text)
    : texts.alerts.vehicles(vehicleIds.length, ranges(vehicleIds), text);
}
