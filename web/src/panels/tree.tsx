/** Links and their parent joints, by ROS name and display name. */
import { signal } from "@preact/signals";
import { language, t } from "../i18n";
import { model, modelFailure } from "../model";
import { view, hoveredLink, shownFrames } from "../store";
import { IconButton } from "../ui/button";
import { AxesIcon, ChevronDownIcon, ChevronRightIcon } from "../ui/icons";
import type { UrdfModel } from "../urdf";
import { LinkDetails } from "./link-details";
import { moveOf, visibleRows } from "./tree-keys";
import type { TreeRow } from "./tree-keys";

const folded = signal<ReadonlySet<string>>(new Set());
/** The row that the tab key focuses. */
const current = signal<string | null>(null);

function toggled(set: ReadonlySet<string>, member: string): ReadonlySet<string> {
  const next = new Set(set);
  if (!next.delete(member)) next.add(member);
  return next;
}

function toggleFrame(link: string): void {
  shownFrames.value = toggled(shownFrames.value, link);
}

function rowId(link: string): string {
  return `tree-row-${link}`;
}

export function TreePanel() {
  const tree = model.value;
  const failure = modelFailure.value;
  return (
    <section class="group tree-panel" aria-labelledby="tree-title">
      <header>
        <h2 id="tree-title">{t("tree.title")}</h2>
      </header>
      {tree ? (
        <Tree tree={tree} />
      ) : (
        <p class="muted">
          {failure === null ? t("tree.loading") : t("tree.failed", { reason: failure })}
        </p>
      )}
    </section>
  );
}

function Tree({ tree }: { tree: UrdfModel }) {
  const rows = visibleRows(tree, folded.value);
  const reachable = rows.some((row) => row.link === current.value)
    ? current.value
    : tree.root;

  const onKeyDown = (event: KeyboardEvent) => {
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    const link = current.value ?? tree.root;
    if (event.key === "f" || event.key === "F") {
      toggleFrame(link);
      return;
    }
    const move = moveOf(event.key, link, rows, folded.value);
    if (move === undefined) return;
    event.preventDefault();
    if ("focus" in move) document.getElementById(rowId(move.focus))?.focus();
    else folded.value = toggled(folded.value, "fold" in move ? move.fold : move.unfold);
  };

  const leave = () => {
    hoveredLink.value = null;
  };
  return (
    <>
      <ul
        class="tree"
        role="tree"
        aria-label={t("tree.title")}
        onKeyDown={onKeyDown}
        onPointerLeave={leave}
        onFocusOut={leave}
      >
        {rows.map((row) => (
          <Row key={row.link} row={row} isReachable={row.link === reachable} />
        ))}
      </ul>
      <LinkDetails tree={tree} link={hoveredLink.value ?? current.value} />
    </>
  );
}

function Row({ row, isReachable }: { row: TreeRow; isReachable: boolean }) {
  const { link, joint } = row;
  const names = view.value?.robot.part_names;
  const isFolded = folded.value.has(link);
  const hover = () => {
    hoveredLink.value = link;
  };
  const frameShown = shownFrames.value.has(link);
  return (
    <li
      role="treeitem"
      id={rowId(link)}
      aria-level={row.level}
      aria-setsize={row.siblings}
      aria-posinset={row.place}
      aria-expanded={row.hasChildren ? !isFolded : undefined}
      aria-selected={hoveredLink.value === link}
      tabIndex={isReachable ? 0 : -1}
      class={hoveredLink.value === link ? "hovered" : ""}
      style={{ "--level": row.level - 1 }}
      data-testid={`tree-link-${link}`}
      onPointerEnter={hover}
      onClick={() => {
        current.value = link;
      }}
      onFocus={() => {
        current.value = link;
        hover();
      }}
    >
      {row.hasChildren ? (
        <button
          type="button"
          class="fold"
          tabIndex={-1}
          aria-label={t("tree.expand", { link })}
          onClick={() => {
            folded.value = toggled(folded.value, link);
          }}
        >
          {isFolded ? <ChevronRightIcon /> : <ChevronDownIcon />}
        </button>
      ) : (
        <span class="fold" />
      )}
      <div class="tree-names">
        <Names ros={link} person={names?.[link]?.[language.value]} />
        {joint && (
          <span class="tree-joint" data-type={joint.type}>
            <Names ros={joint.name} person={names?.[joint.name]?.[language.value]} />
          </span>
        )}
      </div>
      <IconButton
        label={t("tree.frame", { link })}
        aria-pressed={frameShown}
        tabIndex={-1}
        data-testid={`tree-frame-${link}`}
        onClick={(event) => {
          event.stopPropagation();
          toggleFrame(link);
        }}
      >
        <AxesIcon />
      </IconButton>
    </li>
  );
}

function Names({ ros, person }: { ros: string; person: string | undefined }) {
  return (
    <span class="names">
      <code>{ros}</code>
      {person !== undefined && <span class="person">{person}</span>}
    </span>
  );
}
