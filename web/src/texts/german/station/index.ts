/** German translations of what the station says, by what it is about. */
import type { StationText } from "../../station";
import { access } from "./access";
import { cameras } from "./cameras";
import { checks } from "./checks";
import { commands } from "./commands";
import { connections } from "./connections";
import { files } from "./files";
import { flight } from "./flight";
import { mission } from "./mission";
import { pictures } from "./pictures";
import { plans } from "./plans";
import { records } from "./records";
import { refusals } from "./refusals";
import { search } from "./search";
import { sharing } from "./sharing";
import { values } from "./values";
import { vehicles } from "./vehicles";

export const station: readonly StationText[] = [
  ...access,
  ...cameras,
  ...checks,
  ...commands,
  ...connections,
  ...files,
  ...flight,
  ...mission,
  ...pictures,
  ...plans,
  ...records,
  ...refusals,
  ...search,
  ...sharing,
  ...values,
  ...vehicles,
];
