/** Words over the scene, as crisp as the rest of the page. */
import { type PerspectiveCamera, Vector3 } from "three";

/** A text, and the point of the world that it is written beside. */
export interface Label {
  readonly text: string;
  readonly at: Vector3;
}

/** Of a label [px]. */
const HEIGHT = 22;

export class Labels {
  readonly element = document.createElement("div");
  private readonly shown: HTMLSpanElement[] = [];
  private readonly point = new Vector3();

  constructor() {
    this.element.className = "scene-labels";
    this.element.ariaHidden = "true";
  }

  /** Write each text beside its point of the world, below those that it would cover. */
  update(labels: readonly Label[], camera: PerspectiveCamera): void {
    while (this.shown.length > labels.length) this.shown.pop()?.remove();
    const { clientWidth, clientHeight } = this.element;
    const taken: { x: number; y: number }[] = [];
    labels.forEach(({ text, at }, index) => {
      const span = this.shown[index] ?? this.element.appendChild(this.made(index));
      if (span.textContent !== text) span.textContent = text;
      this.point.copy(at).project(camera);
      span.hidden = this.point.z > 1;
      if (span.hidden) return;
      const x = ((this.point.x + 1) / 2) * clientWidth;
      let y = ((1 - this.point.y) / 2) * clientHeight;
      while (taken.some((one) => Math.hypot((one.x - x) / 4, one.y - y) < HEIGHT)) {
        y += 1;
      }
      taken.push({ x, y });
      span.style.transform = `translate(${x.toFixed(1)}px, ${y.toFixed(1)}px)`;
    });
  }

  private made(index: number): HTMLSpanElement {
    const span = document.createElement("span");
    this.shown[index] = span;
    return span;
  }
}
