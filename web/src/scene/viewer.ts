/** The scene on its canvas: what the page calls. */
import { type Box3, type Mesh, type Object3D, Plane, Vector3 } from "three";
import { aimAt, putThere } from "../moving";
import type { Move } from "../moving";
import type { Overlay as OverlayName } from "../overlays";
import type { NewObject } from "../placing";
import type { Frame } from "../messages";
import type { RobotPartsInfo, ViewInfo, ViewObject, ViewScene } from "../protocol";
import type { Selection } from "../selection";
import type { UrdfModel, Vector } from "../urdf";
import { CollisionLook } from "./collision";
import { directionOf, toolDirection, type View } from "./framing";
import { ToolGizmo } from "./gizmo";
import { Ghost } from "./ghost";
import { Glow } from "./glow";
import { goalOf } from "./goal";
import { Interpolator, type Pose } from "./interpolation";
import { Loop } from "./loop";
import { Marker } from "./marker";
import { Materials } from "./materials";
import { Meshes } from "./meshes";
import { Mover } from "./mover";
import { Objects } from "./objects";
import { Outline } from "./outline";
import { type Hit, Picker } from "./picker";
import { Overlay } from "./overlay";
import { Placer } from "./placer";
import { PullSpring } from "./pull";
import type { Quality } from "./quality";
import { Robot } from "./robot";
import { type Colours, Stage } from "./stage";
import { aimTool, dragTool } from "../tool-target";

/** What moved by less than this since it was drawn is not drawn again [rad | m]: a tenth of a pixel. */
const UNSEEN = 5e-5;
/** Between drawings without a GPU, which also has to serve the rest of the page [ms]. */
const SLOW_INTERVAL_MS = 33;

interface Loaded {
  readonly robot: Robot;
  readonly objects: Objects;
  readonly ghost: Ghost;
}

export class Viewer {
  private readonly stage: Stage;
  private readonly picker: Picker;
  private readonly mover: Mover;
  /** At the tool of the selected arm. */
  readonly gizmo: ToolGizmo;
  private readonly marker: Marker;
  private readonly spring: PullSpring;
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
  private readonly glow: Glow;
  private readonly outline = new Outline();
  private readonly placer = new Placer();
  private readonly overlay: Overlay;
  private objects: readonly ViewObject[] = [];
  private hovered: string | null = null;
  private selection: Selection | null = null;
  private selected: RobotPartsInfo | null = null;

  constructor(
    canvas: HTMLCanvasElement,
    private readonly view: ViewInfo,
    private readonly urdf: string,
    model: UrdfModel | null,
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
      moved: aimAt,
    });
    this.gizmo = new ToolGizmo(this.stage.rig.camera, canvas, {
      changed: () => {
        this.loop.invalidate();
      },
      dragged: (is) => {
        this.stage.rig.isEnabled = !is;
        void dragTool(is);
      },
      moved: aimTool,
    });
    this.marker = new Marker(view.robot.ground);
    this.glow = new Glow(this.materials);
    this.overlay = new Overlay(view.robot.robots, view.robot.joints, model, (name) =>
      this.loaded?.robot.link(name),
    );
    this.stage.moreLabels = () => this.overlay.labels;
    this.stage.scene.add(this.overlay.root);
    this.spring = new PullSpring(canvas, this.stage.rig.camera, this.picker, {
      at: (x, y) => this.at(x, y),
      link: (name) => this.loaded?.robot.link(name),
      changed: () => {
        this.loop.invalidate();
      },
    });
    this.stage.scene.add(
      this.mover.root,
      this.gizmo.root,
      this.marker.root,
      this.placer.root,
      this.spring.root,
    );
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
    this.objects = scene.objects;
    const shown = objects.show(scene);
    this.redraw();
    await shown;
    this.lightUp();
    this.redraw();
    return [...robot.failures, ...objects.failures];
  }

  private redraw(): void {
    this.isChanged = true;
    this.loop.wake();
  }

  push(frame: Frame, arrival: number): void {
    this.interpolator.push(frame, arrival);
    if (this.loaded && this.overlay.push(frame, this.objects)) this.loop.invalidate();
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
    this.mover.paint(colours);
    this.gizmo.paint(colours);
    this.placer.paint(colours.ghost);
    this.outline.paint(colours.ghost);
    this.overlay.paint(colours);
    this.glow.paint(colours.highlight);
    this.spring.paint(colours.highlight);
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

  /** Show forces, inertias and traces. */
  showOverlays(shown: Readonly<Record<OverlayName, boolean>>): void {
    this.overlay.show(shown);
    this.loop.invalidate();
  }

  /** Show a planned path of the tool, or none. */
  showPath(points: readonly Vector[] | null): void {
    this.overlay.plan(points);
    this.loop.invalidate();
  }

  /** Show handles that move this object, or none. */
  offerMove(move: Move | null): void {
    this.mover.offer(move);
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
    this.hovered = link;
    this.lightUp();
  }

  /** Light up and outline what is selected. */
  choose(selection: Selection | null): void {
    this.selection = selection;
    this.lightUp();
  }

  private lightUp(): void {
    if (!this.loaded) return;
    const { robot, objects } = this.loaded;
    const { kind, name } = this.selection ?? {};
    const meshes =
      kind === "object"
        ? objects.meshesOf(name ?? "")
        : (robot.visuals.get(name ?? "") ?? []);
    this.outline.show(meshes);
    this.glow.show([...meshes, ...(robot.visuals.get(this.hovered ?? "") ?? [])]);
    this.loop.invalidate();
  }

  /** Let the pointer place this object, or none. */
  offerPlace(object: NewObject | null): void {
    this.placer.offer(object);
    this.loop.invalidate();
  }

  /** Show the offered object under a point of the window [px]; the result is where it is. */
  aimPlace(x: number, y: number): Vector3 | undefined {
    this.loop.invalidate();
    return this.placer.put(this.at(x, y) ?? this.onGround(x, y));
  }

  private onGround(x: number, y: number): Pick<Hit, "point" | "normal"> | undefined {
    const normal = new Vector3(0, 0, 1);
    const point = this.picker.on(
      new Plane(normal, -(this.view.robot.ground ?? 0)),
      x,
      y,
    );
    return point && { point, normal };
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

  /** Where the gizmo's z arrow is in the picture, from its top left corner [px]. */
  get arrowAt(): readonly [number, number] {
    const { clientWidth, clientHeight } = this.stage.labels.element;
    const at = this.gizmo.arrow.project(this.stage.rig.camera);
    return [((at.x + 1) / 2) * clientWidth, ((1 - at.y) / 2) * clientHeight];
  }

  /** Height of the camera above the ground [m]. */
  get eyeHeight(): number {
    return this.stage.rig.camera.position.z - (this.view.robot.ground ?? 0);
  }

  get isDragging(): boolean {
    return this.stage.rig.isDragging;
  }

  /** Whether the pointer is over the handles that move an object. */
  get isOnHandles(): boolean {
    return this.mover.isHovered || this.gizmo.isHovered;
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
    this.spring.follow();
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
    this.overlay.update();
    this.stage.draw();
  }

  /** Return what is seen as a PNG, with twice the pixels. */
  picture(): Promise<Blob> {
    return this.stage.picture();
  }

  dispose(): void {
    this.loop.stop();
    this.mover.dispose();
    this.gizmo.dispose();
    this.outline.dispose();
    this.placer.dispose();
    this.overlay.dispose();
    this.marker.dispose();
    this.spring.dispose();
    this.stage.dispose();
    this.loaded?.ghost.dispose();
    this.collision.dispose();
    this.materials.dispose();
  }
}
