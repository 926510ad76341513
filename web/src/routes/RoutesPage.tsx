/** Waypoints and routes: what robots can be sent along. */
import { SimpleGrid } from "@mantine/core";
import { Page } from "../ui/Page";
import { RouteList } from "./RouteList";
import { WaypointTable } from "./WaypointTable";

export default function RoutesPage() {
  return (
    <Page title="Routes" note="Waypoints are places on the floor; a route is the order in which a robot visits them.">
      <SimpleGrid cols={{ base: 1, lg: 2 }} spacing="lg">
        <RouteList />
        <WaypointTable />
      </SimpleGrid>
    </Page>
  );
}
