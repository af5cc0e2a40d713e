/** The signals to choose from, by group, with a search. */
import { useState } from "preact/hooks";
import { t } from "../i18n";
import { choose, type Pane } from "./layout";
import { groupName, GROUPS, quantityName, signalName } from "./names";
import { shownSource } from "./range";
import type { Group, SignalInfo } from "./signals";

interface PickerProps {
  index: number;
  pane: Pane;
}

/** Return whether every word of `search` occurs in what the user reads of a signal. */
export function matches(info: SignalInfo, search: string): boolean {
  const text = [groupName(info.group), info.of, quantityName(info), info.id]
    .join(" ")
    .toLowerCase();
  return search
    .toLowerCase()
    .split(/\s+/)
    .every((word) => text.includes(word));
}

export function Picker({ index, pane }: PickerProps) {
  const [search, setSearch] = useState("");
  const found = [...shownSource.value.signals.value.values()].filter((info) =>
    matches(info, search),
  );
  const chosen = new Set(pane.map(({ id }) => id));
  const groups = GROUPS.map((group) => ({
    group,
    members: found.filter((info) => info.group === group),
  })).filter(({ members }) => members.length > 0);
  return (
    <div class="plots-picker">
      <input
        type="search"
        class="plots-search"
        aria-label={t("plots.search")}
        placeholder={t("plots.search")}
        value={search}
        data-testid="plots-search"
        onInput={(event) => {
          setSearch(event.currentTarget.value);
        }}
      />
      {groups.length === 0 && <p class="plots-hint">{t("plots.noneFound")}</p>}
      {groups.map(({ group, members }) => (
        <PickerGroup
          key={group}
          {...{ group, members, chosen, index }}
          isOpen={search !== "" || members.some(({ id }) => chosen.has(id))}
        />
      ))}
    </div>
  );
}

interface PickerGroupProps {
  group: Group;
  members: readonly SignalInfo[];
  chosen: ReadonlySet<string>;
  index: number;
  isOpen: boolean;
}

function PickerGroup({ group, members, chosen, index, isOpen }: PickerGroupProps) {
  const count = members.filter(({ id }) => chosen.has(id)).length;
  const isAll = count === members.length;
  return (
    <details open={isOpen} data-testid={`plots-group-${group}`}>
      <summary>
        {groupName(group)}
        <span class="plots-count">{count > 0 && `${String(count)} / `}</span>
        <span class="plots-count">{members.length}</span>
      </summary>
      <label class="plots-all">
        <input
          type="checkbox"
          checked={isAll}
          ref={(input) => {
            if (input) input.indeterminate = count > 0 && !isAll;
          }}
          data-testid={`plots-all-${group}`}
          onChange={() => {
            const ids = members.map(({ id }) => id);
            choose(index, ids, !isAll);
          }}
        />
        {t("plots.all")}
      </label>
      {members.map((info) => (
        <label key={info.id}>
          <input
            type="checkbox"
            checked={chosen.has(info.id)}
            data-testid={`plots-signal-${info.id}`}
            onChange={(event) => {
              choose(index, [info.id], event.currentTarget.checked);
            }}
          />
          <span class="name">{signalName(info)}</span>
        </label>
      ))}
    </details>
  );
}
