/** Numbers that follow the robot, thirty times a second, past Preact: straight into the page. */
import { useEffect, useLayoutEffect, useRef } from "preact/hooks";
import { shown } from "./frames";
import type { Frame } from "./messages";

const INTERVAL_MS = 33;

type Follower = (frame: Frame) => void;

const followers = new Set<Follower>();
let drawnAt = -Infinity;
let due = false;

shown.listen(() => {
  if (due || followers.size === 0) return;
  due = true;
  requestAnimationFrame(draw);
});

function draw(now: number): void {
  if (now - drawnAt < INTERVAL_MS - 2) {
    requestAnimationFrame(draw);
    return;
  }
  due = false;
  drawnAt = now;
  const frame = shown.latest;
  if (frame) for (const follower of followers) follower(frame);
}

/** Call `follower` with the newest frame at most thirty times a second, and after each render. */
export function useLive(follower: Follower): void {
  const newest = useRef(follower);
  newest.current = follower;
  useLayoutEffect(() => {
    const frame = shown.latest;
    if (frame) newest.current(frame);
  });
  useEffect(() => {
    const call: Follower = (frame) => {
      newest.current(frame);
    };
    followers.add(call);
    return () => {
      followers.delete(call);
    };
  }, []);
}
