/** What is drawn over robot and objects: forces, inertias, trace, and a planned path. */
import { Group, type Object3D } from "three";
import { linkPose } from "../kinematics";
import type { Overlay as Name } from "../overlays";
import type { Frame } from "../messages";
import type { RobotPartsInfo, ViewObject } from "../protocol";
import type { UrdfModel, Vector } from "../urdf";
import { ContactArrows, forcesOf } from "./contact-arrows";
import { Inertias } from "./inertia";
import type { Label } from "./labels";
import { ThickLine } from "./line";
import type { Colours } from "./stage";
import { Trace } from "./trace";
import { WrenchArrow } from "./wrench-arrow";

/** One arm: what is drawn at its tip. */
interface Tip {
  readonly arm: string;
  readonly link: string;
  readonly wrench: WrenchArrow;
  readonly trace: Trace;
  readonly line: ThickLine;
}

export class Overlay {
  readonly root = new Group();
  private readonly contacts = new ContactArrows();
  private readonly inertias = new Inertias();
  private readonly path = new ThickLine({ width: 3, dashed: true });
  private readonly tips: readonly Tip[];
  private shown: Readonly<Record<Name, boolean>> = {
    contacts: false,
    wrench: false,
    inertia: false,
    trace: false,
  };
  private readonly index: ReadonlyMap<string, number>;
  private readonly links: ReadonlySet<string>;
  /** Since the last picture. */
  private frame: Frame | undefined;
  private objects: readonly ViewObject[] = [];

  constructor(
    robots: readonly RobotPartsInfo[],
    joints: readonly { name: string }[],
    private readonly model: UrdfModel | null,
    private readonly linkOf: (name: string) => Object3D | undefined,
  ) {
    this.index = new Map(joints.map(({ name }, index) => [name, index]));
    this.links = new Set(model?.links.keys());
    this.tips = robots.map(({ name, tip }) => ({
      arm: name,
      link: tip,
      wrench: new WrenchArrow(),
      trace: new Trace(),
      line: new ThickLine({ width: 2.5, fades: true }),
    }));
    this.root.add(this.contacts.root, this.path.root);
    for (const { wrench, line } of this.tips) this.root.add(wrench.root, line.root);
  }

  paint(colours: Colours): void {
    this.contacts.paint(colours.contact);
    this.inertias.paint(colours.force, colours.collision);
    this.path.paint(colours.ghost, colours.ghost);
    for (const { wrench, line } of this.tips) {
      wrench.paint(colours.force);
      line.paint(colours.force, colours.grid);
    }
  }

  /** Show these overlays and no others. */
  show(shown: Readonly<Record<Name, boolean>>): void {
    const before = this.shown;
    this.shown = shown;
    if (!shown.contacts) this.contacts.show([]);
    for (const { wrench, trace, line } of this.tips) {
      if (!shown.wrench) wrench.show(undefined, undefined);
      if (shown.trace) continue;
      trace.clear();
      line.show([]);
    }
    if (shown.inertia !== before.inertia) {
      this.inertias.show(shown.inertia ? this.model : null, this.linkOf);
    }
  }

  /** Show a planned path of the tool, or none. */
  plan(points: readonly Vector[] | null): void {
    this.path.show(points?.flat() ?? []);
  }

  /** Take a frame; return whether anything looks different. */
  push(frame: Frame, objects: readonly ViewObject[]): boolean {
    const { shown, model } = this;
    this.frame = frame;
    this.objects = objects;
    if (shown.trace && model)
      for (const tip of this.tips) this.follow(tip, frame, model);
    return shown.contacts || shown.wrench || shown.trace;
  }

  private follow({ link, trace }: Tip, frame: Frame, model: UrdfModel): void {
    const pose = linkPose(
      model,
      link,
      (joint) => frame.position[this.index.get(joint) ?? -1],
    );
    trace.push(frame.time, pose.p);
  }

  /** Draw what the newest frame says; frames come more often than pictures. */
  update(): void {
    const { frame, shown } = this;
    if (frame === undefined) return;
    this.frame = undefined;
    if (shown.contacts) {
      this.contacts.show(forcesOf(frame.contacts ?? [], this.objects, this.links));
    }
    for (const { arm, link, wrench, trace, line } of this.tips) {
      if (shown.wrench) wrench.show(this.linkOf(link), frame.wrenches?.[arm]);
      if (shown.trace) line.show(trace.path);
    }
  }

  get labels(): Label[] {
    return [
      ...this.contacts.labels,
      ...this.tips.flatMap(({ wrench }) => wrench.labels),
    ];
  }

  dispose(): void {
    this.contacts.dispose();
    this.inertias.dispose();
    this.path.dispose();
    for (const { wrench, line } of this.tips) {
      wrench.dispose();
      line.dispose();
    }
  }
}
