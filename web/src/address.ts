/** The address of the server: the origin of this page, with the token of its address. */

function withToken(url: URL): URL {
  const token = new URLSearchParams(window.location.search).get("token");
  if (token !== null) url.searchParams.set("token", token);
  return url;
}

/** Return the address of a path on the server, such as `view.robot.urdf`. */
export function serverUrl(path: string): string {
  return withToken(new URL(path, window.location.origin)).href;
}

export function socketUrl(): string {
  const url = new URL("/ws", window.location.origin);
  url.protocol = url.protocol === "https:" ? "wss:" : "ws:";
  return withToken(url).href;
}
