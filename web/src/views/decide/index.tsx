/** View Decide: findings, their positions, and the operators' decisions. */
import { useMemo, useRef, useState } from "preact/hooks";
import { addFinding, FINDING_FILES, findingsFileUrl, NETWORK_LINK_URL } from "../../api/findings";
import type { Place } from "../../api/types";
import { enu } from "../../map/geojson";
import { LayerSwitch, shownOf, useLayerChoice } from "../../map/layer_switch";
import { areaLayer } from "../../map/layers/area";
import { pictureLayer } from "../../map/layers/picture";
import { MapPanel } from "../../map/panel";
import { useBaseLayers } from "../../map/use_base";
import { useShell } from "../../shell/context";
import { texts } from "../../texts";
import { Choice } from "../../ui/choice";
import { Panel } from "../../ui/panel";
import "./decide.css";
import { FindingDetail } from "./detail";
import { type Filter, FILTERS, listed } from "./findings";
import { findingsLayer, markLayer } from "./findings_layer";
import { HandoverButtons } from "./handover";
import { FindingList } from "./list";
import { MarkForm } from "./mark_form";
import { Report } from "./report";
import { storedReference, storeReference, type Reference } from "./way";

/** What the next click on the map sets. */
type Pointer = "finding" | "reference";

const OVERLAY = { kind: "integral", opacity: 1 } as const;

export function DecideView() {
  const { state, route, navigate, mayJudge: mayMark } = useShell();
  const [filter, setFilter] = useState<Filter>("all");
  const [pointer, setPointer] = useState<Pointer | null>(null);
  const [reference, setReference] = useState(storedReference);
  const [refusal, setRefusal] = useState<string | null>(null);
  const findings = state.mission?.findings ?? [];
  const chosen = findings.find(({ finding_id: id }) => String(id) === route.params["finding"]) ?? null;
  const choose = (id: number): void => navigate("decide", { finding: String(id) });
  const add = async (place: Place): Promise<void> => {
    const answer = await addFinding(place, "");
    setRefusal(answer.ok ? null : answer.message);
    if (answer.ok) choose(answer.value.finding_id);
  };

  const changeReference = (place: Reference): void => {
    storeReference(place);
    setReference(place);
  };
  const point = (place: Place): void => {
    setPointer(null);
    if (pointer === "reference") changeReference(place);
    else void add(place);
  };
  const toggle = (wanted: Pointer): void => setPointer(pointer === wanted ? null : wanted);

  // The layers are made once and read the current values.
  const current = useRef({ chosen, pointer, point });
  current.current = { chosen, pointer, point };
  const base = useBaseLayers();
  const [layerChoice, setLayerChoice] = useLayerChoice();
  const layers = useMemo(() => {
    const shown = findingsLayer(() => current.current.chosen?.finding_id ?? null, choose);
    const mark = markLayer(
      () => current.current.pointer !== null,
      (place) => current.current.point(place),
    );
    return [pictureLayer, areaLayer, shown, mark];
  }, []);

  if (route.params["report"] !== undefined && state.mission !== null) {
    return <Report mission={state.mission} onClose={() => navigate("decide")} />;
  }
  return (
    <>
      <div class={`finding-side ${chosen === null ? "" : "has-chosen"}`}>
        <Panel
          title={texts.decide.panel}
          testId="findings"
          class="findings"
          aside={
            <Choice
              label={texts.decide.filter}
              testId="filter"
              values={FILTERS}
              chosen={filter}
              labels={texts.decide.filters}
              onChoose={setFilter}
            />
          }
        >
          <FindingList
            findings={listed(findings, filter)}
            filter={filter}
            chosen={chosen?.finding_id ?? null}
            onChoose={choose}
          />
          {mayMark && <MarkForm onPlace={(place) => void add(place)} />}
          <p class="is-bad" role="alert" data-testid="mark-refusal">
            {refusal}
          </p>
          <div class="button-row finding-files">
            <button type="button" data-testid="report-open" onClick={() => navigate("decide", { report: "1" })}>
              {texts.report.open}
            </button>
            {FINDING_FILES.map((suffix) => (
              <a key={suffix} class="button" href={findingsFileUrl(suffix)} download data-testid={`file-${suffix}`}>
                {texts.decide.file[suffix]}
              </a>
            ))}
            <a
              class="button"
              href={NETWORK_LINK_URL}
              download
              title={texts.decide.networkLinkHint}
              data-testid="file-network-link"
            >
              {texts.decide.networkLink}
            </a>
          </div>
          <HandoverButtons />
        </Panel>
      </div>
      {chosen && (
        <FindingDetail
          finding={chosen}
          reference={reference}
          isSettingReference={pointer === "reference"}
          onReference={changeReference}
          onSetReferenceOnMap={() => toggle("reference")}
          onClose={() => navigate("decide")}
        />
      )}
      <MapPanel
        layers={[...shownOf(base, layerChoice), ...layers]}
        overlay={OVERLAY}
        lookAt={chosen && enu(chosen.position)}
      >
        <LayerSwitch layers={base} choice={layerChoice} hasPicture={false} onChange={setLayerChoice} />
        {mayMark && (
          <button
            type="button"
            data-testid="mark"
            class={pointer === "finding" ? "primary" : ""}
            aria-pressed={pointer === "finding"}
            onClick={() => toggle("finding")}
          >
            {pointer === "finding" ? texts.decide.marking : texts.decide.mark}
          </button>
        )}
      </MapPanel>
    </>
  );
}
