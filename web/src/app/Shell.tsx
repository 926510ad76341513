/** What surrounds every page: lab, connection, health, the emergency stop, the pages, and the live stream behind it. */
import { AppShell, Center, Group, Loader, Text } from "@mantine/core";
import { useMediaQuery } from "@mantine/hooks";
import { Suspense, useEffect } from "react";
import { Link, Outlet } from "react-router";
import { startLive } from "../live/start";
import { useLive } from "../live/store";
import { ConnectionState } from "./ConnectionState";
import { BANNER_HEIGHT, EmergencyStopBanner } from "./EmergencyStopBanner";
import { EmergencyStopButton } from "./EmergencyStopButton";
import { HealthChip } from "./HealthChip";
import { startFetchingLab, useLab } from "./lab";
import { Navigation } from "./Navigation";
import classes from "./shell.module.css";
import { UserMenu } from "./UserMenu";

const HEADER_HEIGHT = 56;

export function Shell() {
  const lab = useLab();
  const estop = useLive((live) => live.state.estop);
  const isPhone = useMediaQuery("(max-width: 48em)", false, { getInitialValueInEffect: false });
  useEffect(startFetchingLab, []);
  useEffect(startLive, []);

  const engaged = estop?.engaged === true;
  return (
    <AppShell
      header={{ height: HEADER_HEIGHT + (engaged ? BANNER_HEIGHT : 0) }}
      navbar={{ width: 76, breakpoint: "sm", collapsed: { mobile: true } }}
      footer={{ height: isPhone ? 58 : 0, collapsed: !isPhone }}
      transitionDuration={0}
    >
      <AppShell.Header>
        <Group h={HEADER_HEIGHT} px="sm" gap="sm" wrap="nowrap" justify="space-between">
          <Group gap="sm" wrap="nowrap" className={classes["shrink"] ?? ""}>
            <Link to="/floor" className={classes["brand"] ?? ""} aria-label="Lilliput, to the floor">
              <img src="/icon.svg" alt="" width={28} height={28} />
              <span className={classes["wide"]}>Lilliput</span>
            </Link>
            <Text c="dimmed" truncate className={classes["wide"] ?? ""} data-testid="lab-name">
              {lab?.name}
            </Text>
            <ConnectionState />
            <HealthChip />
          </Group>
          <Group gap="xs" wrap="nowrap">
            <EmergencyStopButton />
            <UserMenu />
          </Group>
        </Group>
        {engaged && <EmergencyStopBanner estop={estop} />}
      </AppShell.Header>
      {isPhone ? (
        <AppShell.Footer>
          <Navigation />
        </AppShell.Footer>
      ) : (
        <AppShell.Navbar>
          <Navigation />
        </AppShell.Navbar>
      )}
      <AppShell.Main className={classes["main"] ?? ""}>
        <Suspense
          fallback={
            <Center h="60vh">
              <Loader aria-label="Loading the page" />
            </Center>
          }
        >
          <Outlet />
        </Suspense>
      </AppShell.Main>
    </AppShell>
  );
}
