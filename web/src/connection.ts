/** The one WebSocket: it writes the store, answers requests, and comes back by itself. */
import { socketUrl, serverUrl } from "./address";
import { frames } from "./frames";
import { t } from "./i18n";
import { parseMessage, PROTOCOL } from "./messages";
import type { RequestMessage, StreamMessage } from "./messages";
import { forgetNotices, tell, tellNotice } from "./notices";
import type { Problem, Reply, ServerMessage } from "./protocol";
import { connectionState, hello, scene, status } from "./store";

export const BACKOFF_MS = [250, 500, 1000, 2000] as const;
/** Between two messages of a stream: the display's rate would be more than arms follow. */
export const STREAM_INTERVAL_MS = 33;
/** More than this unsent [bytes], and the network is behind: then newer ones only. */
const MAX_BUFFERED = 16_384;
const ANSWER_WITHIN_MS = 15_000;
/** Codes of a close by which a server says that it does not want this page. */
const REFUSALS: readonly number[] = [1008, 4401, 4403];

export class Connection {
  private socket: WebSocket | null = null;
  private attempts = 0;
  private retry: ReturnType<typeof setTimeout> | undefined;
  private nextId = 1;
  private readonly waiting = new Map<number, (problem: Problem | null) => void>();
  private readonly streams = new Map<string, StreamMessage>();
  private streamTimer: ReturnType<typeof setTimeout> | undefined;
  private streamedAt = -Infinity;

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

  /** Ask for something; the answer is why it was refused, or null if it was done. */
  request(message: RequestMessage): Promise<Problem | null> {
    if (connectionState.value !== "open") return Promise.resolve(lostProblem());
    const id = this.nextId++;
    return new Promise((resolve) => {
      const timer = setTimeout(() => {
        this.waiting.delete(id);
        resolve({ kind: "NoAnswer", message: t("connection.noAnswer") });
      }, ANSWER_WITHIN_MS);
      this.waiting.set(id, (problem) => {
        clearTimeout(timer);
        resolve(problem);
      });
      this.socket?.send(JSON.stringify({ ...message, id }));
    });
  }

  /** Send the newest of a stream, as soon as it is its turn; never after a disconnect. */
  stream(message: StreamMessage): void {
    if (connectionState.value !== "open") return;
    const key = message.type === "steer" ? `steer ${message.controller}` : message.type;
    const unsent = this.streams.get(key);
    this.streams.set(key, unsent ? merged(unsent, message) : message);
    this.scheduleStreams();
  }

  /** Forget what of a stream was not sent yet. */
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
    for (const message of newest) this.socket.send(JSON.stringify(message));
  }

  private receive(data: unknown): void {
    const message = parseMessage(data);
    if (message === undefined) tell("error", t("connection.malformed"));
    else this.take(message);
  }

  private take(message: ServerMessage): void {
    if (connectionState.value === "outdated") return;
    switch (message.type) {
      case "hello":
        if (message.protocol !== PROTOCOL) {
          connectionState.value = "outdated";
          return;
        }
        this.attempts = 0;
        frames.clear();
        status.value = null;
        scene.value = null;
        hello.value = message;
        forgetNotices(message.notices);
        connectionState.value = "open";
        return;
      case "scene":
        scene.value = message;
        return;
      case "status":
        status.value = message;
        return;
      case "frame":
        if (message.position.length === hello.value?.robot.joints.length) {
          frames.push(message);
        }
        return;
      case "notice":
        tellNotice(message);
        return;
      case "reply":
        this.answered(message);
    }
  }

  private answered(reply: Reply): void {
    const waiting = reply.id === null ? undefined : this.waiting.get(reply.id);
    if (reply.id !== null) this.waiting.delete(reply.id);
    if (waiting) waiting(reply.error ?? null);
    else if (reply.error) tell("error", reply.error.message);
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
    if (hello.value !== null) connectionState.value = "lost";
    if (neverOpen) void this.askWhetherRefused();
    const wait = BACKOFF_MS[Math.min(this.attempts, BACKOFF_MS.length - 1)];
    this.attempts += 1;
    this.retry = setTimeout(() => {
      this.open();
    }, wait);
  }

  /** A browser does not tell why a WebSocket was not opened, but it tells a page's status. */
  private async askWhetherRefused(): Promise<void> {
    try {
      const answer = await fetch(serverUrl(hello.value?.robot.urdf ?? "/robot.urdf"), {
        method: "HEAD",
      });
      if (answer.status !== 401 && answer.status !== 403) return;
      if (connectionState.value === "open") return;
      this.close();
      connectionState.value = "refused";
    } catch {
      // nobody there: the next attempt is on its way
    }
  }

  /** What was asked has no answer any more, and what was not sent will not be. */
  private abandon(): void {
    this.streams.clear();
    clearTimeout(this.streamTimer);
    this.streamTimer = undefined;
    this.streamedAt = -Infinity;
    const waiting = [...this.waiting.values()];
    this.waiting.clear();
    for (const answer of waiting) answer(lostProblem());
  }
}

/** Return what `newer` says, and what `older` says of other joints. */
function merged(older: StreamMessage, newer: StreamMessage): StreamMessage {
  return { ...newer, positions: { ...older.positions, ...newer.positions } };
}

function lostProblem(): Problem {
  return { kind: "ConnectionLost", message: t("connection.notSent") };
}

export const connection = new Connection();

/** Ask for something, and tell the person if it was refused.  Returns the refusal. */
export async function ask(message: RequestMessage): Promise<Problem | null> {
  const problem = await connection.request(message);
  if (problem !== null) tell("error", problem.message);
  return problem;
}
