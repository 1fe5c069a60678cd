/** Keeps the failure of a view inside the view: the header with HOLD ALL continues to work. */
import { Component, type ComponentChildren } from "preact";
import { texts } from "../texts";

export class Boundary extends Component<{ children: ComponentChildren }, { hasFailed: boolean }> {
  override state = { hasFailed: false };

  static override getDerivedStateFromError(): { hasFailed: boolean } {
    return { hasFailed: true };
  }

  override componentDidCatch(error: unknown): void {
    console.error(error);
  }

  override render() {
    if (!this.state.hasFailed) return this.props.children;
    return (
      <p class="empty is-bad" role="alert" data-testid="view-error">
        {texts.nav.broken}
      </p>
    );
  }
}
