/** The steps: a tree, moved through by arrow keys, reordered by keys or by dragging. */
import { useEffect, useLayoutEffect, useRef } from "preact/hooks";
import { t } from "../../i18n";
import { remarks, showStep } from "../../program/checking";
import {
  duplicate,
  moveSelected,
  remove,
  rows,
  selection,
  wrap,
} from "../../program/editor";
import { onListKey } from "../../program/keys";
import { runningStep } from "../../program/running";
import { isLoop, pathText, type Row, samePath } from "../../program/steps";
import { detailOf, titleOf } from "../../program/words";
import { IconButton } from "../../ui/button";
import { CopyIcon, ChevronDownIcon, ChevronUpIcon, TrashIcon } from "../../ui/icons";
import { drop, dropText, useReorder } from "./reorder";
import { GripIcon, KIND_ICONS, LoopIcon } from "./icons";

export function StepList() {
  const list = useRef<HTMLUListElement | null>(null);
  const reorder = useReorder(list);
  const chosen = selection.value;
  /** Whether a key has changed the list: the focus goes with the selection. */
  const isKey = useRef(false);
  useEffect(() => {
    showStep(chosen);
  }, [chosen, rows.value]);
  useLayoutEffect(() => {
    const row = list.current?.querySelector<HTMLElement>("[aria-selected=true]");
    row?.scrollIntoView({ block: "nearest" });
    if (isKey.current) row?.focus();
    isKey.current = false;
  }, [chosen, rows.value]);

  if (rows.value.length === 0) return <p class="muted">{t("program.none")}</p>;
  const first = rows.value[0]?.path ?? [];
  const focusable = chosen ?? first;
  return (
    <>
      <ul
        class="steps"
        role="tree"
        aria-label={t("program.steps")}
        data-testid="program-steps"
        ref={list}
        onKeyDown={(event) => {
          if (event.key === "Enter") {
            event.preventDefault();
            focusFields();
          } else isKey.current = onListKey(event);
        }}
        {...reorder}
      >
        {rows.value.map((row) => (
          <StepRow
            key={pathText(row.path)}
            row={row}
            isFocusable={samePath(row.path, focusable)}
          />
        ))}
      </ul>
      <p class="visually-hidden" role="status">
        {dropText.value}
      </p>
      <div class="row wrap" role="toolbar" aria-label={t("program.edit")}>
        <IconButton
          label={t("program.up")}
          disabled={chosen === null}
          data-testid="program-up"
          onClick={() => moveSelected("up")}
        >
          <ChevronUpIcon />
        </IconButton>
        <IconButton
          label={t("program.down")}
          disabled={chosen === null}
          data-testid="program-down"
          onClick={() => moveSelected("down")}
        >
          <ChevronDownIcon />
        </IconButton>
        <IconButton
          label={t("program.duplicate")}
          disabled={chosen === null}
          data-testid="program-duplicate"
          onClick={duplicate}
        >
          <CopyIcon />
        </IconButton>
        <IconButton
          label={t("program.wrap")}
          disabled={chosen === null}
          data-testid="program-wrap"
          onClick={wrap}
        >
          <LoopIcon />
        </IconButton>
        <IconButton
          label={t("program.delete")}
          disabled={chosen === null}
          data-testid="program-delete"
          onClick={remove}
        >
          <TrashIcon />
        </IconButton>
      </div>
    </>
  );
}

/** Go from the list to the fields of the selected step. */
function focusFields(): void {
  document
    .querySelector<HTMLElement>(
      "#step-fields :is(input, select, button):not(:disabled)",
    )
    ?.focus();
}

function StepRow({ row, isFocusable }: { row: Row; isFocusable: boolean }) {
  const { path, step } = row;
  const text = pathText(path);
  const remark = remarks.value.get(text);
  const isSelected = selection.value !== null && samePath(selection.value, path);
  const isNow = runningStep.value !== null && samePath(runningStep.value, path);
  const target = drop.value;
  const Icon = KIND_ICONS[step.kind];
  return (
    <li
      role="treeitem"
      aria-level={path.length}
      aria-selected={isSelected}
      aria-current={isNow ? "step" : undefined}
      aria-expanded={isLoop(step) ? true : undefined}
      tabIndex={isFocusable ? 0 : -1}
      class={remark ? (remark.isError ? "wrong" : "doubtful") : ""}
      style={{ "--level": path.length - 1 }}
      data-path={text}
      data-drop={target?.row === text ? target.where : undefined}
      data-testid={`program-step-${text}`}
      onClick={() => {
        selection.value = path;
      }}
      onFocus={() => {
        selection.value ??= path;
      }}
    >
      <span class="grip" aria-hidden="true">
        <GripIcon />
      </span>
      <span class="step-number">{text}</span>
      <Icon />
      <span class="step-text">
        <span class="ellipsis">
          <b>{titleOf(step)}</b> <span class="muted">{detailOf(step)}</span>
        </span>
        {remark && (
          <span class="step-remark" data-testid={`program-remark-${text}`}>
            {remark.text}
          </span>
        )}
      </span>
    </li>
  );
}
