// Generated from the server's OpenAPI description by `npm run generate`; do not edit.

export interface paths {
    "/api/session": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** Who */
        get: operations["who_api_session_get"];
        put?: never;
        /** Login */
        post: operations["login_api_session_post"];
        /** Logout */
        delete: operations["logout_api_session_delete"];
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/lab": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** Getlab */
        get: operations["getlab_api_lab_get"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/health": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** Gh */
        get: operations["gh_api_health_get"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/robots/{id}/settings": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        /** Ps */
        put: operations["ps_api_robots__id__settings_put"];
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/robots/{id}/assignment": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        /** Pa */
        put: operations["pa_api_robots__id__assignment_put"];
        post?: never;
        /** Pd */
        delete: operations["pd_api_robots__id__assignment_delete"];
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/robots/{id}/assignment/pause": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /** Pp */
        post: operations["pp_api_robots__id__assignment_pause_post"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/robots/{id}/assignment/resume": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /** Pr */
        post: operations["pr_api_robots__id__assignment_resume_post"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/robots/{id}/manual": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        /** Pm */
        put: operations["pm_api_robots__id__manual_put"];
        post?: never;
        /** Dm */
        delete: operations["dm_api_robots__id__manual_delete"];
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/waypoints": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /** Aw */
        post: operations["aw_api_waypoints_post"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/waypoints/{id}": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        /** Uw */
        put: operations["uw_api_waypoints__id__put"];
        post?: never;
        /** Dw */
        delete: operations["dw_api_waypoints__id__delete"];
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/routes": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /** Ar */
        post: operations["ar_api_routes_post"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/routes/{id}": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        /** Ur */
        put: operations["ur_api_routes__id__put"];
        post?: never;
        /** Dr */
        delete: operations["dr_api_routes__id__delete"];
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/estop": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** Ge */
        get: operations["ge_api_estop_get"];
        put?: never;
        /** Pe */
        post: operations["pe_api_estop_post"];
        /** De */
        delete: operations["de_api_estop_delete"];
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/events": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** Ev */
        get: operations["ev_api_events_get"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/sim/objects": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /** Ao */
        post: operations["ao_api_sim_objects_post"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/sim/objects/{id}": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        /** Uo */
        put: operations["uo_api_sim_objects__id__put"];
        post?: never;
        /** Do */
        delete: operations["do_api_sim_objects__id__delete"];
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/users": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** Us */
        get: operations["us_api_users_get"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/tokens": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** Ts */
        get: operations["ts_api_tokens_get"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/cameras/{id}/preview.jpg": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** Prev */
        get: operations["prev_api_cameras__id__preview_jpg_get"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/floor.jpg": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** Floor */
        get: operations["floor_api_floor_jpg_get"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/{path}": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** Spa */
        get: operations["spa__path__get"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
}
export type webhooks = Record<string, never>;
export interface components {
    schemas: {
        /**
         * Assignment
         * @description A route given to a robot, and how far it has come. Durable: it survives every restart.
         */
        Assignment: {
            /** Id */
            id: string;
            /** Robot */
            robot: string;
            /** Route */
            route: string;
            state: components["schemas"]["AssignmentState"];
            /**
             * Leg
             * @description Index of the leg being driven.
             * @default 0
             */
            leg: number;
            /**
             * Laps
             * @default 0
             */
            laps: number;
            /**
             * Speed Scale
             * @default 1
             */
            speed_scale: number;
            /** Started Ns */
            started_ns: number;
            /** Changed Ns */
            changed_ns: number;
            /**
             * Started By
             * @default
             */
            started_by: string;
            /**
             * Reason
             * @default
             */
            reason: string;
        };
        /**
         * AssignmentState
         * @description The life of an assignment; RUNNING and PAUSED are not over.
         * @enum {string}
         */
        AssignmentState: "running" | "paused" | "done" | "stopped" | "failed";
        /** Body_login_api_session_post */
        Body_login_api_session_post: {
            l: components["schemas"]["Login"];
            response: components["schemas"]["Response"];
        };
        /** ChannelHealth */
        ChannelHealth: {
            /** Channel */
            channel: string;
            /** Instance */
            instance: string;
            /** Age S */
            age_s: number | null;
            /** State */
            state: string;
            /** Rate Hz */
            rate_hz: number;
        };
        /** Confirm */
        Confirm: {
            /** Confirm */
            confirm: boolean;
        };
        /**
         * EmergencyStop
         * @description The fleet-wide latch. Engaged until a person releases it; `epoch` grows with every change.
         */
        EmergencyStop: {
            /** Engaged */
            engaged: boolean;
            /**
             * Epoch
             * @default 0
             */
            epoch: number;
            /**
             * Stamp Ns
             * @default 0
             */
            stamp_ns: number;
            /**
             * By
             * @default
             */
            by: string;
            /**
             * Reason
             * @default
             */
            reason: string;
        };
        /**
         * Event
         * @description A line of the history: who did what, or what went wrong.
         */
        Event: {
            /** Stamp Ns */
            stamp_ns: number;
            level: components["schemas"]["EventLevel"];
            /**
             * Source
             * @description Process, camera, robot or user it comes from.
             */
            source: string;
            /**
             * Kind
             * @description Machine-readable, e.g. 'route_started', 'camera_lost', 'emergency_stop'.
             */
            kind: string;
            /** Text */
            text: string;
        };
        /**
         * EventLevel
         * @enum {string}
         */
        EventLevel: "info" | "warning" | "error";
        /** HTTPValidationError */
        HTTPValidationError: {
            /** Detail */
            detail?: components["schemas"]["ValidationError"][];
        };
        /** Health */
        Health: {
            /** State */
            state: string;
            /** Stamp Ns */
            stamp_ns: number;
            /** Channels */
            channels: components["schemas"]["ChannelHealth"][];
            /** Processes */
            processes: components["schemas"]["ProcessState"][];
            /** Problems */
            problems: components["schemas"]["Problem"][];
        };
        /**
         * Leg
         * @description One leg of a route: the waypoint it ends at and the speed set-point on the way there.
         */
        Leg: {
            /** Waypoint */
            waypoint: string;
            /**
             * Speed Mps
             * @default 0.3
             */
            speed_mps: number;
        };
        /** Login */
        Login: {
            /** User */
            user: string;
            /** Password */
            password: string;
        };
        /**
         * ManualDrive
         * @description A hand on the stick: the twist asked for, by whom, and until when it counts (the lease).
         */
        ManualDrive: {
            /** Robot */
            robot: string;
            /** Linear Mps */
            linear_mps: number;
            /** Angular Radps */
            angular_radps: number;
            /** Holder */
            holder: string;
            /** Expires Ns */
            expires_ns: number;
        };
        /**
         * Movement
         * @description What a command asks for. The first four are GPSS's; `Drive` carries a hand-driven twist.
         * @enum {string}
         */
        Movement: "MoveTo" | "Waiting" | "NoAction" | "Rotate" | "Drive";
        /**
         * Outcome
         * @description What became of a command. `accepted` has an empty reached_ns, as in the report.
         * @enum {string}
         */
        Outcome: "accepted" | "refused" | "reached";
        /** Problem */
        Problem: {
            /** Severity */
            severity: string;
            /** Source */
            source: string;
            /** Since Ns */
            since_ns: number;
            /** Text */
            text: string;
        };
        /**
         * ProcessState
         * @description One process of the process table on one machine.
         */
        ProcessState: {
            /** Name */
            name: string;
            /**
             * State
             * @enum {string}
             */
            state: "starting" | "running" | "restarting" | "stopped";
            /** Pid */
            pid: number | null;
            /** Restarts */
            restarts: number;
            /** Since Ns */
            since_ns: number;
            /** Stamp Ns */
            stamp_ns: number;
            /**
             * Last Error
             * @description How it ended the last time, e.g. 'killed by signal 9'.
             * @default
             */
            last_error: string;
        };
        /**
         * Response
         * @description Robot to server: the command it answers, what was really applied, and when the target was reached (empty before).
         */
        Response: {
            /** Robot */
            robot: string;
            /** Command Order */
            command_order: [
                number,
                number
            ];
            /** Command Stamp Ns */
            command_stamp_ns: number;
            /** Stamp Ns */
            stamp_ns: number;
            outcome: components["schemas"]["Outcome"];
            movement: components["schemas"]["Movement"];
            /**
             * Applied Speed Mps
             * @default 0
             */
            applied_speed_mps: number;
            /** Reached Ns */
            reached_ns?: number | null;
            /**
             * Reason
             * @default
             */
            reason: string;
        };
        /**
         * RobotSettings
         * @description What an operator may set per robot; absent fields fall back to the lab description.
         */
        RobotSettings: {
            /** Box Start M */
            box_start_m?: number | null;
            /** Box Length M */
            box_length_m?: number | null;
            /** Box Width M */
            box_width_m?: number | null;
            /** Stop At Waypoint */
            stop_at_waypoint?: boolean | null;
        };
        /**
         * Route
         * @description Ordered legs, driven once or looped.
         */
        Route: {
            /** Id */
            id: string;
            /** Legs */
            legs: components["schemas"]["Leg"][];
            /**
             * Loop
             * @default false
             */
            loop: boolean;
        };
        /** Session */
        Session: {
            /** User */
            user: string;
            /**
             * Role
             * @enum {string}
             */
            role: "viewer" | "operator" | "admin" | "robot";
        };
        /**
         * SimulatedObject
         * @description A person or a pallet on the simulated floor; a person with `path` walks it back and forth at `speed_mps`.
         */
        SimulatedObject: {
            /** Id */
            id: string;
            /**
             * Kind
             * @enum {string}
             */
            kind: "person" | "pallet";
            /** X */
            x: number;
            /** Y */
            y: number;
            /**
             * Yaw
             * @default 0
             */
            yaw: number;
            /**
             * Path
             * @default []
             */
            path: [
                number,
                number
            ][];
            /**
             * Speed Mps
             * @default 0
             */
            speed_mps: number;
        };
        /** Start */
        Start: {
            /** Route */
            route: string;
            /**
             * Speed Scale
             * @default 1
             */
            speed_scale: number;
        };
        /** Token */
        Token: {
            /** Id */
            id: string;
            /** Name */
            name: string;
            /** Role */
            role: string;
            /** Robot */
            robot: string | null;
            /** Created Ns */
            created_ns: number;
        };
        /** Twist */
        Twist: {
            /** Linear Mps */
            linear_mps: number;
            /** Angular Radps */
            angular_radps: number;
        };
        /** User */
        User: {
            /** Name */
            name: string;
            /** Role */
            role: string;
            /** Created Ns */
            created_ns: number;
        };
        /** ValidationError */
        ValidationError: {
            /** Location */
            loc: (string | number)[];
            /** Message */
            msg: string;
            /** Error Type */
            type: string;
            /** Input */
            input?: unknown;
            /** Context */
            ctx?: Record<string, never>;
        };
        /**
         * Waypoint
         * @description A place on the floor: metres in the map frame; the radius within which it counts as reached; the heading (rad) to
         *     leave it with if that matters.
         */
        Waypoint: {
            /** Id */
            id: string;
            /** Area */
            area: string;
            /** X */
            x: number;
            /** Y */
            y: number;
            /**
             * Radius M
             * @default 0.15
             */
            radius_m: number;
            /** Yaw */
            yaw?: number | null;
        };
        /** Why */
        Why: {
            /**
             * Reason
             * @default
             */
            reason: string;
        };
    };
    responses: never;
    parameters: never;
    requestBodies: never;
    headers: never;
    pathItems: never;
}
export type Assignment = components['schemas']['Assignment'];
export type AssignmentState = components['schemas']['AssignmentState'];
export type BodyLoginApiSessionPost = components['schemas']['Body_login_api_session_post'];
export type ChannelHealth = components['schemas']['ChannelHealth'];
export type Confirm = components['schemas']['Confirm'];
export type EmergencyStop = components['schemas']['EmergencyStop'];
export type Event = components['schemas']['Event'];
export type EventLevel = components['schemas']['EventLevel'];
export type HttpValidationError = components['schemas']['HTTPValidationError'];
export type Health = components['schemas']['Health'];
export type Leg = components['schemas']['Leg'];
export type Login = components['schemas']['Login'];
export type ManualDrive = components['schemas']['ManualDrive'];
export type Movement = components['schemas']['Movement'];
export type Outcome = components['schemas']['Outcome'];
export type Problem = components['schemas']['Problem'];
export type ProcessState = components['schemas']['ProcessState'];
export type Response = components['schemas']['Response'];
export type RobotSettings = components['schemas']['RobotSettings'];
export type Route = components['schemas']['Route'];
export type Session = components['schemas']['Session'];
export type SimulatedObject = components['schemas']['SimulatedObject'];
export type Start = components['schemas']['Start'];
export type Token = components['schemas']['Token'];
export type Twist = components['schemas']['Twist'];
export type User = components['schemas']['User'];
export type ValidationError = components['schemas']['ValidationError'];
export type Waypoint = components['schemas']['Waypoint'];
export type Why = components['schemas']['Why'];
export type $defs = Record<string, never>;
export interface operations {
    who_api_session_get: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Successful Response */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Session"];
                };
            };
        };
    };
    login_api_session_post: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["Body_login_api_session_post"];
            };
        };
        responses: {
            /** @description Successful Response */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Session"];
                };
            };
            /** @description Validation Error */
            422: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["HTTPValidationError"];
                };
            };
        };
    };
    logout_api_session_delete: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["Response"];
            };
        };
        responses: {
            /** @description Successful Response */
            204: {
                headers: {
                    [name: string]: unknown;
                };
                content?: never;
            };
            /** @description Validation Error */
            422: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["HTTPValidationError"];
                };
            };
        };
    };
    getlab_api_lab_get: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Successful Response */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": {
                        [key: string]: unknown;
                    };
                };
            };
        };
    };
    gh_api_health_get: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Successful Response */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Health"];
                };
            };
        };
    };
    ps_api_robots__id__settings_put: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                id: string;
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["RobotSettings"];
            };
        };
        responses: {
            /** @description Successful Response */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["RobotSettings"];
                };
            };
            /** @description Validation Error */
            422: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["HTTPValidationError"];
                };
            };
        };
    };
    pa_api_robots__id__assignment_put: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                id: string;
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["Start"];
            };
        };
        responses: {
            /** @description Successful Response */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Assignment"];
                };
            };
            /** @description Validation Error */
            422: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["HTTPValidationError"];
                };
            };
        };
    };
    pd_api_robots__id__assignment_delete: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Successful Response */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Assignment"];
                };
            };
            /** @description Validation Error */
            422: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["HTTPValidationError"];
                };
            };
        };
    };
    pp_api_robots__id__assignment_pause_post: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Successful Response */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Assignment"];
                };
            };
            /** @description Validation Error */
            422: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["HTTPValidationError"];
                };
            };
        };
    };
    pr_api_robots__id__assignment_resume_post: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Successful Response */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Assignment"];
                };
            };
            /** @description Validation Error */
            422: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["HTTPValidationError"];
                };
            };
        };
    };
    pm_api_robots__id__manual_put: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                id: string;
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["Twist"];
            };
        };
        responses: {
            /** @description Successful Response */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["ManualDrive"];
                };
            };
            /** @description Validation Error */
            422: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["HTTPValidationError"];
                };
            };
        };
    };
    dm_api_robots__id__manual_delete: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Successful Response */
            204: {
                headers: {
                    [name: string]: unknown;
                };
                content?: never;
            };
            /** @description Validation Error */
            422: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["HTTPValidationError"];
                };
            };
        };
    };
    aw_api_waypoints_post: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["Waypoint"];
            };
        };
        responses: {
            /** @description Successful Response */
            201: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Waypoint"];
                };
            };
            /** @description Validation Error */
            422: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["HTTPValidationError"];
                };
            };
        };
    };
    uw_api_waypoints__id__put: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                id: string;
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["Waypoint"];
            };
        };
        responses: {
            /** @description Successful Response */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Waypoint"];
                };
            };
            /** @description Validation Error */
            422: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["HTTPValidationError"];
                };
            };
        };
    };
    dw_api_waypoints__id__delete: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Successful Response */
            204: {
                headers: {
                    [name: string]: unknown;
                };
                content?: never;
            };
            /** @description Validation Error */
            422: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["HTTPValidationError"];
                };
            };
        };
    };
    ar_api_routes_post: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["Route"];
            };
        };
        responses: {
            /** @description Successful Response */
            201: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Route"];
                };
            };
            /** @description Validation Error */
            422: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["HTTPValidationError"];
                };
            };
        };
    };
    ur_api_routes__id__put: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                id: string;
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["Route"];
            };
        };
        responses: {
            /** @description Successful Response */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Route"];
                };
            };
            /** @description Validation Error */
            422: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["HTTPValidationError"];
                };
            };
        };
    };
    dr_api_routes__id__delete: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Successful Response */
            204: {
                headers: {
                    [name: string]: unknown;
                };
                content?: never;
            };
            /** @description Validation Error */
            422: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["HTTPValidationError"];
                };
            };
        };
    };
    ge_api_estop_get: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Successful Response */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["EmergencyStop"];
                };
            };
        };
    };
    pe_api_estop_post: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["Why"];
            };
        };
        responses: {
            /** @description Successful Response */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["EmergencyStop"];
                };
            };
            /** @description Validation Error */
            422: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["HTTPValidationError"];
                };
            };
        };
    };
    de_api_estop_delete: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["Confirm"];
            };
        };
        responses: {
            /** @description Successful Response */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["EmergencyStop"];
                };
            };
            /** @description Validation Error */
            422: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["HTTPValidationError"];
                };
            };
        };
    };
    ev_api_events_get: {
        parameters: {
            query?: {
                count?: number;
            };
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Successful Response */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Event"][];
                };
            };
            /** @description Validation Error */
            422: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["HTTPValidationError"];
                };
            };
        };
    };
    ao_api_sim_objects_post: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["SimulatedObject"];
            };
        };
        responses: {
            /** @description Successful Response */
            201: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["SimulatedObject"];
                };
            };
            /** @description Validation Error */
            422: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["HTTPValidationError"];
                };
            };
        };
    };
    uo_api_sim_objects__id__put: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                id: string;
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["SimulatedObject"];
            };
        };
        responses: {
            /** @description Successful Response */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["SimulatedObject"];
                };
            };
            /** @description Validation Error */
            422: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["HTTPValidationError"];
                };
            };
        };
    };
    do_api_sim_objects__id__delete: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Successful Response */
            204: {
                headers: {
                    [name: string]: unknown;
                };
                content?: never;
            };
            /** @description Validation Error */
            422: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["HTTPValidationError"];
                };
            };
        };
    };
    us_api_users_get: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Successful Response */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["User"][];
                };
            };
        };
    };
    ts_api_tokens_get: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Successful Response */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Token"][];
                };
            };
        };
    };
    prev_api_cameras__id__preview_jpg_get: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Successful Response */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": unknown;
                };
            };
            /** @description Validation Error */
            422: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["HTTPValidationError"];
                };
            };
        };
    };
    floor_api_floor_jpg_get: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Successful Response */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": unknown;
                };
            };
        };
    };
    spa__path__get: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                path: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Successful Response */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": unknown;
                };
            };
            /** @description Validation Error */
            422: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["HTTPValidationError"];
                };
            };
        };
    };
}
