/** Fewer samples for a picture, without losing peaks. */
import type { Samples } from "./signals";

/**
 * Return at most about `points` samples: of consecutive ones, the least and the greatest of
 * each signal in the order in which they occurred.
 */
export function thinned(samples: Samples, points: number): Samples {
  const { times, values } = samples;
  const bucket = Math.ceil(times.length / Math.max(1, Math.floor(points / 2)));
  if (times.length <= points || bucket < 3) return samples;
  const kept: number[] = [];
  const rows = values.map((): (number | null)[] => []);
  for (let start = 0; start < times.length; start += bucket) {
    const end = Math.min(times.length, start + bucket);
    kept.push(times[start] ?? 0);
    if (end - start > 1) kept.push(times[end - 1] ?? 0);
    values.forEach((row, i) => {
      rows[i]?.push(...extremes(row, start, end));
    });
  }
  return { times: kept, values: rows };
}

/** Return the least and greatest of a row from `start` to before `end`, as they occurred. */
function extremes(
  row: readonly (number | null)[],
  start: number,
  end: number,
): (number | null)[] {
  if (end - start === 1) return [row[start] ?? null];
  let [least, most] = [-1, -1];
  for (let i = start; i < end; i++) {
    const value = row[i] ?? null;
    if (value === null) continue;
    if (least < 0 || value < (row[least] ?? 0)) least = i;
    if (most < 0 || value > (row[most] ?? 0)) most = i;
  }
  if (least < 0) return [null, null];
  const [first, second] = least <= most ? [least, most] : [most, least];
  return [row[first] ?? null, row[second] ?? null];
}
