/** A pane: its signals with their values, and its chart. */
import { computed, untracked, useSignal, useSignalEffect } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { t } from "../i18n";
import { angleUnit } from "../units";
import { Button, IconButton } from "../ui/button";
import { CloseIcon, PlusIcon, TrashIcon } from "../ui/icons";
import { type Line, unitsOf } from "./chart";
import { onPlotKey } from "./gestures";
import { choose, layout, type Pane, removePane } from "./layout";
import { quantityName, signalName } from "./names";
import { Picker } from "./picker";
import { scaleOf } from "./quantities";
import { cursors, removeCursors, shownSource } from "./range";
import type { SignalSource } from "./signals";
import { withoutPrefix } from "../robots";
import { View } from "./view";

/** Return the signals of a pane that this robot has. */
export function linesOf(pane: Pane, source: SignalSource): Line[] {
  return pane.flatMap(({ id, colour }) => {
    const signal = source.signals.value.get(id);
    if (signal === undefined) return [];
    return [{ signal, colour, scale: scaleOf(signal.kind, angleUnit.value) }];
  });
}

/** The largest number of units in a pane: with as many axes, all panes align. */
const mostUnits = computed(() =>
  Math.max(
    1,
    ...layout.value.map((pane) => unitsOf(linesOf(pane, shownSource.value)).length),
  ),
);

/** What a pane gives to a picture of it. */
export interface Shown {
  readonly canvas: () => HTMLCanvasElement;
  readonly lines: readonly Line[];
}

interface PaneProps {
  index: number;
  pane: Pane;
  onShown: (index: number, shown: Shown | null) => void;
}

export function PlotPane({ index, pane, onShown }: PaneProps) {
  const host = useRef<HTMLDivElement>(null);
  const legend = useRef<HTMLDivElement>(null);
  const isPicking = useSignal(false);
  const newest = useSignal(pane);
  useEffect(() => {
    newest.value = pane;
  }, [pane]);
  const lines = linesOf(pane, shownSource.value);

  useSignalEffect(() => {
    if (!host.current || !legend.current) return undefined;
    const drawn = linesOf(newest.value, shownSource.value);
    const setup = {
      host: host.current,
      legend: legend.current,
      lines: drawn,
      axes: mostUnits.value,
    };
    // what it reads when it draws does not make another one
    const made = untracked(() => new View(setup));
    onShown(index, { canvas: () => made.canvas, lines: drawn });
    return () => {
      onShown(index, null);
      made.dispose();
    };
  });

  return (
    <section class="plots-pane" data-testid={`plots-pane-${String(index)}`}>
      <div class="plots-side">
        <div class="plots-tools">
          <Button
            aria-pressed={isPicking.value}
            data-testid={`plots-pick-${String(index)}`}
            onClick={() => {
              isPicking.value = !isPicking.value;
            }}
          >
            <PlusIcon />
            {t("plots.signals")}
          </Button>
          <span class="plots-space" />
          {layout.value.length > 1 && (
            <IconButton
              label={t("plots.removePane")}
              data-testid={`plots-remove-${String(index)}`}
              onClick={() => {
                removePane(index);
              }}
            >
              <TrashIcon />
            </IconButton>
          )}
        </div>
        {isPicking.value && <Picker index={index} pane={pane} />}
        <div class="plots-legend" ref={legend} hidden={isPicking.value}>
          <Legend index={index} lines={lines} />
        </div>
      </div>
      <div
        class="plots-chart"
        ref={host}
        role="img"
        tabIndex={0}
        aria-label={lines.map(({ signal }) => signalName(signal)).join(", ")}
        aria-keyshortcuts="ArrowLeft ArrowRight + - Enter Delete Home End"
        data-testid={index === 0 ? "plots-chart" : `plots-chart-${String(index)}`}
        onKeyDown={onPlotKey}
      />
    </section>
  );
}

function Legend({ index, lines }: { index: number; lines: readonly Line[] }) {
  const [a, b] = cursors.value;
  if (lines.length === 0) return <p class="plots-hint">{t("plots.empty")}</p>;
  return (
    <table>
      {a !== undefined && (
        <thead>
          <tr>
            <td />
            <th scope="col">A</th>
            {b !== undefined && <th scope="col">B</th>}
            {b !== undefined && <th scope="col">B − A</th>}
            <td>
              <IconButton
                label={t("plots.removeCursors")}
                data-testid={`plots-remove-cursors-${String(index)}`}
                onClick={removeCursors}
              >
                <CloseIcon />
              </IconButton>
            </td>
          </tr>
        </thead>
      )}
      <tbody>
        {a !== undefined && (
          <tr class="plots-times">
            <th scope="row">{t("plots.time")}</th>
            <td>{a.toFixed(3)} s</td>
            {b !== undefined && <td>{b.toFixed(3)} s</td>}
            {b !== undefined && <td>{(b - a).toFixed(3)} s</td>}
            <td />
          </tr>
        )}
        {lines.map((line) => (
          <LegendRow key={line.signal.id} index={index} line={line} />
        ))}
      </tbody>
    </table>
  );
}

function LegendRow({ index, line }: { index: number; line: Line }) {
  const { signal, colour } = line;
  const [a, b] = cursors.value;
  const shown = [
    ...(a === undefined ? ["now"] : ["a"]),
    ...(b === undefined ? [] : ["b", "difference"]),
  ];
  return (
    <tr data-colour={colour + 1}>
      <th scope="row" title={signalName(signal)}>
        <span class="plots-swatch" />
        {withoutPrefix(signal.of)} <small>{quantityName(signal)}</small>
      </th>
      {shown.map((cursor) => (
        <td key={cursor}>
          <output data-signal={signal.id} data-cursor={cursor} />
        </td>
      ))}
      <td>
        <IconButton
          label={t("plots.removeSignal", { name: signalName(signal) })}
          onClick={() => {
            choose(index, [signal.id], false);
          }}
        >
          <CloseIcon />
        </IconButton>
      </td>
    </tr>
  );
}
