/** The console: the log-in, or the shell with its pages. Each page is loaded when it is first opened. */
import { Button, Center, EmptyState, Loader } from "@mantine/core";
import { IconPlugConnectedX } from "@tabler/icons-react";
import { lazy, useEffect } from "react";
import { createBrowserRouter, Navigate, RouterProvider } from "react-router";
import { LoginPage } from "./LoginPage";
import { refreshSession, useSession } from "./session";
import { Shell } from "./Shell";

const FloorPage = lazy(() => import("../floor/FloorPage"));
const RoutesPage = lazy(() => import("../routes/RoutesPage"));
const CamerasPage = lazy(() => import("../cameras/CamerasPage"));
const CalibrationPage = lazy(() => import("../calibration/CalibrationPage"));
const ScenePage = lazy(() => import("../scene/ScenePage"));
const EventsPage = lazy(() => import("../events/EventsPage"));
const LogsPage = lazy(() => import("../logs/LogsPage"));
const SystemPage = lazy(() => import("../system/SystemPage"));
const AdminPage = lazy(() => import("../admin/AdminPage"));

const router = createBrowserRouter([
  {
    element: <Shell />,
    children: [
      { path: "/floor", element: <FloorPage /> },
      { path: "/routes", element: <RoutesPage /> },
      { path: "/cameras", element: <CamerasPage /> },
      { path: "/calibration", element: <CalibrationPage /> },
      { path: "/3d", element: <ScenePage /> },
      { path: "/events", element: <EventsPage /> },
      { path: "/logs", element: <LogsPage /> },
      { path: "/system", element: <SystemPage /> },
      { path: "/admin", element: <AdminPage /> },
      { path: "*", element: <Navigate to="/floor" replace /> },
    ],
  },
]);

const RETRY_MS = 3000;

export function App() {
  const session = useSession();
  useEffect(() => void refreshSession(), []);
  useEffect(() => {
    if (session.state !== "unreachable") return;
    const timer = setInterval(() => void refreshSession(), RETRY_MS);
    return () => clearInterval(timer);
  }, [session.state]);

  switch (session.state) {
    case "in":
      return <RouterProvider router={router} />;
    case "out":
      return <LoginPage ended={session.ended} />;
    case "unreachable":
      return (
        <Center mih="100dvh">
          <EmptyState
            icon={<IconPlugConnectedX />}
            title="The server does not answer"
            description="Trying again every 3 seconds. Is ./lilliput up running on this address?"
          >
            <EmptyState.Actions>
              <Button variant="default" onClick={() => void refreshSession()}>
                Try now
              </Button>
            </EmptyState.Actions>
          </EmptyState>
        </Center>
      );
    case "unknown":
      return (
        <Center mih="100dvh">
          <Loader aria-label="Asking who is logged in" />
        </Center>
      );
  }
}
