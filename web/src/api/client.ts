/**
 * The typed client of the REST API. Every failure becomes an `ApiError` whose message is the API's own sentence, so that
 * whoever catches it can show it as it is.
 */
import createClient from "openapi-fetch";
import type { paths } from "./schema.gen";

/** Changes by cookie need this header: a foreign page cannot send it. */
export const api = createClient<paths>({ headers: { "X-Lilliput": "1" } });

/** `status` 0 means that nobody answered. `fields` has the message per refused field of a form. */
export class ApiError extends Error {
  constructor(
    readonly status: number,
    message: string,
    readonly fields: Readonly<Record<string, string>> = {},
  ) {
    super(message);
  }
}

interface Answer<T> {
  readonly data?: T;
  readonly error?: unknown;
  readonly response: Response;
}

/** The answer's data; throws ApiError. */
export async function call<T>(request: Promise<Answer<T>>): Promise<T> {
  let answer: Answer<T>;
  try {
    answer = await request;
  } catch {
    throw new ApiError(0, "The server does not answer.");
  }
  if (answer.response.ok) return answer.data as T;
  throw describeFailure(answer.response.status, answer.error);
}

/** FastAPI's two forms of an error body: a sentence, or a list with one entry per refused field. */
export function describeFailure(status: number, body: unknown): ApiError {
  const detail = typeof body === "object" && body !== null && "detail" in body ? body.detail : undefined;
  if (typeof detail === "string" && detail !== "") return new ApiError(status, detail);
  if (!Array.isArray(detail)) return new ApiError(status, `The server answered ${status}.`);
  const fields: Record<string, string> = {};
  for (const entry of detail as { loc?: unknown[]; msg?: unknown }[]) {
    const where = (entry.loc ?? []).filter((part) => part !== "body").join(".");
    fields[where] = String(entry.msg);
  }
  const message = Object.entries(fields).map(([where, text]) => (where ? `${where}: ${text}` : text));
  return new ApiError(status, message.join("; "), fields);
}
