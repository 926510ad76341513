/** The frame of a page: its title (also of the browser's tab), what may be done, and the content. */
import { Group, Stack, Text, Title } from "@mantine/core";
import { useDocumentTitle } from "@mantine/hooks";
import type { ReactNode } from "react";
import { useLab } from "../app/lab";

interface PageProps {
  readonly title: string;
  readonly note?: ReactNode;
  readonly actions?: ReactNode;
  readonly children: ReactNode;
}

export function usePageTitle(title: string): void {
  const lab = useLab();
  useDocumentTitle(lab ? `${title} · ${lab.name} · Lilliput` : `${title} · Lilliput`);
}

export function Page({ title, note, actions, children }: PageProps) {
  usePageTitle(title);
  return (
    <Stack p={{ base: "sm", sm: "lg" }} gap="md" maw={1440} mx="auto">
      <Group justify="space-between" align="flex-end" gap="sm">
        <div>
          <Title order={1} fz="h3">
            {title}
          </Title>
          {note !== undefined && (
            <Text size="sm" c="dimmed">
              {note}
            </Text>
          )}
        </div>
        {actions}
      </Group>
      {children}
    </Stack>
  );
}
