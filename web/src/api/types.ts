/** The API's types, all generated; here they get the names that the console uses. */
export type * from "./schema.gen";
