/** Tables: numbers as typed arrays, row by row. */

export type Floats = Float32Array;

/** A table of numbers, row by row; NaN where something is unknown. */
export interface Table {
  readonly values: Floats;
  readonly shape: readonly number[];
}

/** One row of a table. */
export function row(table: Table, index: number): Floats {
  const width = table.values.length / Math.max(1, table.shape[0]);
  return table.values.subarray(index * width, (index + 1) * width);
}
