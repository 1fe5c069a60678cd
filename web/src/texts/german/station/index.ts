/** German translations of what the station says, by what it is about. */
import type { StationText } from "../../station";
import { checks } from "./checks";
import { commands } from "./commands";
import { flight } from "./flight";
import { mission } from "./mission";
import { search } from "./search";

export const station: readonly StationText[] = [...checks, ...commands, ...flight, ...mission, ...search];
