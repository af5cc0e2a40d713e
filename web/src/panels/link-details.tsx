/** Details of one link: mass, parent joint and present pose. */
import type { ComponentChildren } from "preact";
import { useRef } from "preact/hooks";
import { t } from "../i18n";
import type { Key } from "../i18n";
import { en } from "../i18n/en";
import { linkPose, toRpy } from "../kinematics";
import { useLive } from "../live";
import { frameName, inNumberFrame } from "../number-frame";
import { jointIndex } from "../store";
import { fixed } from "../ui/number-field";
import { angleUnit, unitOf } from "../units";
import type { UrdfJoint, UrdfModel, Vector } from "../urdf";

function typeName(type: string): string {
  const key = `tree.type.${type}`;
  return key in en ? t(key as Key) : type;
}

function numbers(vector: Vector, digits: number): string {
  return vector.map((one) => fixed(one, digits)).join("  ");
}

interface LinkDetailsProps {
  tree: UrdfModel;
  link: string | null;
  /** Whether its name is there: not, where it is the title above. */
  isNamed?: boolean;
}

export function LinkDetails({ tree, link, isNamed = true }: LinkDetailsProps) {
  const known = link === null ? undefined : tree.links.get(link);
  if (known === undefined) {
    return <p class="details hint">{t("tree.hint")}</p>;
  }
  const joint = tree.parentJoint.get(known.name);
  return (
    <div class="details" data-testid="link-details">
      {isNamed && (
        <h3>
          <code>{known.name}</code>
        </h3>
      )}
      <dl>
        <Fact name={t("tree.mass")}>
          {known.inertial === null
            ? t("tree.massless")
            : `${known.inertial.mass.toPrecision(4)} kg`}
        </Fact>
        {joint && <JointFacts joint={joint} />}
        <LivePose key={known.name} tree={tree} link={known.name} />
      </dl>
    </div>
  );
}

function Fact({ name, children }: { name: string; children: ComponentChildren }) {
  return (
    <div>
      <dt>{name}</dt>
      <dd>{children}</dd>
    </div>
  );
}

function JointFacts({ joint }: { joint: UrdfJoint }) {
  const moves = joint.type !== "fixed";
  const unit = unitOf(
    joint.type === "prismatic" ? "prismatic" : "revolute",
    angleUnit.value,
  );
  const shown = (value: number) => fixed(value * unit.factor, unit.digits);
  const force = joint.type === "prismatic" ? "N" : "N·m";
  const range =
    joint.lower === null || joint.upper === null
      ? t("tree.unlimited")
      : `${shown(joint.lower)} … ${shown(joint.upper)} ${unit.symbol}`;
  return (
    <>
      <Fact name={t("tree.joint")}>
        <code>{joint.name}</code> <span class="muted">{typeName(joint.type)}</span>
      </Fact>
      {moves && <Fact name={t("tree.axis")}>{joint.axis.join("  ")}</Fact>}
      {moves && <Fact name={t("tree.limits")}>{range}</Fact>}
      {joint.velocity !== null && (
        <Fact name={t("tree.speedLimit")}>
          {shown(joint.velocity)} {unit.symbol}/s
        </Fact>
      )}
      {joint.effort !== null && (
        <Fact name={t("tree.effortLimit")}>
          {joint.effort} {force}
        </Fact>
      )}
      {joint.mimic && (
        <Fact name={t("tree.mimics")}>
          <code>{joint.mimic.joint}</code> × {joint.mimic.multiplier}
        </Fact>
      )}
    </>
  );
}

function LivePose({ tree, link }: { tree: UrdfModel; link: string }) {
  const position = useRef<HTMLSpanElement | null>(null);
  const rotation = useRef<HTMLSpanElement | null>(null);
  const unit = unitOf("revolute", angleUnit.value);
  useLive((frame) => {
    const pose = inNumberFrame(
      linkPose(
        tree,
        link,
        (joint) => frame.position[jointIndex.value.get(joint) ?? -1],
      ),
    );
    const [roll, pitch, yaw] = toRpy(pose.R);
    const shown: Vector = [roll * unit.factor, pitch * unit.factor, yaw * unit.factor];
    const [x, y, z] = pose.p;
    const millimetres: Vector = [x * 1000, y * 1000, z * 1000];
    if (position.current)
      position.current.textContent = `${numbers(millimetres, 1)} mm`;
    if (rotation.current) {
      rotation.current.textContent = `${numbers(shown, unit.digits)} ${unit.symbol}`;
    }
  });
  return (
    <>
      <Fact name={t("frame.in", { what: t("tree.position"), frame: frameName() })}>
        <span ref={position} data-testid="link-position" />
      </Fact>
      <Fact name={t("frame.in", { what: t("tree.rotation"), frame: frameName() })}>
        <span ref={rotation} />
      </Fact>
    </>
  );
}
