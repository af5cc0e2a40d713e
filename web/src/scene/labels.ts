/** Words over the scene, as crisp as the rest of the page. */
import { type PerspectiveCamera, Vector3 } from "three";

export class Labels {
  readonly element = document.createElement("div");
  private readonly shown: HTMLSpanElement[] = [];
  private readonly point = new Vector3();

  constructor() {
    this.element.className = "scene-labels";
    this.element.ariaHidden = "true";
  }

  /** Write each text beside its point of the world. */
  update(
    labels: readonly { text: string; at: Vector3 }[],
    camera: PerspectiveCamera,
  ): void {
    while (this.shown.length > labels.length) this.shown.pop()?.remove();
    const { clientWidth, clientHeight } = this.element;
    labels.forEach(({ text, at }, index) => {
      const span = this.shown[index] ?? this.element.appendChild(this.made(index));
      if (span.textContent !== text) span.textContent = text;
      this.point.copy(at).project(camera);
      span.hidden = this.point.z > 1;
      const x = ((this.point.x + 1) / 2) * clientWidth;
      const y = ((1 - this.point.y) / 2) * clientHeight;
      span.style.transform = `translate(${x.toFixed(1)}px, ${y.toFixed(1)}px)`;
    });
  }

  private made(index: number): HTMLSpanElement {
    const span = document.createElement("span");
    this.shown[index] = span;
    return span;
  }
}
