/** See: what the swarm sees through the canopy. */
import { useShell } from "../../shell/context";
import { PicturePanel } from "./pictures";
import "./see.css";

export function SeeView() {
  const { state } = useShell();
  return <PicturePanel pictures={state.pictures} />;
}
