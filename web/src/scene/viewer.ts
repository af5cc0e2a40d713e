/** The scene on its canvas: what the page calls. */
import { type Box3, type Mesh, type Object3D, Vector3 } from "three";
import { aimAt, moving, putThere } from "../moving";
import type { Target } from "../moving";
import type { Frame, RobotPartsInfo, ViewInfo, ViewScene } from "../protocol";
import { CollisionLook } from "./collision";
import { directionOf, toolDirection, type View } from "./framing";
import { Ghost } from "./ghost";
import { goalOf } from "./goal";
import { Interpolator, type Pose } from "./interpolation";
import { Loop } from "./loop";
import { Marker } from "./marker";
import { Materials } from "./materials";
import { Meshes } from "./meshes";
import { Mover } from "./mover";
import { Objects } from "./objects";
import { type Hit, Picker } from "./picker";
import type { Quality } from "./quality";
import { Robot } from "./robot";
import { type Colours, Stage } from "./stage";

/** What moved by less than this since it was drawn is not drawn again [rad | m]: a tenth of a pixel. */
const UNSEEN = 5e-5;
/** Between drawings without a GPU, which also has to serve the rest of the page [ms]. */
const SLOW_INTERVAL_MS = 50;

interface Loaded {
  readonly robot: Robot;
  readonly objects: Objects;
  readonly ghost: Ghost;
}

export class Viewer {
  private readonly stage: Stage;
  private readonly picker: Picker;
  private readonly mover: Mover;
  private readonly marker: Marker;
  private readonly materials: Materials;
  private readonly collision = new CollisionLook();
  private readonly loop: Loop;
  private readonly interpolator = new Interpolator();
  private readonly pose: Pose = { time: 0, values: new Float64Array(0), scene: 0 };
  private readonly meshes: Meshes;
  /** Whether an object was added or removed since the last picture. */
  private isChanged = false;
  private shown = new Float64Array(0);
  private loaded: Loaded | undefined;
  private targets: Readonly<Record<string, number>> | undefined = {};
  private colours: Colours | undefined;
  private lit: string | null = null;
  private selected: RobotPartsInfo | null = null;

  constructor(
    canvas: HTMLCanvasElement,
    private readonly view: ViewInfo,
    private readonly urdf: string,
    quality: Quality,
  ) {
    this.loop = new Loop(this, quality === "high" ? 0 : SLOW_INTERVAL_MS);
    this.stage = new Stage(canvas, view.robot.ground, quality, () => {
      this.loop.invalidate();
    });
    this.materials = new Materials(quality);
    this.meshes = new Meshes(this.materials);
    this.picker = new Picker(canvas, this.stage.rig.camera);
    this.mover = new Mover(this.stage.rig.camera, canvas, {
      changed: () => {
        this.loop.invalidate();
      },
      dragged: (is) => {
        this.stage.rig.isEnabled = !is;
        if (!is) void putThere();
      },
      moved: (position) => {
        const now = moving.peek();
        if (now) aimAt({ ...now.target, position });
      },
    });
    this.marker = new Marker(view.robot.ground);
    this.stage.scene.add(this.mover.root, this.marker.root);
  }

  /** What is written over the picture. */
  get labels(): HTMLElement {
    return this.stage.labels.element;
  }

  /** Pictures drawn so far. */
  get drawn(): number {
    return this.stage.drawn;
  }

  /** Load the robot and the objects; return load errors. */
  async load(scene: ViewScene | null): Promise<readonly string[]> {
    const objects = new Objects(this.meshes, this.materials);
    const [robot] = await Promise.all([
      Robot.load(this.view.robot, this.urdf, this.meshes, this.materials),
      scene && objects.show(scene),
    ]);
    const ghost = new Ghost(robot);
    this.stage.scene.add(robot.root, robot.twin, objects.root);
    this.loaded = { robot, objects, ghost };
    if (this.colours) this.paint(this.colours);
    this.step(performance.now());
    this.look("iso", false);
    this.loop.invalidate();
    return [...robot.failures, ...objects.failures];
  }

  // ---- input from the page -----------------------------------------------------------

  /** Show these objects around the robot; return load errors. */
  async surround(scene: ViewScene): Promise<readonly string[]> {
    if (!this.loaded) return [];
    const { robot, objects } = this.loaded;
    const shown = objects.show(scene);
    this.redraw();
    await shown;
    this.redraw();
    return [...robot.failures, ...objects.failures];
  }

  private redraw(): void {
    this.isChanged = true;
    this.loop.wake();
  }

  push(frame: Frame, arrival: number): void {
    this.interpolator.push(frame, arrival);
    this.loop.wake();
  }

  resize(width: number, height: number): void {
    this.stage.resize(width, height);
  }

  paint(colours: Colours): void {
    this.colours = colours;
    this.stage.paint(colours);
    this.collision.paint(colours.collision);
    this.marker.paint(colours.ghost);
    this.loaded?.ghost.paint(colours.ghost);
  }

  /** Targets of the controllers; undefined: show no goal. */
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
      else if (name === "world") links.set(name, this.stage.scene);
    }
    this.stage.axes.show(links);
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

  /** Show arrows that move this object, or none. */
  offerMove(target: Target | null): void {
    this.mover.offer(target);
    this.loop.invalidate();
  }

  /** Mark this robot of several, or none. */
  select(robot: RobotPartsInfo | null): void {
    this.selected = robot;
    this.marker.mark(this.loaded?.robot.link(robot?.base ?? ""));
    this.loop.invalidate();
  }

  /** Light up a link. */
  highlight(link: string | null): void {
    if (link === this.lit || !this.loaded || !this.colours) return;
    const { robot } = this.loaded;
    const { highlight } = this.colours;
    robot.dress(this.lit, (one) => this.materials.plainOf(one));
    robot.dress(link, (one) => this.materials.glowingOf(one, highlight));
    this.lit = link;
    this.loop.invalidate();
  }

  // ---- the camera -------------------------------------------------------------------

  look(view: View, fly = true): void {
    if (!this.loaded) return;
    if (view === "tool") this.lookAtTool(this.loaded.robot, fly);
    else this.stage.rig.frame(this.everything(this.loaded), directionOf(view), fly);
    this.loop.wake();
  }

  /** See everything, from where the camera is. */
  fit(): void {
    if (!this.loaded) return;
    this.stage.rig.frame(this.everything(this.loaded), this.stage.rig.direction, true);
    this.loop.wake();
  }

  key(key: string): boolean {
    return this.stage.rig.key(key);
  }

  get isDragging(): boolean {
    return this.stage.rig.isDragging;
  }

  at(x: number, y: number): Hit | undefined {
    if (!this.loaded) return undefined;
    const { robot, objects } = this.loaded;
    return this.picker.at(x, y, [...[...robot.visuals.values()].flat(), objects.root]);
  }

  focus(point: Vector3): void {
    this.stage.rig.focus(point);
    this.loop.wake();
  }

  private everything({ robot, objects }: Loaded): Box3 {
    const box = robot.boxOf(robot.root);
    // the ground that it stands on gives it its place in the picture
    box.min.z = Math.min(box.min.z, this.view.robot.ground ?? box.min.z);
    return box.union(robot.boxOf(objects.root));
  }

  private lookAtTool(robot: Robot, fly: boolean): void {
    const { selected } = this;
    const gripper = this.view.robot.grippers.find(
      ({ name }) => selected === null || name === selected.gripper,
    );
    const finger = robot.root.joints[gripper?.joint ?? ""];
    const hand = finger?.parent ?? robot.link(this.toolLink(selected));
    if (!hand) return;
    const box = robot.boxOf(hand);
    if (box.isEmpty()) box.expandByPoint(hand.getWorldPosition(new Vector3()));
    if (box.getSize(new Vector3()).length() < 0.1) box.expandByScalar(0.1);
    const direction = finger
      ? toolDirection(
          finger.axis.clone().transformDirection(finger.matrixWorld),
          this.stage.rig.direction,
        )
      : this.stage.rig.direction;
    this.stage.rig.frame(box, direction, fly);
  }

  /** The end of a robot's arm; without several, the link called tool0 with any prefix. */
  private toolLink(selected: RobotPartsInfo | null): string {
    if (selected) return selected.tip;
    const links = Object.keys(this.loaded?.robot.root.links ?? {});
    return links.find((name) => name.endsWith("tool0")) ?? links.at(-1) ?? "";
  }

  /** Frames that are often needed: world, a robot's base and tool0, by their names here. */
  usualFrames(selected: RobotPartsInfo | null): string[] {
    const links = Object.keys(this.loaded?.robot.root.links ?? {}).filter((name) =>
      name.startsWith(selected?.prefix ?? ""),
    );
    const base = links.find((name) => /(^|_)base$/.test(name)) ?? this.view.robot.root;
    return ["world", base, this.toolLink(selected)];
  }

  hasShape(link: string): boolean {
    return this.loaded?.robot.visuals.has(link) ?? false;
  }

  // ---- drawing; the loop calls ------------------------------------------------------

  step(now: number): boolean {
    const settled = this.interpolator.sample(now, this.pose);
    const flying = this.stage.rig.step(now);
    if (this.loaded) this.move(this.loaded);
    return !settled || flying;
  }

  private move({ robot, objects }: Loaded): void {
    const { values } = this.pose;
    const { shown } = this;
    const moved =
      this.isChanged ||
      shown.length !== values.length ||
      values.some((value, i) => Math.abs(value - (shown[i] ?? 0)) > UNSEEN);
    if (!moved) return;
    this.shown = values.slice();
    this.isChanged = false;
    robot.pose(values);
    this.marker.follow();
    objects.pose(this.pose, this.view.robot.joints.length);
    this.updateGhost();
    this.stage.castAnew();
    // before the first frame all poses were unknown
    if (shown.length === 0) this.look("iso", false);
  }

  private updateGhost(): void {
    if (!this.loaded) return;
    const { joints } = this.view.robot;
    const goal = this.targets && goalOf(joints, this.shown, this.targets);
    if (this.loaded.ghost.show(goal)) this.loop.invalidate();
  }

  draw(): void {
    this.stage.draw();
  }

  dispose(): void {
    this.loop.stop();
    this.mover.dispose();
    this.marker.dispose();
    this.stage.dispose();
    this.loaded?.ghost.dispose();
    this.collision.dispose();
    this.materials.dispose();
  }
}
