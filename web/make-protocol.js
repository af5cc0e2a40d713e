/* Write src/protocol.ts: the protocol as types, from protocol.schema.json. */
import { readFile, writeFile } from "node:fs/promises";
import { compile } from "json-schema-to-typescript";

/** Return the schema with tuples as its compiler knows them, which is draft 4's way. */
function withOldTuples(part) {
  if (Array.isArray(part)) return part.map(withOldTuples);
  if (part === null || typeof part !== "object") return part;
  const { prefixItems, ...rest } = Object.fromEntries(
    Object.entries(part).map(([key, value]) => [key, withOldTuples(value)]),
  );
  return prefixItems ? { ...rest, items: prefixItems, additionalItems: false } : rest;
}

const schema = JSON.parse(await readFile("protocol.schema.json", "utf8"));
const types = await compile(withOldTuples(schema), "Protocol", {
  additionalProperties: false,
  bannerComment:
    "/* Made from protocol.schema.json by make-protocol.js: do not edit. */",
});
await writeFile("src/protocol.ts", types);
