/** Users who log in, and tokens by which programs and robots do. For administrators. */
import { SimpleGrid, Text } from "@mantine/core";
import { useMay } from "../app/session";
import { Page } from "../ui/Page";
import { TokenSection } from "./TokenSection";
import { UserSection } from "./UserSection";

export default function AdminPage() {
  const may = useMay("admin");
  return (
    <Page
      title="Users and tokens"
      note="Viewers look, operators drive and change, administrators also manage this page."
    >
      {may ? (
        <SimpleGrid cols={{ base: 1, lg: 2 }} spacing="lg">
          <UserSection />
          <TokenSection />
        </SimpleGrid>
      ) : (
        <Text c="dimmed">Only administrators manage users and tokens.</Text>
      )}
    </Page>
  );
}
