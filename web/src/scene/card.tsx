/** The card of what is selected in the scene: its data, its contacts, and what can be done. */
import { useEffect, useState } from "preact/hooks";
import { need } from "../forces";
import { language, t } from "../i18n";
import { useLive } from "../live";
import { model } from "../model";
import { begin, moving, type MoveKind } from "../moving";
import { FrameSwitch } from "../panels/frame-switch";
import { LinkDetails } from "../panels/link-details";
import { describeObject, LivePose } from "../panels/objects";
import { placing } from "../placing";
import type { Contact, ViewObject } from "../protocol";
import { duplicateObject, removeObjects, targetOf } from "../scene-edits";
import { select, selectedObject, selection } from "../selection";
import { offers, unlessOffered, view } from "../store";
import { Button, IconButton } from "../ui/button";
import { CloseIcon, TrashIcon } from "../ui/icons";

export function SelectionCard() {
  const selected = selection.value;
  if (selected === null) return null;
  const { name } = selected;
  const object = selectedObject.value;
  const part = view.value?.robot.part_names[name]?.[language.value];
  return (
    <aside
      class="scene-card"
      aria-label={t("selection.title", { name })}
      data-testid="selection"
      data-name={name}
    >
      <header>
        <h3 class="grow ellipsis">{part ?? name}</h3>
        <FrameSwitch testId="selection-frame" />
        <IconButton
          label={t("selection.close")}
          data-testid="selection-close"
          onClick={() => {
            select(null);
          }}
        >
          <CloseIcon />
        </IconButton>
      </header>
      {object ? (
        <ObjectFacts key={name} object={object} />
      ) : (
        model.value && (
          <LinkDetails tree={model.value} link={name} isNamed={part !== undefined} />
        )
      )}
      {offers("read_contacts") && <Contacts key={name} name={name} />}
    </aside>
  );
}

/** Show the handles that move an object, or hide them if they are there. */
export function toggleHandles(name: string, kind: MoveKind): void {
  const now = moving.peek();
  const isThere = now?.name === name && now.kind === kind;
  begin(name, isThere ? null : (targetOf(name) ?? null), kind);
}

function ObjectFacts({ object }: { object: ViewObject }) {
  const { name } = object;
  const handles = moving.value?.name === name ? moving.value.kind : null;
  useEffect(
    () => () => {
      if (moving.peek()?.name === name) begin(name, null);
    },
    [name],
  );
  return (
    <>
      <p class="muted">{describeObject(object)}</p>
      <LivePose name={name} testId="selection-pose" />
      {offers("place_object", "add_object", "remove_object") && (
        <div class="row wrap">
          {(["move", "rotate"] as const).map((kind) => (
            <Button
              key={kind}
              aria-pressed={handles === kind}
              data-testid={`selection-${kind}`}
              {...unlessOffered("place_object")}
              onClick={() => {
                toggleHandles(name, kind);
              }}
            >
              {t(`edit.${kind}`)}
            </Button>
          ))}
          <Button
            data-testid="selection-duplicate"
            {...unlessOffered("add_object")}
            onClick={() => void duplicateObject(object)}
          >
            {t("edit.duplicate")}
          </Button>
          <IconButton
            label={t("edit.remove")}
            data-testid="selection-remove"
            {...unlessOffered("remove_object")}
            onClick={() => void removeObjects([object])}
          >
            <TrashIcon />
          </IconButton>
        </div>
      )}
    </>
  );
}

/** Return what touches a body, with the size of the force [N], strongest first. */
export function touching(
  name: string,
  contacts: readonly Contact[],
): { other: string; force: number }[] {
  return contacts
    .filter(({ first, second }) => first === name || second === name)
    .map(({ first, second, force }) => ({
      other: first === name ? second : first,
      force: Math.hypot(...force),
    }))
    .sort((one, other) => other.force - one.force);
}

function Contacts({ name }: { name: string }) {
  const [shown, setShown] = useState("");
  useEffect(() => need({ contacts: true }), []);
  useLive(({ contacts }) => {
    const found = touching(name, contacts ?? []);
    setShown(
      found.map(({ other, force }) => `${other}\t${force.toFixed(1)}`).join("\n"),
    );
  });
  return (
    <section class="scene-contacts" data-testid="selection-contacts">
      <h4>{t("selection.contacts")}</h4>
      {shown === "" ? (
        <p class="muted">{t("selection.noContacts")}</p>
      ) : (
        <ul>
          {shown.split("\n").map((row) => {
            const [other, force] = row.split("\t");
            return (
              <li key={other} data-testid={`selection-contact-${other ?? ""}`}>
                <code class="grow ellipsis">{other}</code>
                <span>{force} N</span>
              </li>
            );
          })}
        </ul>
      )}
    </section>
  );
}

/** What to do while the pointer places an object. */
export function PlacingHint() {
  const object = placing.value;
  if (object === null) return null;
  return (
    <p class="scene-hint" role="status" data-testid="placing">
      {t("edit.placing", { name: object.name })}
    </p>
  );
}
