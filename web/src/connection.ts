/** The one WebSocket: it fills the store, carries requests, and reconnects by itself. */
import { signal } from "@preact/signals";
import { socketUrl, serverUrl } from "./address";
import { neededForces } from "./forces";
import { frames } from "./frames";
import { t } from "./i18n";
import { parseMessage, PROTOCOL } from "./messages";
import type { Method, Params, PostedMethod, Received, StreamMethod } from "./messages";
import { replaceNotices, report, showNotice } from "./notices";
import type { ErrorInfo, Reply, Requests, Responses } from "./protocol";
import { SILENT_AFTER_MS } from "./silence";
import { connectionState, view, scene, status } from "./store";

export const BACKOFF_MS = [250, 500, 1000, 2000] as const;
/** Between two messages of a stream: the display's rate would be more than arms follow. */
export const STREAM_INTERVAL_MS = 33;
/** With more than this unsent [bytes] the network is slow: only newer ones are sent. */
const MAX_BUFFERED = 16_384;
const ANSWER_TIMEOUT_MS = 15_000;
/** Close codes with which a server refuses this page. */
const REFUSALS: readonly number[] = [1008, 4401, 4403];

/** How many streamed setpoints the server has refused. */
export const refusals = signal(0);

/** How many goals of this page ended otherwise than there. */
export const unreached = signal(0);

interface StreamedSetpoint<M extends StreamMethod = StreamMethod> {
  readonly method: M;
  readonly params: Requests[M];
}

interface Refusal {
  readonly problem: ErrorInfo;
}
/** The response to a request, or why there is none. */
export type Answer<M extends Method> =
  { readonly problem: null; readonly result: Responses[M] } | Refusal;

export class Connection {
  private socket: WebSocket | null = null;
  private attempts = 0;
  private retry: ReturnType<typeof setTimeout> | undefined;
  private nextId = 1;
  private readonly waiting = new Map<number, (answer: Answer<Method>) => void>();
  private readonly streams = new Map<string, StreamedSetpoint>();
  private streamTimer: ReturnType<typeof setTimeout> | undefined;
  private streamedAt = -Infinity;
  private isSubscribed = false;

  /** Connect, or connect again at once. */
  open(): void {
    this.close();
    const socket = new WebSocket(socketUrl());
    this.socket = socket;
    if (connectionState.value === "refused") connectionState.value = "connecting";
    socket.addEventListener("message", (event) => {
      if (socket === this.socket) this.receive(event.data);
    });
    socket.addEventListener("close", (event) => {
      if (socket === this.socket) this.ended(event.code);
    });
  }

  close(): void {
    clearTimeout(this.retry);
    const socket = this.socket;
    this.socket = null;
    socket?.close();
    this.abandon();
  }

  /** Send a request; the result is why it was refused, or null if it was done. */
  async request<M extends Method>(
    method: M,
    ...params: Params<M>
  ): Promise<ErrorInfo | null> {
    return (await this.ask(method, ...params)).problem;
  }

  /** Send a request for its response. */
  ask<M extends Method>(method: M, ...[params]: Params<M>): Promise<Answer<M>> {
    if (connectionState.value !== "open") return Promise.resolve(lost());
    const id = this.nextId++;
    return new Promise((resolve) => {
      const timer = setTimeout(() => {
        this.waiting.delete(id);
        resolve({
          problem: { type: "NoAnswer", message: t("connection.noAnswer") },
        });
      }, ANSWER_TIMEOUT_MS);
      this.waiting.set(id, (answer) => {
        clearTimeout(timer);
        resolve(answer as Answer<M>);
      });
      this.socket?.send(JSON.stringify({ id, method, params }));
    });
  }

  /** Send the newest setpoint of a stream at the next interval; never after a disconnect. */
  stream<M extends StreamMethod>(method: M, params: Requests[M]): void {
    if (connectionState.value !== "open") return;
    const key = "controller" in params ? `${method} ${params.controller}` : method;
    const positions = {
      ...this.streams.get(key)?.params.positions,
      ...params.positions,
    };
    this.streams.set(key, { method, params: { ...params, positions } });
    this.scheduleStreams();
  }

  /** Send a request that has no answer unless it is refused; drop it while the network is slow. */
  post<M extends PostedMethod>(method: M, params: Requests[M]): void {
    if (connectionState.value !== "open" || this.socket === null) return;
    if (this.socket.bufferedAmount > MAX_BUFFERED) return;
    this.socket.send(JSON.stringify({ method, params }));
  }

  /** Return whether the server may not have read all that this page sent to it. */
  mayBeOnItsWay(): boolean {
    const isRecent = performance.now() - this.streamedAt < 2 * SILENT_AFTER_MS;
    return this.waiting.size > 0 || isRecent;
  }

  /** Drop the setpoints that were not sent yet. */
  dropStreams(): void {
    this.streams.clear();
  }

  private scheduleStreams(): void {
    if (this.streamTimer !== undefined) return;
    const wait = this.streamedAt + STREAM_INTERVAL_MS - performance.now();
    if (wait <= 0) {
      this.flushStreams();
      return;
    }
    this.streamTimer = setTimeout(() => {
      this.streamTimer = undefined;
      this.flushStreams();
    }, wait);
  }

  private flushStreams(): void {
    if (this.streams.size === 0 || this.socket === null) return;
    this.streamedAt = performance.now();
    if (this.socket.bufferedAmount > MAX_BUFFERED) {
      this.scheduleStreams();
      return;
    }
    const newest = [...this.streams.values()];
    this.streams.clear();
    for (const setpoint of newest) this.socket.send(JSON.stringify(setpoint));
  }

  /** Let the server know which forces the frames shall have. */
  changeForces(): void {
    if (this.isSubscribed) this.subscribe();
  }

  private subscribe(): void {
    const params = neededForces.peek();
    const id = this.nextId++;
    this.socket?.send(JSON.stringify({ id, method: "subscribe_view", params }));
  }

  private receive(data: unknown): void {
    const message = parseMessage(data);
    if (message === undefined) report("error", t("connection.malformed"));
    else this.take(message);
  }

  private take(message: Received): void {
    if (connectionState.value === "outdated") return;
    switch (message.type) {
      case "hello":
        if (message.protocol !== PROTOCOL) {
          connectionState.value = "outdated";
          return;
        }
        this.isSubscribed = true;
        this.subscribe();
        return;
      case "view":
        this.attempts = 0;
        frames.clear();
        status.value = null;
        scene.value = null;
        view.value = message;
        replaceNotices(message.notices);
        connectionState.value = "open";
        return;
      case "scene":
        scene.value = message;
        return;
      case "status":
        status.value = message;
        return;
      case "state":
        if (message.position.length === view.value?.robot.joints.length) {
          frames.push(message);
        }
        return;
      case "notice":
        showNotice(message);
        return;
      case "goal_finished":
        if (message.outcome.status !== "SUCCEEDED") unreached.value += 1;
        return;
      case "reply":
        this.answered(message);
    }
  }

  private answered(reply: Reply): void {
    const waiting =
      typeof reply.id === "number" ? this.waiting.get(reply.id) : undefined;
    if (typeof reply.id === "number") this.waiting.delete(reply.id);
    if (waiting) {
      const { error, result } = reply;
      waiting(
        error
          ? { problem: error }
          : { problem: null, result: result as Responses[Method] },
      );
    } else if (reply.error) {
      report("error", reply.error.message);
      refusals.value += 1;
    }
  }

  private ended(code: number): void {
    const neverOpen = connectionState.value !== "open";
    this.socket = null;
    this.abandon();
    if (connectionState.value === "outdated") return;
    if (REFUSALS.includes(code)) {
      connectionState.value = "refused";
      return;
    }
    if (view.value !== null) connectionState.value = "lost";
    if (neverOpen) void this.checkWhetherRefused();
    const wait = BACKOFF_MS[Math.min(this.attempts, BACKOFF_MS.length - 1)];
    this.attempts += 1;
    this.retry = setTimeout(() => {
      this.open();
    }, wait);
  }

  /** A browser hides why a WebSocket was not opened, but shows the status of a page. */
  private async checkWhetherRefused(): Promise<void> {
    try {
      const answer = await fetch(serverUrl(view.value?.robot.urdf ?? "/robot.urdf"), {
        method: "HEAD",
      });
      if (answer.status !== 401 && answer.status !== 403) return;
      if (connectionState.value === "open") return;
      this.close();
      connectionState.value = "refused";
    } catch {
      // no server: the next attempt follows
    }
  }

  /** Fail the requests that wait, and drop the setpoints that were not sent. */
  private abandon(): void {
    this.isSubscribed = false;
    this.streams.clear();
    clearTimeout(this.streamTimer);
    this.streamTimer = undefined;
    this.streamedAt = -Infinity;
    const waiting = [...this.waiting.values()];
    this.waiting.clear();
    for (const answer of waiting) answer(lost());
  }
}

function lost(): Refusal {
  return { problem: { type: "ConnectionLost", message: t("connection.notSent") } };
}

export const connection = new Connection();

neededForces.subscribe(() => {
  connection.changeForces();
});

/** Send a request, report a refusal to the user, and return it. */
export async function sendRequest<M extends Method>(
  method: M,
  ...params: Params<M>
): Promise<ErrorInfo | null> {
  const problem = await connection.request(method, ...params);
  if (problem !== null) report("error", problem.message);
  return problem;
}
