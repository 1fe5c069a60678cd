/** View Plan: search area and no-go zones, search pattern, limits, and the resulting estimate. */
import { useId, useMemo, useRef, useState } from "preact/hooks";
import type { Place, Proposal } from "../../api/types";
import { lngLat, toEnu } from "../../geometry";
import { LayerSwitch, shownOf, useLayerChoice } from "../../map/layer_switch";
import { homesLayer } from "../../map/layers/homes";
import { proposalsLayer } from "../../map/layers/proposals";
import { MapPanel } from "../../map/panel";
import { useBaseLayers } from "../../map/use_base";
import { useShell } from "../../shell/context";
import { texts } from "../../texts";
import { Panel } from "../../ui/panel";
import { type Drawing, drawLayer } from "./draw_layer";
import { EstimatePanel } from "./estimate";
import { SavedPlans } from "./files";
import { DropZone, ImportDialog, ImportPicker, useImport } from "./import";
import { LimitFields, PatternFields } from "./numbers";
import "./plan.css";
import { ProfilePanel } from "./profile";
import { ProposalsPanel } from "./proposals";
import { ShapeList, shapeTitle } from "./shape_list";
import { placesOf, removed, type ShapeName, shapeNames, withNoGo, withPlaces } from "./shapes";
import { usePlan } from "./use_plan";
import { useUndoKeys } from "./use_undo_keys";
import { VertexTable } from "./vertex_table";

export function PlanView() {
  const { state, mayCommand } = useShell();
  const editor = usePlan();
  useUndoKeys(editor, mayCommand);
  const files = useImport();
  const form = useId();
  const [wanted, setShape] = useState<ShapeName>("area");
  const [vertex, setVertex] = useState<number | null>(null);
  const [isDrawing, setDrawing] = useState(false);
  const [leg, setLeg] = useState(0);
  const { plan, report } = editor;
  const origin = state.mission?.origin ?? null;
  const shape = plan && shapeNames(plan).includes(wanted) ? wanted : "area";
  const places = plan === null ? [] : placesOf(plan, shape);
  const changePlaces = (changed: readonly Place[]): void => {
    if (plan) editor.change(withPlaces(plan, shape, changed));
  };
  const choose = (chosen: ShapeName, isEmpty = plan !== null && placesOf(plan, chosen).length === 0): void => {
    setShape(chosen);
    setVertex(null);
    setDrawing(isEmpty && mayCommand); // an empty shape can only be drawn
  };

  const actions = {
    onPlaces: (changed: readonly Place[], moved: number) => {
      changePlaces(changed);
      setVertex(moved);
    },
    onVertex: setVertex,
    onShape: (chosen: ShapeName) => choose(chosen),
    onFinish: () => setDrawing(false),
  };
  const fence = report?.fence ?? NO_FENCE;
  const drawing: Drawing | null = plan && {
    plan,
    legs: report?.estimate?.legs ?? NO_LEGS,
    leg,
    fence,
    shape,
    vertex,
    isDrawing: isDrawing && mayCommand,
    isEditable: mayCommand,
  };
  // The layer is made once and reads the current drawing.
  const current = useRef({ drawing, actions });
  current.current = { drawing, actions };
  const base = useBaseLayers();
  const [layerChoice, setLayerChoice] = useLayerChoice();
  const layers = useMemo(() => {
    const draft = drawLayer(() => current.current.drawing, {
      onPlaces: (changed, moved) => current.current.actions.onPlaces(changed, moved),
      onVertex: (chosen) => current.current.actions.onVertex(chosen),
      onShape: (chosen) => current.current.actions.onShape(chosen),
      onFinish: () => current.current.actions.onFinish(),
    });
    return [...base, homesLayer, proposalsLayer, draft];
  }, [base]);

  const extent = useMemo(() => {
    if (plan === null || origin === null) return [];
    const drawn = shapeNames(plan).flatMap((name) => placesOf(plan, name));
    return [...drawn, ...fence].map((place) => toEnu(origin, lngLat(place)));
  }, [plan, fence, origin]);

  if (plan === null) {
    return (
      <>
        <MapPanel layers={layers} />
        <Panel title={texts.plan.panel} testId="plan" class="plan-side">
          <p class="empty" data-testid="plan-message">
            {editor.failure ?? texts.waiting}
          </p>
        </Panel>
      </>
    );
  }
  return (
    <>
      <div class="plan-map">
        <DropZone onFile={(file) => mayCommand && files.read(file)}>
          <MapPanel layers={shownOf(layers, layerChoice)} extent={extent}>
            <LayerSwitch layers={base} choice={layerChoice} hasPicture={false} onChange={setLayerChoice} />
            {mayCommand && (
              <button
                type="button"
                data-testid="draw"
                aria-pressed={isDrawing}
                class={isDrawing ? "primary" : ""}
                onClick={() => setDrawing(!isDrawing)}
              >
                {isDrawing ? texts.plan.drawn : texts.plan.draw(shapeTitle(shape))}
              </button>
            )}
            {mayCommand && vertex !== null && vertex < places.length && (
              <button
                type="button"
                data-testid="draw-remove"
                onClick={() => {
                  setVertex(null);
                  changePlaces(removed(places, vertex));
                }}
              >
                {texts.plan.removeCorner(vertex + 1)}
              </button>
            )}
            {isDrawing && <p class="map-hint">{texts.plan.drawHint}</p>}
          </MapPanel>
        </DropZone>
        <ProfilePanel report={report} leg={leg} isChecking={editor.isChecking} onLeg={setLeg} />
      </div>
      <div class="plan-side">
        <form id={form} class="scroll plan-form" onSubmit={(event) => event.preventDefault()}>
          <ProposalsPanel
            proposals={state.mission?.proposals ?? NO_PROPOSALS}
            mayDecide={mayCommand}
            onPlan={editor.edit}
          />
          <Panel title={texts.plan.shapes} testId="plan-shapes">
            <ShapeList
              plan={plan}
              report={report}
              chosen={shape}
              onChoose={choose}
              onAddNoGo={() => {
                editor.change(withNoGo(plan));
                choose(`no_go[${plan.no_go.length}]`, true);
              }}
            />
            <VertexTable
              plan={plan}
              shape={shape}
              origin={origin}
              vertex={vertex}
              mayChange={mayCommand}
              onVertex={setVertex}
              onPlaces={changePlaces}
              onPlan={editor.change}
            />
            {mayCommand && <ImportPicker files={files} />}
          </Panel>
          <Panel title={texts.plan.pattern} testId="plan-pattern">
            <fieldset disabled={!mayCommand}>
              <PatternFields plan={plan} report={report} onChange={editor.change} />
            </fieldset>
          </Panel>
          <Panel title={texts.plan.limits} testId="plan-limits">
            <fieldset disabled={!mayCommand}>
              <LimitFields plan={plan} report={report} onChange={editor.change} />
            </fieldset>
          </Panel>
          {mayCommand && (
            <Panel title={texts.plan.savedPlans} testId="plan-files">
              <SavedPlans plan={plan} onLoad={editor.change} />
            </Panel>
          )}
        </form>
        <EstimatePanel editor={editor} form={form} />
      </div>
      {files.shapes && <ImportDialog plan={plan} shapes={files.shapes} onTake={editor.change} onClose={files.forget} />}
    </>
  );
}

const NO_LEGS: Drawing["legs"] = [];
const NO_FENCE: Drawing["fence"] = [];
const NO_PROPOSALS: readonly Proposal[] = [];
