/**
 * Writes the TypeScript types of the server's API.
 *
 *   npm run generate -- [DESCRIPTION] [-o OUTPUT]
 *
 * DESCRIPTION is a file with the OpenAPI document (default: $OPENAPI_JSON, else standard input), OUTPUT the file to write
 * (default: src/api/schema.gen.ts).
 */
import { readFile, writeFile } from "node:fs/promises";
import { fileURLToPath } from "node:url";
import { parseArgs } from "node:util";
import openapiTS, { astToString } from "openapi-typescript";

const HEADER = "// Generated from the server's OpenAPI description by `npm run generate`; do not edit.\n\n";

const { values, positionals } = parseArgs({
  allowPositionals: true,
  options: { output: { type: "string", short: "o" } },
});
const source = positionals[0] ?? process.env.OPENAPI_JSON ?? "/dev/stdin";
const output = values.output ?? fileURLToPath(new URL("../src/api/schema.gen.ts", import.meta.url));

const description = JSON.parse(await readFile(source, "utf8"));
const types = await openapiTS(description, {
  defaultNonNullable: true,
  rootTypes: true,
  rootTypesNoSchemaPrefix: true,
});
await writeFile(output, HEADER + astToString(types));
