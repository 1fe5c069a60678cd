/** German translations of what the station says, by what it is about. */
import type { StationText } from "../../station";
import { access } from "./access";
import { checks } from "./checks";
import { commands } from "./commands";
import { files } from "./files";
import { flight } from "./flight";
import { mission } from "./mission";
import { plans } from "./plans";
import { refusals } from "./refusals";
import { search } from "./search";
import { sharing } from "./sharing";
import { values } from "./values";
import { vehicles } from "./vehicles";

export const station: readonly StationText[] = [
  ...access,
  ...checks,
  ...commands,
  ...files,
  ...flight,
  ...mission,
  ...plans,
  ...refusals,
  ...search,
  ...sharing,
  ...values,
  ...vehicles,
];
