/** Heading on a compass rose, set by pointer or by the arrow keys. */
import { useRef } from "preact/hooks";
import { quantity } from "../../format";
import { texts } from "../../texts";

const KEY_STEP_DEG: Readonly<Record<string, number>> = {
  ArrowRight: 1,
  ArrowUp: 1,
  ArrowLeft: -1,
  ArrowDown: -1,
  PageUp: 15,
  PageDown: -15,
};
/** Resolution by pointer, which cannot set single degrees. */
const POINTER_STEP_DEG = 5;

const turned = (heading_deg: number): number => ((Math.round(heading_deg) % 360) + 360) % 360;

interface Props {
  heading_deg: number;
  onChange(heading_deg: number): void;
}

export function Dial({ heading_deg, onChange }: Props) {
  const rose = useRef<SVGSVGElement>(null);
  const follow = (event: PointerEvent): void => {
    const box = rose.current?.getBoundingClientRect();
    if (box === undefined || event.buttons === 0) return;
    const [right, up] = [event.clientX - box.x - box.width / 2, box.y + box.height / 2 - event.clientY];
    const pointed_deg = (Math.atan2(right, up) * 180) / Math.PI;
    onChange(turned(POINTER_STEP_DEG * Math.round(pointed_deg / POINTER_STEP_DEG)));
  };
  return (
    <svg
      ref={rose}
      class="dial"
      viewBox="-50 -50 100 100"
      role="slider"
      tabIndex={0}
      data-testid="plan-dial"
      aria-label={texts.plan.field.scan_heading_deg}
      aria-valuemin={0}
      aria-valuemax={359}
      aria-valuenow={Math.round(heading_deg)}
      aria-valuetext={quantity(heading_deg, 0, "°")}
      onPointerDown={(event) => {
        event.currentTarget.setPointerCapture(event.pointerId);
        follow(event);
      }}
      onPointerMove={follow}
      onKeyDown={(event) => {
        const step_deg = KEY_STEP_DEG[event.key];
        if (step_deg === undefined) return;
        event.preventDefault();
        onChange(turned(heading_deg + step_deg));
      }}
    >
      <circle r="46" />
      {[0, 90, 180, 270].map((deg) => (
        <line key={deg} y1="-46" y2="-38" transform={`rotate(${deg})`} />
      ))}
      <text y="-24">{texts.plan.north}</text>
      <g transform={`rotate(${heading_deg})`}>
        <line class="needle" y1="36" y2="-30" />
        <path class="needle" d="M0 -40 L7 -24 L-7 -24 Z" />
      </g>
    </svg>
  );
}
