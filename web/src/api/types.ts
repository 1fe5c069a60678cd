/** Short names for the generated wire types. */
import type { components } from "./schema";

type Schemas = components["schemas"];

export type ServerMessage = Schemas["ServerMessage"];
export type Changes = Schemas["ChangesMessage"];
export type Mission = Schemas["MissionModel"];
export type Vehicle = Schemas["VehicleModel"];
export type Position = Schemas["PositionModel"];
export type Vertex = Schemas["VertexModel"];
export type Geodetic = Schemas["GeodeticModel"];
export type Target = Schemas["TargetModel"];
export type Step = Schemas["StepModel"];
export type Notice = Schemas["NoticeModel"];
export type Picture = Schemas["PictureModel"];
export type PictureKind = Schemas["PictureKind"];
export type PreflightCheck = Schemas["PreflightCheckModel"];
export type Action = Schemas["Action"];
export type ActionResponse = Schemas["ActionResponse"];
export type ErrorBody = Schemas["ErrorModel"];
export type Severity = Schemas["Severity"];
export type Phase = Schemas["Phase"];
export type Session = Schemas["SessionModel"];
export type CheckStatus = Schemas["CheckStatus"];
export type MissedEvents = Schemas["MissedEventsModel"];
export type Basemap = Schemas["BasemapModel"];
