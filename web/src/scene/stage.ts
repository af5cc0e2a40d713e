/** What the robot stands on and is seen by: renderer, light, ground, camera, frames, labels. */
import {
  type Mesh,
  NeutralToneMapping,
  NoToneMapping,
  Scene,
  WebGLRenderer,
} from "three";
import { Axes } from "./axes";
import { CameraRig } from "./camera";
import { ContactShadow } from "./contact";
import { Ground } from "./ground";
import { type Label, Labels } from "./labels";
import { Lighting } from "./lighting";
import { token } from "../ui/theme";
import type { Quality } from "./quality";

/** Without a GPU, a picture that has stood still for so long is drawn finely [ms]. */
const STILL_MS = 250;
/** Pixels to a CSS pixel of what moves without a GPU: fewer where frames come too slowly. */
const COARSE = [1, 0.75, 0.5] as const;
/** Between two drawings of what moves, this is too slow [ms]. */
const SLOW_MS = 45;
/** After so many of them more than quick ones, it is drawn with fewer pixels. */
const PATIENCE = 8;

export interface Colours {
  grid: string;
  ghost: string;
  highlight: string;
  collision: string;
  force: string;
  contact: string;
  x: string;
  y: string;
  z: string;
  dark: boolean;
}

export class Stage {
  readonly scene = new Scene();
  readonly axes = new Axes();
  readonly labels = new Labels();
  readonly rig: CameraRig;
  /** Labels besides those of the frames. */
  moreLabels: () => readonly Label[] = () => [];
  /** Pictures drawn so far. */
  drawn = 0;
  private readonly renderer: WebGLRenderer;
  private readonly lighting: Lighting;
  private readonly ground: Ground;
  private readonly contact: ContactShadow | undefined;
  private size = { width: 1, height: 1 };
  private refinement: ReturnType<typeof setTimeout> | undefined;
  /** Which of `COARSE`. */
  private coarseness = 0;
  private nSlow = 0;
  private drawnAt = -Infinity;

  /**
   * @param ground its height [m], or null for none
   * @param changed called when it should be drawn anew
   */
  constructor(
    canvas: HTMLCanvasElement,
    ground: number | null,
    private readonly quality: Quality,
    private readonly changed: () => void,
  ) {
    const high = quality === "high";
    this.renderer = new WebGLRenderer({
      canvas,
      // without a GPU it would halve the frames; there what stands still is refined
      antialias: high,
      alpha: true,
      powerPreference: "high-performance",
    });
    this.renderer.toneMapping = high ? NeutralToneMapping : NoToneMapping;
    this.renderer.shadowMap.enabled = high;
    this.renderer.shadowMap.autoUpdate = false;
    this.lighting = new Lighting(this.scene, this.renderer, quality);
    this.ground = new Ground(quality, ground !== null);
    this.ground.root.position.z = ground ?? 0;
    if (ground !== null) {
      this.contact = new ContactShadow(ground, quality);
      this.scene.add(this.contact.root);
    }
    this.scene.add(this.ground.root, this.axes.root);
    this.rig = new CameraRig(canvas, ground, changed);
  }

  resize(width: number, height: number): void {
    this.size = { width, height };
    this.sharpen(this.quality === "high" ? Math.min(2, window.devicePixelRatio) : 1);
    this.rig.resize(width / height);
    this.changed();
  }

  paint(colours: Colours): void {
    this.ground.paint({ ...colours, line: colours.grid });
    this.contact?.paint(colours.dark);
    this.axes.paint([colours.x, colours.y, colours.z]);
    this.changed();
  }

  /** What throws shadows moved. */
  castAnew(): void {
    this.renderer.shadowMap.needsUpdate = true;
    if (this.contact) this.contact.needsUpdate = true;
    this.changed();
  }

  draw(): void {
    if (this.quality === "low") this.coarsen();
    this.render();
  }

  /** Choose how finely to draw what moves, and refine it when it stands still. */
  private coarsen(): void {
    const now = performance.now();
    const gap = now - this.drawnAt;
    this.drawnAt = now;
    if (gap < STILL_MS) this.nSlow = Math.max(0, this.nSlow + (gap > SLOW_MS ? 1 : -1));
    if (this.nSlow > PATIENCE && this.coarseness < COARSE.length - 1) {
      this.coarseness += 1;
      this.nSlow = 0;
    }
    const ratio = COARSE[this.coarseness] ?? 1;
    if (this.renderer.getPixelRatio() !== ratio) this.sharpen(ratio);
    clearTimeout(this.refinement);
    this.refinement = setTimeout(() => {
      this.coarseness = Math.max(0, this.coarseness - 1);
      this.sharpen(2);
      this.render(true);
    }, STILL_MS);
  }

  /** Return what is seen as a PNG, on the background of the page. */
  async picture(): Promise<Blob> {
    const ratio = this.renderer.getPixelRatio();
    this.sharpen(2);
    this.render();
    const source = this.renderer.domElement;
    const canvas = document.createElement("canvas");
    [canvas.width, canvas.height] = [source.width, source.height];
    const context = canvas.getContext("2d");
    if (context) {
      const sky = context.createLinearGradient(0, 0, 0, canvas.height);
      sky.addColorStop(0, token("--scene-top"));
      sky.addColorStop(1, token("--scene-bottom"));
      context.fillStyle = sky;
      context.fillRect(0, 0, canvas.width, canvas.height);
      context.drawImage(source, 0, 0);
    }
    this.sharpen(ratio);
    this.changed();
    return new Promise((resolve, reject) => {
      canvas.toBlob((blob) => {
        if (blob) resolve(blob);
        else reject(new Error("the browser made no picture"));
      }, "image/png");
    });
  }

  dispose(): void {
    clearTimeout(this.refinement);
    this.rig.dispose();
    this.scene.traverse((object) => {
      if ("geometry" in object) (object as Mesh).geometry.dispose();
    });
    this.axes.dispose();
    this.ground.dispose();
    this.contact?.dispose();
    this.lighting.dispose();
    this.renderer.dispose();
  }

  /** Draw so many pixels to a CSS pixel. */
  private sharpen(ratio: number): void {
    this.renderer.setPixelRatio(ratio);
    this.renderer.setSize(this.size.width, this.size.height, false);
  }

  /** @param isStill whether nothing will move soon, as far as is known */
  private render(isStill = false): void {
    this.axes.update(this.rig.camera);
    this.contact?.update(this.renderer, this.scene, isStill);
    this.renderer.render(this.scene, this.rig.camera);
    this.labels.update([...this.axes.labels, ...this.moreLabels()], this.rig.camera);
    this.drawn += 1;
  }
}
