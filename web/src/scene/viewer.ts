/** The scene on its canvas: what the page calls. */
import {
  type Box3,
  type Mesh,
  NeutralToneMapping,
  type Object3D,
  Scene,
  Vector3,
  WebGLRenderer,
} from "three";
import type { Frame, Hello } from "../protocol";
import { Axes } from "./axes";
import { CameraRig } from "./camera";
import { CollisionLook } from "./collision";
import { ContactShadow } from "./contact";
import { directionOf, toolDirection, type View } from "./framing";
import { Ghost } from "./ghost";
import { goalOf } from "./goal";
import { Ground } from "./ground";
import { Interpolator, type Pose } from "./interpolation";
import { Labels } from "./labels";
import { Lighting } from "./lighting";
import { Loop } from "./loop";
import { Materials } from "./materials";
import { Meshes } from "./meshes";
import { Objects } from "./objects";
import { type Hit, Picker } from "./picker";
import type { Quality } from "./quality";
import { Robot } from "./robot";

/** What moved by less than this since it was drawn is not drawn again [rad | m]: a tenth of a pixel. */
const UNSEEN = 5e-5;
/** Between drawings without a GPU, which also has to serve the rest of the page [ms]. */
const SLOW_INTERVAL_MS = 50;
/** Without a GPU, a picture that has stood still for so long is drawn finely [ms]. */
const STILL_MS = 250;

export interface Colours {
  grid: string;
  ghost: string;
  highlight: string;
  collision: string;
  x: string;
  y: string;
  z: string;
  dark: boolean;
}

export interface Loaded {
  readonly robot: Robot;
  readonly objects: Objects;
  readonly ghost: Ghost;
}

export class Viewer {
  readonly labels = new Labels();
  /** Pictures drawn so far. */
  drawn = 0;
  private readonly renderer: WebGLRenderer;
  private readonly scene = new Scene();
  private readonly rig: CameraRig;
  private readonly picker: Picker;
  private readonly lighting: Lighting;
  private readonly ground: Ground;
  private readonly contact: ContactShadow | undefined;
  private readonly axes = new Axes();
  private readonly materials: Materials;
  private readonly collision = new CollisionLook();
  private readonly loop: Loop;
  private readonly interpolator = new Interpolator();
  private readonly pose: Pose = { time: 0, values: new Float64Array(0) };
  private shown = new Float64Array(0);
  private loaded: Loaded | undefined;
  private targets: Readonly<Record<string, number>> | undefined = {};
  private colours: Colours | undefined;
  private lit: string | null = null;
  private size = { width: 1, height: 1 };
  private refinement: ReturnType<typeof setTimeout> | undefined;

  constructor(
    readonly canvas: HTMLCanvasElement,
    private readonly hello: Hello,
    private readonly urdf: string,
    private readonly quality: Quality,
  ) {
    const high = quality === "high";
    this.renderer = new WebGLRenderer({
      canvas,
      // without a GPU it would halve the frames; there what stands still is refined
      antialias: high,
      alpha: true,
      powerPreference: "high-performance",
    });
    this.renderer.toneMapping = high ? NeutralToneMapping : 0;
    this.renderer.shadowMap.enabled = high;
    this.renderer.shadowMap.autoUpdate = false;
    this.materials = new Materials(quality);
    this.lighting = new Lighting(this.scene, this.renderer, quality);
    this.ground = new Ground(quality, hello.robot.ground !== null);
    this.ground.root.position.z = hello.robot.ground ?? 0;
    if (high && hello.robot.ground !== null) {
      this.contact = new ContactShadow(hello.robot.ground);
      this.scene.add(this.contact.root);
    }
    this.scene.add(this.ground.root, this.axes.root);
    this.loop = new Loop(this, high ? 0 : SLOW_INTERVAL_MS);
    this.rig = new CameraRig(canvas, () => {
      this.loop.invalidate();
    });
    this.picker = new Picker(canvas, this.rig.camera);
  }

  /** Read the robot and the objects; return what could not be read. */
  async load(): Promise<readonly string[]> {
    const meshes = new Meshes(this.materials);
    const [robot, objects] = await Promise.all([
      Robot.load(this.hello.robot, this.urdf, meshes, this.materials),
      Objects.load(this.hello.objects, meshes, this.materials),
    ]);
    const ghost = new Ghost(robot);
    this.scene.add(robot.root, robot.twin, objects.root);
    this.loaded = { robot, objects, ghost };
    if (this.colours) this.paint(this.colours);
    this.step(performance.now());
    this.look("iso", false);
    this.loop.invalidate();
    return [...robot.failures, ...objects.failures];
  }

  // ---- what the page tells ----------------------------------------------------------

  push(frame: Frame, arrival: number): void {
    this.interpolator.push(frame, arrival);
    this.loop.wake();
  }

  resize(width: number, height: number): void {
    this.size = { width, height };
    this.sharpen(this.quality === "high" ? Math.min(2, window.devicePixelRatio) : 1);
    this.rig.resize(width / height);
    this.loop.invalidate();
  }

  paint(colours: Colours): void {
    this.colours = colours;
    this.ground.paint({ ...colours, line: colours.grid });
    this.contact?.paint(colours.dark);
    this.axes.paint([colours.x, colours.y, colours.z]);
    this.collision.paint(colours.collision);
    this.loaded?.ghost.paint(colours.ghost);
    this.loop.invalidate();
  }

  /** Where controllers take the joints; undefined: show no goal. */
  aim(targets: Readonly<Record<string, number>> | undefined): void {
    this.targets = targets;
    this.updateGhost();
  }

  /** Draw the frames of these links. */
  showFrames(names: Iterable<string>): void {
    const links = new Map<string, Object3D>();
    for (const name of names) {
      const link = this.loaded?.robot.link(name);
      if (link) links.set(name, link);
      else if (name === "world") links.set(name, this.scene);
    }
    this.axes.show(links);
    this.loop.invalidate();
  }

  showCollision(visible: boolean): void {
    const look = (mesh: Mesh) => {
      this.collision.dress(mesh);
    };
    void this.loaded?.robot.showCollision(visible, look).then(() => {
      this.loop.invalidate();
    });
  }

  /** Light up a link. */
  highlight(link: string | null): void {
    if (link === this.lit || !this.loaded || !this.colours) return;
    const { visuals } = this.loaded.robot;
    for (const mesh of visuals.get(this.lit ?? "") ?? []) {
      mesh.material = this.materials.plainOf(mesh.material);
    }
    for (const mesh of visuals.get(link ?? "") ?? []) {
      mesh.material = this.materials.glowingOf(mesh.material, this.colours.highlight);
    }
    this.lit = link;
    this.loop.invalidate();
  }

  // ---- the camera -------------------------------------------------------------------

  look(view: View, fly = true): void {
    if (!this.loaded) return;
    if (view === "tool") this.lookAtTool(this.loaded.robot, fly);
    else this.rig.frame(this.everything(this.loaded), directionOf(view), fly);
    this.loop.wake();
  }

  /** See everything, from where the camera is. */
  fit(): void {
    if (!this.loaded) return;
    this.rig.frame(this.everything(this.loaded), this.rig.direction, true);
    this.loop.wake();
  }

  key(key: string): boolean {
    return this.rig.key(key);
  }

  get isDragging(): boolean {
    return this.rig.isDragging;
  }

  at(x: number, y: number): Hit | undefined {
    if (!this.loaded) return undefined;
    const { robot, objects } = this.loaded;
    return this.picker.at(x, y, [...[...robot.visuals.values()].flat(), objects.root]);
  }

  focus(point: Vector3): void {
    this.rig.focus(point);
    this.loop.wake();
  }

  private everything({ robot, objects }: Loaded): Box3 {
    const box = robot.boxOf(robot.root);
    // the ground that it stands on gives it its place in the picture
    box.min.z = Math.min(box.min.z, this.hello.robot.ground ?? box.min.z);
    return box.union(robot.boxOf(objects.root));
  }

  private lookAtTool(robot: Robot, fly: boolean): void {
    const { grippers } = this.hello.robot;
    const finger = robot.root.joints[grippers[0]?.joint ?? ""];
    const hand = finger?.parent ?? robot.link(this.toolLink);
    if (!hand) return;
    const box = robot.boxOf(hand);
    if (box.isEmpty())
      box.setFromObject(hand).expandByPoint(hand.getWorldPosition(new Vector3()));
    if (box.getSize(new Vector3()).length() < 0.1) box.expandByScalar(0.1);
    const direction = finger
      ? toolDirection(
          finger.axis.clone().transformDirection(finger.matrixWorld),
          this.rig.direction,
        )
      : this.rig.direction;
    this.rig.frame(box, direction, fly);
  }

  /** The link called tool0, with whatever prefix. */
  get toolLink(): string {
    const links = Object.keys(this.loaded?.robot.root.links ?? {});
    return links.find((name) => name.endsWith("tool0")) ?? links.at(-1) ?? "";
  }

  /** Frames that a person often wants: world, base and tool0, by their names here. */
  get usualFrames(): string[] {
    const links = Object.keys(this.loaded?.robot.root.links ?? {});
    const base = links.find((name) => /(^|_)base$/.test(name)) ?? this.hello.robot.root;
    return ["world", base, this.toolLink];
  }

  hasShape(link: string): boolean {
    return this.loaded?.robot.visuals.has(link) ?? false;
  }

  // ---- drawing; the loop calls ------------------------------------------------------

  step(now: number): boolean {
    const settled = this.interpolator.sample(now, this.pose);
    const flying = this.rig.step(now);
    if (this.loaded) this.move(this.loaded);
    return !settled || flying;
  }

  private move({ robot, objects }: Loaded): void {
    const { values } = this.pose;
    const { shown } = this;
    const moved =
      shown.length !== values.length ||
      values.some((value, i) => Math.abs(value - (shown[i] ?? 0)) > UNSEEN);
    if (!moved) return;
    this.shown = values.slice();
    robot.pose(values);
    objects.pose(values, this.hello.robot.joints.length);
    this.updateGhost();
    this.renderer.shadowMap.needsUpdate = true;
    if (this.contact) this.contact.needsUpdate = true;
    this.loop.invalidate();
  }

  private updateGhost(): void {
    if (!this.loaded) return;
    const { joints } = this.hello.robot;
    const goal = this.targets && goalOf(joints, this.shown, this.targets);
    if (this.loaded.ghost.show(goal)) this.loop.invalidate();
  }

  /** Draw so many pixels to a CSS pixel. */
  private sharpen(ratio: number): void {
    this.renderer.setPixelRatio(ratio);
    this.renderer.setSize(this.size.width, this.size.height, false);
  }

  draw(): void {
    if (this.quality === "low") {
      clearTimeout(this.refinement);
      if (this.renderer.getPixelRatio() !== 1) this.sharpen(1);
      this.refinement = setTimeout(() => {
        this.sharpen(2);
        this.render();
      }, STILL_MS);
    }
    this.render();
  }

  private render(): void {
    this.axes.update(this.rig.camera);
    this.contact?.update(this.renderer, this.scene);
    this.renderer.render(this.scene, this.rig.camera);
    this.labels.update(this.axes.labels, this.rig.camera);
    this.drawn += 1;
  }

  dispose(): void {
    this.loop.stop();
    clearTimeout(this.refinement);
    this.rig.dispose();
    this.scene.traverse((object) => {
      if ("geometry" in object) (object as Mesh).geometry.dispose();
    });
    this.loaded?.ghost.dispose();
    this.axes.dispose();
    this.ground.dispose();
    this.contact?.dispose();
    this.lighting.dispose();
    this.collision.dispose();
    this.materials.dispose();
    this.renderer.dispose();
  }
}
