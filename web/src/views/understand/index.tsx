/** Understand: how visible the target is, and what the swarm makes of it. */
import { useShell } from "../../shell/context";
import { ChartPanel } from "./chart";
import "./understand.css";

export function UnderstandView() {
  const { state, theme } = useShell();
  return <ChartPanel steps={state.steps} theme={theme} />;
}
