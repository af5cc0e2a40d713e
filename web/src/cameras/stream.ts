/** Images of a camera, one after the other: the next is requested when one is shown. */
import { serverUrl } from "../address";
import type { ImageKind } from "./state";

/** Shortest interval between images [ms]. */
const INTERVAL_MS = 33;
/** Interval between questions while nothing moves [ms]. */
const STILL_MS = 100;
/** Interval between attempts after a failure [ms]. */
const RETRY_MS = 2000;

export interface CameraView {
  readonly name: string;
  readonly kind: ImageKind;
  /** [px] */
  readonly width: number;
}

export interface Image {
  readonly bitmap: ImageBitmap;
  /** Simulated time [s]. */
  readonly time: number;
}

export interface StreamListener {
  readonly onImage: (image: Image) => void;
  readonly onFailure: (reason: string) => void;
}

export class CameraStream {
  private readonly aborted = new AbortController();
  /** Number of the newest image; 0 for none. */
  private number = 0;

  /** Start; `end` ends it. */
  constructor(
    private readonly view: CameraView,
    private readonly listener: StreamListener,
  ) {
    void this.run();
  }

  end(): void {
    this.aborted.abort();
  }

  private async run(): Promise<void> {
    const { signal } = this.aborted;
    while (!signal.aborted) {
      await visibility(signal);
      const startedAt = performance.now();
      const interval = await this.next();
      await pause(interval - (performance.now() - startedAt), signal);
    }
  }

  /** Show the next image, if there is one; return when to request another [ms]. */
  private async next(): Promise<number> {
    const { signal } = this.aborted;
    const { name, kind, width } = this.view;
    const path = `/cameras/${encodeURIComponent(name)}/${kind}`;
    const query = `?width=${String(width)}&after=${String(this.number)}`;
    try {
      const answer = await fetch(serverUrl(path + query), { signal });
      if (answer.status === 204) return STILL_MS;
      if (!answer.ok) {
        this.listener.onFailure((await answer.text()).trim());
        return RETRY_MS;
      }
      const bitmap = await createImageBitmap(await answer.blob(), {
        colorSpaceConversion: "none",
      });
      if (signal.aborted) return 0;
      this.number = Number(answer.headers.get("x-image-number"));
      const time = Number(answer.headers.get("x-image-time"));
      this.listener.onImage({ bitmap, time });
      bitmap.close();
      return INTERVAL_MS;
    } catch (reason) {
      if (!signal.aborted) this.listener.onFailure(String(reason));
      return RETRY_MS;
    }
  }
}

function pause(duration: number, signal: AbortSignal): Promise<void> {
  return new Promise((resolve) => {
    const end = () => {
      clearTimeout(timer);
      signal.removeEventListener("abort", end);
      resolve();
    };
    const timer = setTimeout(end, Math.max(0, duration));
    signal.addEventListener("abort", end);
  });
}

/** Wait until the page can be seen. */
function visibility(signal: AbortSignal): Promise<void> {
  if (!document.hidden) return Promise.resolve();
  return new Promise((resolve) => {
    const end = () => {
      document.removeEventListener("visibilitychange", end);
      signal.removeEventListener("abort", end);
      resolve();
    };
    document.addEventListener("visibilitychange", end);
    signal.addEventListener("abort", end);
  });
}
