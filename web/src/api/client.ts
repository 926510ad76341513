/**
 * The typed client of the REST API: paths, parameters, bodies and answers are those of the generated schema. Every failure
 * becomes an `ApiError` whose message is the API's own sentence, so that whoever catches it can show it as it is.
 */
import type { paths } from "./schema.gen";

type Method = "get" | "put" | "post" | "delete";

/** The paths that know a method. */
type PathWith<M extends Method> = {
  [P in keyof paths]: paths[P] extends Record<M, object> ? P : never;
}[keyof paths];

type Operation<M extends Method, P extends keyof paths> = NonNullable<paths[P][M]>;
type Json<T> = T extends { content: { "application/json": infer Body } } ? Body : never;
/** Parameters of one place (path, query): as the schema has them, absent where it has none. */
type Parameters<O, Where extends string> = O extends { parameters: infer All extends Partial<Record<Where, unknown>> }
  ? Pick<All, Where>
  : Partial<Record<Where, undefined>>;
type BodyOf<O> = O extends { requestBody: infer Body } ? { body: Json<NonNullable<Body>> } : { body?: undefined };
type Request<O> = BodyOf<O> & Parameters<O, "path"> & Parameters<O, "query">;
/** The third argument of `call`, which may be left out when nothing in it is needed. */
type RequestArgument<O> = Partial<Request<O>> extends Request<O> ? [request?: Request<O>] : [request: Request<O>];
type Answer<O> = O extends { responses: infer Responses }
  ? Json<Responses extends { 200: infer Ok } ? Ok : Responses extends { 201: infer Made } ? Made : never>
  : never;

/** Any request, as it is once its types have been checked. */
interface Loose {
  readonly body?: unknown;
  readonly path?: Readonly<Record<string, string>>;
  readonly query?: Readonly<Record<string, string | number>>;
}

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

/** Not `randomUUID`, which browsers have on HTTPS and on localhost alone. */
const TAB = Array.from(crypto.getRandomValues(new Uint8Array(12)), (byte) => byte.toString(16).padStart(2, "0")).join(
  "",
);

type Call = <M extends Method, P extends PathWith<M>>(
  method: M,
  path: P,
  ...request: RequestArgument<Operation<M, P>>
) => Promise<Answer<Operation<M, P>>>;

/** Sends a request and gives the answer's body (undefined when it has none); throws ApiError. */
export const call = send as Call;

async function send(method: string, path: string, { body, path: values, query }: Loose = {}): Promise<unknown> {
  const address = path.replace(/\{(\w+)\}/g, (_, name: string) => encodeURIComponent(values?.[name] ?? ""));
  let response: Response;
  try {
    response = await fetch(address + searchOf(query), {
      method: method.toUpperCase(),
      // Changes by cookie need the first header: a foreign page cannot send it. The second tells the hand on a robot's
      // stick from that of another tab.
      headers: {
        "X-Lilliput": "1",
        "X-Lilliput-Tab": TAB,
        ...(body !== undefined && { "Content-Type": "application/json" }),
      },
      ...(body !== undefined && { body: JSON.stringify(body) }),
    });
  } catch {
    throw new ApiError(0, "The server does not answer.");
  }
  const answer: unknown = await response.json().catch(() => undefined);
  if (!response.ok) throw describeFailure(response.status, answer);
  return answer;
}

function searchOf(query: Loose["query"]): string {
  const pairs = Object.entries(query ?? {}).map(([name, value]) => `${name}=${encodeURIComponent(value)}`);
  return pairs.length > 0 ? `?${pairs.join("&")}` : "";
}

/** FastAPI's two forms of an error body: a sentence, or a list with one entry per refused field. */
export function describeFailure(status: number, body: unknown): ApiError {
  const detail = typeof body === "object" && body !== null && "detail" in body ? body.detail : undefined;
  if (typeof detail === "string" && detail !== "") return new ApiError(status, detail);
  if (!Array.isArray(detail)) return new ApiError(status, `The server answered ${status}.`);
  const fields: Record<string, string> = {};
  for (const { loc = [], msg } of detail as { loc?: unknown[]; msg?: unknown }[])
    fields[loc.filter((part) => part !== "body").join(".")] = String(msg);
  const sentences = Object.entries(fields).map(([where, text]) => (where ? `${where}: ${text}` : text));
  return new ApiError(status, sentences.join("; "), fields);
}
