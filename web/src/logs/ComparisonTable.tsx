/** The table of the reports: per stage and run min, Q1, median, Q3, max without outliers, with the change in percent. */
import { Table, Text } from "@mantine/core";
import { colorOf } from "./charts";
import {
  changePercent,
  formatChange,
  formatMs,
  QUANTITIES,
  TITLES,
  type Comparison,
  type Quantity,
} from "./comparison";

interface ComparisonTableProps {
  readonly comparisons: readonly Comparison[];
  readonly labels: readonly string[];
}

export function ComparisonTable({ comparisons, labels }: ComparisonTableProps) {
  return (
    <Table.ScrollContainer minWidth={760}>
      <Table verticalSpacing={4} fz="sm" data-testid="timings-table">
        <Table.Thead>
          <Table.Tr>
            <Table.Th>Stage, ms</Table.Th>
            <Table.Th>Run</Table.Th>
            {QUANTITIES.map((quantity) => (
              <Table.Th key={quantity} ta="right">
                {TITLES[quantity]}
              </Table.Th>
            ))}
            <Table.Th ta="right">p99</Table.Th>
            <Table.Th ta="right">outliers</Table.Th>
            <Table.Th ta="right">frames</Table.Th>
          </Table.Tr>
        </Table.Thead>
        <Table.Tbody>
          {comparisons.flatMap((comparison) =>
            comparison.runs.map(({ run, box }, index) => (
              <Table.Tr key={`${comparison.kind} ${comparison.stage} ${run}`}>
                <Table.Td fw={600}>{index === 0 && `${comparison.kind} ${comparison.stage}`}</Table.Td>
                <Table.Td>
                  <Text span c={colorOf(index)} fw={700} aria-hidden>
                    ■
                  </Text>{" "}
                  {labels[index]}
                </Table.Td>
                {QUANTITIES.map((quantity) => (
                  <Table.Td key={quantity} ta="right" style={{ fontVariantNumeric: "tabular-nums" }}>
                    {box ? formatMs(box[quantity]) : "–"}
                    <Change comparison={comparison} index={index} quantity={quantity} />
                  </Table.Td>
                ))}
                <Table.Td ta="right">{box ? formatMs(box.p99) : "–"}</Table.Td>
                <Table.Td ta="right">{box ? box.outliers.toLocaleString("en-GB") : "–"}</Table.Td>
                <Table.Td ta="right">{box ? box.count.toLocaleString("en-GB") : "–"}</Table.Td>
              </Table.Tr>
            )),
          )}
        </Table.Tbody>
      </Table>
    </Table.ScrollContainer>
  );
}

interface ChangeProps {
  readonly comparison: Comparison;
  readonly index: number;
  readonly quantity: Quantity;
}

function Change({ comparison, index, quantity }: ChangeProps) {
  const change = changePercent(comparison, index, quantity);
  if (change === null) return null;
  return (
    <Text size="xs" c={change > 5 ? "red" : change < -5 ? "teal" : "dimmed"}>
      {formatChange(change)}
    </Text>
  );
}
