/* Write src/protocol.ts: the panel's protocol as types, from protocol.schema.json. */
import { writeFile } from "node:fs/promises";
import { compileFromFile } from "json-schema-to-typescript";

const types = await compileFromFile("protocol.schema.json", {
  additionalProperties: false,
  bannerComment:
    "/* Made from protocol.schema.json by make-protocol.js: do not edit. */",
});
await writeFile("src/protocol.ts", types);
