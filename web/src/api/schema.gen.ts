// Generated from the server's OpenAPI description by `npm run generate`; do not edit.

export interface paths {
    "/api/session": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * Who am I
         * @description The user or token that this request is authorized by.
         */
        get: operations["who_am_i"];
        put?: never;
        /**
         * Log in
         * @description Begins a session: the cookie `lilliput_session` stays valid for 12 hours after its last use.
         */
        post: operations["log_in"];
        /**
         * Log out
         * @description Ends the session; its cookie is void from now on.
         */
        delete: operations["log_out"];
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
        /**
         * The lab description
         * @description What exists: areas, cameras, floor tags, vehicles, zones, ports; without the simulation's truth.
         */
        get: operations["get_lab"];
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
        /**
         * Health of the system
         * @description For viewers: how old the newest message of every channel is, which processes run, and what is missing since when.
         *     Everybody else gets a HealthSummary. Answers 200 also when something is wrong, Redis included: see `state`.
         */
        get: operations["get_health"];
        put?: never;
        post?: never;
        delete?: never;
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
        /**
         * History
         * @description The newest events, oldest first: who did what, and what went wrong.
         */
        get: operations["list_events"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/robots": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * All robots
         * @description Every robot of the lab description with all that is known of it.
         */
        get: operations["list_robots"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/robots/{robot_id}": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * One robot
         * @description All that is known of the robot.
         */
        get: operations["get_robot"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/robots/{robot_id}/responses": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * What a robot answered
         * @description The robot's newest responses to commands, oldest first: accepted, refused and why, or reached.
         */
        get: operations["list_responses"];
        put?: never;
        /**
         * Answer a command
         * @description What became of a command: accepted or refused, what is really applied, and when its target was reached.
         */
        post: operations["post_response"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/robots/{robot_id}/settings": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        /**
         * Set the obstacle box
         * @description Replaces what an operator has set for this robot; what is absent falls back to the lab description.
         */
        put: operations["put_robot_settings"];
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/robots/{robot_id}/assignment": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        /**
         * Start a route
         * @description Gives the robot a route. Refused while the emergency stop is engaged, while it has another one that is not over
         *     (one that was started by `first start`, a simulated lab's tours, is replaced), and when a waypoint of the route is
         *     missing.
         */
        put: operations["start_route"];
        post?: never;
        /**
         * Stop the route
         * @description Ends the route for good and empties the queue; the robot holds still.
         */
        delete: operations["stop_route"];
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/robots/{robot_id}/assignment/pause": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Pause the route
         * @description The robot holds still until the route is resumed.
         */
        post: operations["pause_route"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/robots/{robot_id}/assignment/resume": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Resume the route
         * @description The robot drives on where it was paused.
         */
        post: operations["resume_route"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/robots/{robot_id}/assignment/skip": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Skip a leg
         * @description The robot goes on with the next leg from where it is; the stay at the end of this one is left out too. Skipping the last
         *     leg ends the route, and the next of the queue begins.
         */
        post: operations["skip_leg"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/robots/{robot_id}/assignment/proceed": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Let it go on from a stop
         * @description Confirms what a robot stays for at the end of a leg (a load taken, a charge that suffices). Refused while it does not
         *     stay anywhere.
         */
        post: operations["proceed"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/robots/{robot_id}/assignment/cancel": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Cancel the route
         * @description Ends the route, also one that failed, and the next of the queue begins.
         */
        post: operations["cancel_route"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/robots/{robot_id}/queue": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Queue a route
         * @description The robot drives the route after all that it has to do; a looped route ends at the end of its lap when something is
         *     queued. With nothing to do it begins at once, and is refused as a start is.
         */
        post: operations["queue_route"];
        /**
         * Empty the queue
         * @description What is being driven goes on.
         */
        delete: operations["empty_queue"];
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/robots/{robot_id}/queue/{entry_id}": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        post?: never;
        /**
         * Take a route out of the queue
         * @description By the id of its entry.
         */
        delete: operations["dequeue_route"];
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/robots/{robot_id}/manual": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        /**
         * Drive by hand
         * @description Takes or renews the stick for half a second with this twist, and answers with what is applied: it is clipped to
         *     what the robot can do. Manual drive outranks the route. Refused while somebody else holds the stick and while the
         *     emergency stop is engaged.
         */
        put: operations["drive_by_hand"];
        post?: never;
        /**
         * Let go of the stick
         * @description Hands the robot back to its route at once. Refused while somebody else holds the stick.
         */
        delete: operations["let_go"];
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/robots/{robot_id}/registration": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Register a robot
         * @description Tells where the robot listens: the address that this request comes from, and the port in it.
         */
        post: operations["register_robot"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/robots/{robot_id}/commands": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * Stream of commands
         * @description Commands for the robot as server-sent events, for as long as it listens and its token is valid.
         */
        get: operations["stream_commands"];
        put?: never;
        post?: never;
        delete?: never;
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
        /**
         * All waypoints
         * @description By id.
         */
        get: operations["list_waypoints"];
        put?: never;
        /**
         * Place a waypoint
         * @description It must lie in the area that it names. Refused when the id is taken.
         */
        post: operations["create_waypoint"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/waypoints/{waypoint_id}": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        /**
         * Change a waypoint
         * @description Replaces it as a whole, or places it. Robots on their way to it follow at once.
         */
        put: operations["put_waypoint"];
        post?: never;
        /**
         * Delete a waypoint
         * @description Refused while a route uses it.
         */
        delete: operations["delete_waypoint"];
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
        /**
         * All routes
         * @description By id.
         */
        get: operations["list_routes"];
        put?: never;
        /**
         * Make a route
         * @description Every leg's waypoint must exist. Refused when the id is taken.
         */
        post: operations["create_route"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/routes/{route_id}": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        /**
         * Change a route
         * @description Replaces it as a whole, or makes it. Refused while it is being driven.
         */
        put: operations["put_route"];
        post?: never;
        /**
         * Delete a route
         * @description Refused while it is being driven.
         */
        delete: operations["delete_route"];
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/speed-zones": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * All speed zones
         * @description Those of the lab description too.
         */
        get: operations["list_speed_zones"];
        put?: never;
        /**
         * Draw a speed zone
         * @description Robots in it slow down at once. Refused when the id is taken.
         */
        post: operations["create_speed_zone"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/speed-zones/{zone_id}": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        /**
         * Change a speed zone
         * @description Replaces it as a whole, or draws it. Refused when it is part of the lab description.
         */
        put: operations["put_speed_zone"];
        post?: never;
        /**
         * Delete a speed zone
         * @description Refused when it is part of the lab description.
         */
        delete: operations["delete_speed_zone"];
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
        /**
         * State of the emergency stop
         * @description Whether it is engaged, by whom and why. For robots too.
         */
        get: operations["get_emergency_stop"];
        put?: never;
        /**
         * Stop everything
         * @description Every robot halts at once and stays so until a person releases the stop; it survives every restart. When it is
         *     engaged already, its first reason stays. It works without Redis too: then robots with an open stream are told, it is
         *     written when Redis is back (if this server still runs), and the answer is a 503 that says so.
         */
        post: operations["engage_emergency_stop"];
        /**
         * Release the emergency stop
         * @description Routes that were running go on; needs `{"confirm": true}`.
         */
        delete: operations["release_emergency_stop"];
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/cameras": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * All cameras
         * @description Every camera of the lab description with its state, its place and the floor that it sees.
         */
        get: operations["list_cameras"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/cameras/{camera_id}/preview.jpg": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * A camera's newest small picture
         * @description A few times a second at most; ask with `If-None-Match`.
         */
        get: operations["get_preview"];
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
        /**
         * The floor, stitched from all cameras
         * @description Seen from above, y upwards; the header `X-Bounds` has its `minx,miny,maxx,maxy` in metres.
         */
        get: operations["get_floor"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/calibration": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * State of the calibration
         * @description What is in force, what is going on, and what waits for a decision.
         */
        get: operations["get_calibration"];
        put?: never;
        /**
         * Start a calibration
         * @description The cameras look at their floor tags while poses go on; some seconds later a proposal waits for a decision. A
         *     proposal that waited is replaced. Refused while another run goes on.
         */
        post: operations["start_calibration"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/calibration/accept": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Accept the proposal
         * @description Puts it in force for all cameras at once, without a restart; what was in force can be restored. Refused when it is not
         *     this proposal that waits.
         */
        post: operations["accept_calibration"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/calibration/discard": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Discard the proposal
         * @description Nothing changes. Refused when it is not this proposal that waits.
         */
        post: operations["discard_calibration"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/calibration/restore": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Restore the previous calibration
         * @description Puts in force what was before; the present one can be restored in the same way. A camera that was moved since notices
         *     it, and finds its place anew. Refused when there is no previous one.
         */
        post: operations["restore_calibration"];
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
        /**
         * Simulated objects
         * @description What was put on the simulated floor, by id; 404 where nothing is simulated.
         */
        get: operations["list_simulated_objects"];
        put?: never;
        /**
         * Put an object down
         * @description Refused when the id is taken.
         */
        post: operations["create_simulated_object"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/sim/objects/{object_id}": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        /**
         * Move an object
         * @description Replaces it as a whole, or puts it down.
         */
        put: operations["put_simulated_object"];
        post?: never;
        /**
         * Take an object away
         * @description Takes it off the floor.
         */
        delete: operations["delete_simulated_object"];
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/sim/cameras/{camera_id}/fault": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        /**
         * Have a camera suffer a fault
         * @description A simulated camera stalls, is unplugged, sends garbage, is covered or bumped, until the fault is taken back; shown as
         *     the camera's `fault`. 404 for a camera that is not simulated.
         */
        put: operations["put_camera_fault"];
        post?: never;
        /**
         * End a camera's fault
         * @description The camera is as it was before; one that was bumped is moved back.
         */
        delete: operations["delete_camera_fault"];
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
        /**
         * All users
         * @description By name.
         */
        get: operations["list_users"];
        put?: never;
        /**
         * Create a user
         * @description Refused when the name is taken.
         */
        post: operations["create_user"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/users/{name}": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        /**
         * Change a user
         * @description Sets role or password, or both; the user's sessions end. The last administrator stays one.
         */
        put: operations["change_user"];
        post?: never;
        /**
         * Delete a user
         * @description Their sessions end. The last administrator stays.
         */
        delete: operations["delete_user"];
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
        /**
         * All API tokens
         * @description Oldest first, without their texts.
         */
        get: operations["list_tokens"];
        put?: never;
        /**
         * Issue an API token
         * @description The answer is the only place where its text is ever shown. Refused when the name is taken.
         */
        post: operations["issue_token"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/tokens/{token_id}": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        post?: never;
        /**
         * Revoke an API token
         * @description It is void from now on.
         */
        delete: operations["revoke_token"];
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/timings": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * Runs with stage timings
         * @description Newest first.
         */
        get: operations["list_timing_runs"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/timings/{run}": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * A run's stage timings
         * @description Box plots and time graphs, per stage and kind of process. `last_s` counts back from the run's newest record.
         */
        get: operations["get_timings"];
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
         * Area
         * @description A part of the floor that robots may use: a simple polygon in metres, map frame.
         */
        Area: {
            /** Id */
            id: string;
            /** Outline */
            outline: [
                number,
                number
            ][];
        };
        /**
         * Assignment
         * @description A route given to a robot, and how far it has come. Durable: it survives every restart.
         *
         *     `queue` holds the routes that follow, first in, first out. They begin when this one is done or cancelled; after a failure
         *     they wait for a person.
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
            /**
             * At Stop Ns
             * @description Since when the robot is at the end of its leg, where it stays a while; null on the way.
             */
            at_stop_ns?: number | null;
            /**
             * Proceed
             * @description Whether a person has let it go on from where it stays.
             * @default false
             */
            proceed: boolean;
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
            /**
             * Queue
             * @default []
             */
            queue: components["schemas"]["QueuedRoute"][];
        };
        /**
         * AssignmentState
         * @description The life of an assignment; RUNNING and PAUSED are not over.
         * @enum {string}
         */
        AssignmentState: "running" | "paused" | "done" | "stopped" | "failed";
        /**
         * BatterySpec
         * @description Shares of a full charge: below `low` people are warned, below `empty` the robot stands still.
         */
        BatterySpec: {
            /**
             * Low
             * @default 0.2
             */
            low: number;
            /**
             * Empty
             * @default 0.05
             */
            empty: number;
        };
        /**
         * Blockage
         * @description The nearest thing in an obstacle box: where it is (m, map frame), how far ahead of the robot's front along the path
         *     (m), and which robot it is (None: something on the floor).
         */
        Blockage: {
            /** X */
            x: number;
            /** Y */
            y: number;
            /** Distance M */
            distance_m: number;
            /** Robot */
            robot?: string | null;
        };
        /**
         * BoxView
         * @description A box plot's numbers in ms: quartiles (linear interpolation), whiskers `low` and `high` at the last value within 1.5 IQR,
         *     how many `outliers` lie beyond them, and some of those for a picture.
         */
        BoxView: {
            /** Count */
            count: number;
            /** Low */
            low: number;
            /** Q1 */
            q1: number;
            /** Median */
            median: number;
            /** Q3 */
            q3: number;
            /** High */
            high: number;
            /** Mean */
            mean: number;
            /** P99 */
            p99: number;
            /** Outliers */
            outliers: number;
            /** Outlier Values */
            outlier_values: number[];
        };
        /**
         * CalibratedCamera
         * @description T_map_camera with what it rests on; fields as in `CameraExtrinsics`.
         */
        CalibratedCamera: {
            /** Rotvec */
            rotvec: [
                number,
                number,
                number
            ];
            /** Translation */
            translation: [
                number,
                number,
                number
            ];
            /**
             * Covariance
             * @description Upper triangle of the 10 x 10 covariance of rotvec, translation, fx, fy, cx, cy.
             * @default []
             */
            covariance: number[];
            /**
             * Reprojection Px
             * @description RMS distance of the floor tags' corners in the joint result.
             */
            reprojection_px: number;
            /**
             * Floor Tags
             * @description Floor tags that it rests on.
             */
            floor_tags: number[];
            /**
             * Left Out
             * @description Floor tags that were seen and not believed.
             * @default []
             */
            left_out: number[];
            /**
             * Basis
             * @description Digest of the image size and intrinsics it was computed with.
             */
            basis: string;
        };
        /**
         * CalibratedFloorTag
         * @description Where a floor tag was found to lie (m, rad, map frame), and how far (m) from where the lab description has it.
         */
        CalibratedFloorTag: {
            /** X */
            x: number;
            /** Y */
            y: number;
            /** Yaw */
            yaw: number;
            /** Shift M */
            shift_m: number;
        };
        /**
         * Calibration
         * @description A joint result over cameras and floor tags. Cameras take it when it is newer than what they found by themselves.
         */
        Calibration: {
            /** Id */
            id: number;
            /**
             * Stamp Ns
             * @description Since when it is in force; of a proposal: when it was computed.
             */
            stamp_ns: number;
            /**
             * By
             * @description Who accepted it; `calibrator` when nobody had to.
             */
            by: string;
            /**
             * Floor Basis
             * @description Digest of the floor tags of the lab description that it was computed with.
             */
            floor_basis: string;
            /** Cameras */
            cameras: {
                [key: string]: components["schemas"]["CalibratedCamera"];
            };
            /** Floor Tags */
            floor_tags: {
                [key: string]: components["schemas"]["CalibratedFloorTag"];
            };
        };
        /**
         * CalibrationProposal
         * @description The outcome of a run, for a person to accept or discard.
         */
        CalibrationProposal: {
            calibration: components["schemas"]["Calibration"];
            /** Cameras */
            cameras: {
                [key: string]: components["schemas"]["CameraComparison"];
            };
            /** Floor Tags */
            floor_tags: {
                [key: string]: components["schemas"]["FloorTagComparison"];
            };
            /**
             * Not Answered
             * @description Cameras that were asked and sent nothing.
             */
            not_answered: string[];
        };
        /**
         * CalibrationRun
         * @description A calibration that somebody asked for, and how far it has come.
         */
        CalibrationRun: {
            /** Id */
            id: number;
            state: components["schemas"]["RunState"];
            /**
             * Stamp Ns
             * @description Of the newest change.
             */
            stamp_ns: number;
            /** Started Ns */
            started_ns: number;
            /**
             * By
             * @description Who asked for it.
             */
            by: string;
            /**
             * Cameras
             * @description Cameras that are to look anew.
             */
            cameras: string[];
            /**
             * Answered
             * @description Those of them that have.
             * @default []
             */
            answered: string[];
            /**
             * Text
             * @description Why it failed, or what was left out.
             * @default
             */
            text: string;
        };
        /**
         * CalibrationView
         * @description The newest run (null: there never was one), what is in force, what was before (null: nothing to restore), and the
         *     proposal that waits for a decision. Each camera's own state is in `/cameras`.
         */
        CalibrationView: {
            /** Stamp Ns */
            stamp_ns: number;
            run: components["schemas"]["CalibrationRun"] | null;
            current: components["schemas"]["Calibration"] | null;
            previous: components["schemas"]["Calibration"] | null;
            proposal: components["schemas"]["CalibrationProposal"] | null;
        };
        /**
         * CameraComparison
         * @description What a proposal changes for one camera. Pixels are RMS distances of the floor tags' corners in the new sighting, judged
         *     by the calibration in use and by the proposal; metres on the floor are taken over the part of it that the camera sees.
         *     `*_before_*` and the changes are null for a camera that had no calibration.
         */
        CameraComparison: {
            /**
             * Is New
             * @description Whether the camera looked anew for this; if not, its last sighting was used.
             */
            is_new: boolean;
            /** Frames */
            frames: number;
            /** Corner Noise Px */
            corner_noise_px: number;
            /** Floor Tags */
            floor_tags: number[];
            /** Left Out */
            left_out: number[];
            /** Reprojection Before Px */
            reprojection_before_px: number | null;
            /** Reprojection After Px */
            reprojection_after_px: number;
            /**
             * Floor Shift Mean M
             * @description How far the camera's poses will move, on average.
             */
            floor_shift_mean_m: number | null;
            /**
             * Floor Shift Max M
             * @description How far the camera's poses will move at most.
             */
            floor_shift_max_m: number | null;
            /** Camera Moved M */
            camera_moved_m: number | null;
            /** Camera Turned Rad */
            camera_turned_rad: number | null;
            /** Floor Std Before M */
            floor_std_before_m: number | null;
            /**
             * Floor Std After M
             * @description Standard deviation of points on the floor that the calibration leaves open (RMS); null: not known.
             */
            floor_std_after_m: number | null;
        };
        /**
         * CameraFault
         * @description What is wrong with a simulated camera until it is taken back. `cover_share` is the part of the image's width, from the
         *     left, that is covered; `shift_*` is how far a bump moved the mount (m, map frame), `tilt_*` how far it turned it (rad, added
         *     to the mount's own).
         * @example {
         *       "kind": "bump",
         *       "shift_x_m": 0.02
         *     }
         */
        CameraFault: {
            kind: components["schemas"]["FaultKind"];
            /**
             * Cover Share
             * @default 1
             */
            cover_share: number;
            /**
             * Shift X M
             * @default 0
             */
            shift_x_m: number;
            /**
             * Shift Y M
             * @default 0
             */
            shift_y_m: number;
            /**
             * Shift Z M
             * @default 0
             */
            shift_z_m: number;
            /**
             * Tilt X
             * @default 0
             */
            tilt_x: number;
            /**
             * Tilt Y
             * @default 0
             */
            tilt_y: number;
        };
        /**
         * CameraSpec
         * @description A ceiling camera. `source` is `sim`, a path, a URL, or a V4L2 device number.
         */
        CameraSpec: {
            /** Id */
            id: string;
            /** Area */
            area: string;
            /** Source */
            source: string | number;
            /** Width */
            width: number;
            /** Height */
            height: number;
            /** Rate Hz */
            rate_hz: number;
            /**
             * Color
             * @default false
             */
            color: boolean;
            intrinsics: components["schemas"]["Intrinsics"];
        };
        /**
         * CameraStateView
         * @description How the camera does, as its process last said; `error` is null when nothing is wrong.
         */
        CameraStateView: {
            /** Stamp Ns */
            stamp_ns: number;
            /**
             * Age S
             * @description Seconds, by the server's clock, when the answer was made.
             */
            age_s: number;
            /** Fresh */
            fresh: boolean;
            /** Connected */
            connected: boolean;
            /** Error */
            error: string | null;
            /**
             * Error Since Ns
             * @description Since when there is an error, if that is known.
             */
            error_since_ns: number | null;
            /** Width */
            width: number;
            /** Height */
            height: number;
            /** Rate Hz */
            rate_hz: number;
            /**
             * Latency Ms
             * @description Frame to message, median of the last seconds.
             */
            latency_ms: number;
            /** Frames */
            frames: number;
            /** Broken */
            broken: number;
            /** Skipped */
            skipped: number;
            /** Floor Tags Seen */
            floor_tags_seen: number[];
            /** Reprojection Px */
            reprojection_px: number | null;
            /** Timings Ms */
            timings_ms: {
                [key: string]: number;
            };
        };
        /**
         * CameraView
         * @description A camera with all that is known of it.
         */
        CameraView: {
            /** Id */
            id: string;
            /** Area */
            area: string;
            /** Source */
            source: string;
            /** Width */
            width: number;
            /** Height */
            height: number;
            /** Rate Hz */
            rate_hz: number;
            intrinsics: components["schemas"]["Intrinsics"];
            state: components["schemas"]["CameraStateView"] | null;
            /** @description Null until the camera has been calibrated. */
            extrinsics: components["schemas"]["ExtrinsicsView"] | null;
            /**
             * Outline
             * @description The floor that it sees; null until it has been calibrated.
             */
            outline: [
                number,
                number
            ][] | null;
            /** @description What this simulated camera is made to suffer. */
            fault: components["schemas"]["CameraFault"] | null;
        };
        /**
         * ChannelView
         * @description One instance of a channel.
         */
        ChannelView: {
            /** Channel */
            channel: string;
            /** Instance */
            instance: string;
            /** Producer */
            producer: string;
            condition: components["schemas"]["Condition"];
            /**
             * Age S
             * @description Of its newest message; null when there never was one.
             */
            age_s: number | null;
            /** Stale After S */
            stale_after_s: number;
            /**
             * Since Ns
             * @description Stamp of the last message while the channel is stale.
             */
            since_ns: number | null;
        };
        /**
         * CommandView
         * @description What guidance asks of the robot, if that is fresh.
         */
        CommandView: {
            movement: components["schemas"]["Movement"];
            target: components["schemas"]["Target"] | null;
            /** Speed Mps */
            speed_mps: number;
            /** Final */
            final: boolean;
            reason: components["schemas"]["Reason"];
        };
        /**
         * Condition
         * @description ok; warn: late, but not yet too old to use; stale: too old; missing: never heard; idle: speaks only when something
         *     happens.
         * @enum {string}
         */
        Condition: "ok" | "warn" | "stale" | "missing" | "idle";
        /**
         * Connection
         * @description VDA5050's words: OFFLINE never said anything, CONNECTION_BROKEN fell silent.
         * @enum {string}
         */
        Connection: "ONLINE" | "OFFLINE" | "CONNECTION_BROKEN";
        /**
         * ControlSpec
         * @description Which controller drives the vehicle (None: the agent's default), and the settings of each that differ from its kind's.
         */
        ControlSpec: {
            /** Controller */
            controller?: ("gpss" | "go_to_goal" | "frenet") | null;
            /** @default {} */
            gpss: components["schemas"]["GpssControl"];
            /** @default {} */
            go_to_goal: components["schemas"]["GoToGoalControl"];
            /** @default {} */
            frenet: components["schemas"]["FrenetControl"];
        };
        /**
         * Decision
         * @description The proposal that is meant: the `id` of its calibration.
         * @example {
         *       "id": 1700000000000
         *     }
         */
        Decision: {
            /** Id */
            id: number;
        };
        /**
         * Detours
         * @description Whether a robot drives around what blocks it, how long it waits before that (s), and what it keeps free beside itself
         *     then (m).
         */
        Detours: {
            /**
             * Enabled
             * @default true
             */
            enabled: boolean;
            /**
             * After S
             * @default 3
             */
            after_s: number;
            /**
             * Clearance M
             * @default 0.3
             */
            clearance_m: number;
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
         * Engage
         * @description Why everything is to stop.
         * @example {
         *       "reason": "person on the floor"
         *     }
         */
        Engage: {
            /**
             * Reason
             * @default
             * @example person on the floor
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
        /**
         * ExtrinsicsView
         * @description T_map_camera: `rotvec` is axis times angle (rad), `translation` metres; x right, y down, z forward in the camera.
         */
        ExtrinsicsView: {
            /** Stamp Ns */
            stamp_ns: number;
            /** Rotvec */
            rotvec: [
                number,
                number,
                number
            ];
            /** Translation */
            translation: [
                number,
                number,
                number
            ];
            /** Reprojection Px */
            reprojection_px: number;
            /** Floor Tags */
            floor_tags: number[];
        };
        /**
         * FaultKind
         * @description What a simulated camera may be made to do: `stall` (it stays connected and sends nothing), `unplug` (it is gone), `noise`
         *     (frames of random pixels), `resize` (frames of half the size), `cover` (something hangs in front of a part of the view),
         *     `bump` (its mount is moved).
         * @enum {string}
         */
        FaultKind: "stall" | "unplug" | "noise" | "resize" | "cover" | "bump";
        /**
         * FloorTagComparison
         * @description How far (m) a proposal puts a floor tag from where it is expected now, and which cameras saw it.
         */
        FloorTagComparison: {
            /** Shift M */
            shift_m: number;
            /** Cameras */
            cameras: string[];
        };
        /**
         * FloorTags
         * @description Tags glued to the floor (z = 0) that tie the cameras to the map frame: id -> x, y (m), yaw (rad) of the tag's
         *     centre; yaw 0 means that the edge from its left-bottom to its right-bottom corner points along map +x.
         */
        FloorTags: {
            /**
             * Family
             * @default tag36h11
             * @constant
             */
            family: "tag36h11";
            /** Size M */
            size_m: number;
            /** Poses */
            poses: {
                [key: string]: [
                    number,
                    number,
                    number
                ];
            };
        };
        /**
         * FrenetControl
         * @description Of the path-following controller.
         */
        FrenetControl: {
            /** Corner Cut M */
            corner_cut_m?: number | null;
            /** Pivot Above Rad */
            pivot_above_rad?: number | null;
            /** Turn Above Rad */
            turn_above_rad?: number | null;
            /** Settle M */
            settle_m?: number | null;
            /** Settle S */
            settle_s?: number | null;
            /** Lead S */
            lead_s?: number | null;
            /** Braking Mps2 */
            braking_mps2?: number | null;
            /** Lateral Mps2 */
            lateral_mps2?: number | null;
            /** Approach Per S */
            approach_per_s?: number | null;
            /** Tolerance M */
            tolerance_m?: number | null;
            /** Swivel S */
            swivel_s?: number | null;
        };
        /**
         * GoToGoalControl
         * @description Of the WifiBots' controller.
         */
        GoToGoalControl: {
            /** Accept M */
            accept_m?: number | null;
            /** Gain Per S */
            gain_per_s?: number | null;
            /** Turn Above Rad */
            turn_above_rad?: number | null;
        };
        /**
         * GpssControl
         * @description Of the report's controller; the report's own constants are not for setting.
         */
        GpssControl: {
            /** Passed M */
            passed_m?: number | null;
            /** Face Rad */
            face_rad?: number | null;
        };
        /**
         * GuidanceView
         * @description How guidance sees the robot: the obstacle box and what is in it, the temporary waypoint and the path ahead.
         */
        GuidanceView: {
            /**
             * Blocked
             * @description Whether the obstacle box counts as taken (draw it red).
             */
            blocked: boolean;
            blockage: components["schemas"]["Blockage"] | null;
            /**
             * Box
             * @description Outline of the obstacle box; empty while there is none.
             */
            box: [
                number,
                number
            ][];
            /** Carrot */
            carrot: [
                number,
                number
            ] | null;
            /** Path */
            path: [
                number,
                number
            ][];
            /**
             * Detour
             * @description What is left of its way around something, or out of the way; empty on its route.
             */
            detour: [
                number,
                number
            ][];
            /** Leg */
            leg: number | null;
        };
        /** HTTPValidationError */
        HTTPValidationError: {
            /** Detail */
            detail?: components["schemas"]["ValidationError"][];
        };
        /**
         * HealthSummary
         * @description What everybody may know of the health: how bad it is, not what.
         */
        HealthSummary: {
            /**
             * State
             * @enum {string}
             */
            state: "ok" | "warning" | "error";
            /** Stamp Ns */
            stamp_ns: number;
            /** Redis Reachable */
            redis_reachable: boolean;
            /** Errors */
            errors: number;
            /** Warnings */
            warnings: number;
        };
        /**
         * HealthView
         * @description The health of the whole: `error` when something is missing that robots need, `warning` when less.
         */
        HealthView: {
            /**
             * State
             * @enum {string}
             */
            state: "ok" | "warning" | "error";
            /** Stamp Ns */
            stamp_ns: number;
            /**
             * Started Ns
             * @description When this server started.
             */
            started_ns: number;
            redis: components["schemas"]["RedisView"];
            /** Channels */
            channels: components["schemas"]["ChannelView"][];
            /** Processes */
            processes: components["schemas"]["ProcessState"][];
            udp: components["schemas"]["UdpView"];
            /** Problems */
            problems: components["schemas"]["ProblemView"][];
        };
        /**
         * Intrinsics
         * @description Pinhole parameters in pixels and k1, k2, p1, p2, k3 (OpenCV's order).
         */
        Intrinsics: {
            /** Fx */
            fx: number;
            /** Fy */
            fy: number;
            /** Cx */
            cx: number;
            /** Cy */
            cy: number;
            /**
             * Distortion
             * @default [
             *       0,
             *       0,
             *       0,
             *       0,
             *       0
             *     ]
             */
            distortion: [
                number,
                number,
                number,
                number,
                number
            ];
        };
        /**
         * Introduction
         * @description What a robot says when it starts, and again as often as it is asked to. `session` differs after each of its restarts.
         * @example {
         *       "kind": "wifibot",
         *       "session": "b1946ac9",
         *       "udp_port": 40123
         *     }
         */
        Introduction: {
            /**
             * Kind
             * @default
             * @example wifibot
             */
            kind: string;
            /**
             * Udp Port
             * @description Where it hears POSE datagrams.
             * @example 40123
             */
            udp_port: number;
            /**
             * Session
             * @default
             */
            session: string;
        };
        /**
         * LabView
         * @description What exists in the lab. `bounds` is min x, min y, max x, max y of all areas, in metres.
         */
        LabView: {
            /** Name */
            name: string;
            /** Areas */
            areas: components["schemas"]["Area"][];
            /** Cameras */
            cameras: components["schemas"]["CameraSpec"][];
            floor_tags: components["schemas"]["FloorTags"];
            /** Vehicles */
            vehicles: components["schemas"]["VehicleSpec"][];
            /** Zones */
            zones: components["schemas"]["ZoneSpec"][];
            ports: components["schemas"]["Ports"];
            /** Bounds */
            bounds: [
                number,
                number,
                number,
                number
            ];
            /** Simulated */
            simulated: boolean;
        };
        /**
         * Leg
         * @description One leg of a route: the waypoint it ends at, the speed set-point on the way there, and what happens at its end.
         *
         *     `movement` `MoveTo` drives there; `Rotate` only turns, where the robot stands, to the heading of the leg's end or, without
         *     one, towards the waypoint. A leg with a heading, a stay, an action or a confirmation ends at rest.
         * @example {
         *       "speed_mps": 0.3,
         *       "waypoint": "charger"
         *     }
         * @example {
         *       "action": "pick_up",
         *       "dwell_s": 5,
         *       "waypoint": "shelf"
         *     }
         */
        Leg: {
            /** Waypoint */
            waypoint: string;
            /**
             * Speed Mps
             * @default 0.3
             */
            speed_mps: number;
            /**
             * Movement
             * @default MoveTo
             * @enum {string}
             */
            movement: "MoveTo" | "Rotate";
            /**
             * Yaw
             * @description Heading to end with (rad); null: the waypoint's.
             */
            yaw?: number | null;
            /**
             * Dwell S
             * @description How long the robot stays at the leg's end, at least.
             * @default 0
             */
            dwell_s: number;
            action?: components["schemas"]["StopAction"] | null;
            /**
             * Confirm
             * @description Whether it stays until a person lets it go on.
             * @default false
             */
            confirm: boolean;
            /**
             * Charge To
             * @description The share of full charge at which charging ends; without a battery to read, `dwell_s` decides.
             * @default 0.9
             */
            charge_to: number;
        };
        /**
         * Limits
         * @description What a vehicle can do: m/s, rad/s, m/s^2, rad/s^2; and how suddenly its controllers may change that, m/s^3, rad/s^3.
         *     Emergency stops brake at once and fully.
         */
        Limits: {
            /**
             * Speed Mps
             * @default 0.5
             */
            speed_mps: number;
            /**
             * Yaw Rate Radps
             * @default 1
             */
            yaw_rate_radps: number;
            /**
             * Acceleration Mps2
             * @default 0.5
             */
            acceleration_mps2: number;
            /**
             * Braking Mps2
             * @default 2
             */
            braking_mps2: number;
            /**
             * Yaw Acceleration Radps2
             * @default 4
             */
            yaw_acceleration_radps2: number;
            /**
             * Jerk Mps3
             * @default 4
             */
            jerk_mps3: number;
            /**
             * Yaw Jerk Radps3
             * @default 40
             */
            yaw_jerk_radps3: number;
        };
        /**
         * LiveChanges
         * @description What changed since the message before. An absent entry did not change, a null one is gone. Ages grow by themselves:
         *     nothing is sent because time passes.
         */
        LiveChanges: {
            /**
             * Type
             * @constant
             */
            type: "changes";
            /** Stamp Ns */
            stamp_ns: number;
            /** Robots */
            robots?: {
                [key: string]: components["schemas"]["RobotView"] | null;
            };
            /** Cameras */
            cameras?: {
                [key: string]: components["schemas"]["CameraView"] | null;
            };
            /** Waypoints */
            waypoints?: {
                [key: string]: components["schemas"]["Waypoint"] | null;
            };
            /** Routes */
            routes?: {
                [key: string]: components["schemas"]["Route"] | null;
            };
            /** Objects */
            objects?: {
                [key: string]: components["schemas"]["SimulatedObject"] | null;
            };
            /** Zones */
            zones?: {
                [key: string]: components["schemas"]["ZoneSpec"] | null;
            };
            /** Speed Zones */
            speed_zones?: {
                [key: string]: components["schemas"]["SpeedZone"] | null;
            };
            /** @default null */
            estop: components["schemas"]["EmergencyStop"] | null;
            /** @default null */
            obstacles: components["schemas"]["ObstaclesView"] | null;
            /** @default null */
            health: components["schemas"]["HealthView"] | null;
            /**
             * Events
             * @description New lines of the history, oldest first.
             */
            events?: components["schemas"]["Event"][];
        };
        /**
         * LiveSnapshot
         * @description All that there is; the first message of a connection. Ages within are as of `stamp_ns`, by the server's clock.
         */
        LiveSnapshot: {
            /**
             * Type
             * @constant
             */
            type: "snapshot";
            /** Stamp Ns */
            stamp_ns: number;
            /** Robots */
            robots: {
                [key: string]: components["schemas"]["RobotView"];
            };
            /** Cameras */
            cameras: {
                [key: string]: components["schemas"]["CameraView"];
            };
            /** Waypoints */
            waypoints: {
                [key: string]: components["schemas"]["Waypoint"];
            };
            /** Routes */
            routes: {
                [key: string]: components["schemas"]["Route"];
            };
            /** Objects */
            objects: {
                [key: string]: components["schemas"]["SimulatedObject"];
            };
            /** Zones */
            zones: {
                [key: string]: components["schemas"]["ZoneSpec"];
            };
            /**
             * Speed Zones
             * @description Those of the lab description and those drawn by operators.
             */
            speed_zones: {
                [key: string]: components["schemas"]["SpeedZone"];
            };
            estop: components["schemas"]["EmergencyStop"];
            obstacles: components["schemas"]["ObstaclesView"] | null;
            health: components["schemas"]["HealthView"];
            /**
             * Events
             * @description The newest of the history, oldest first.
             */
            events: components["schemas"]["Event"][];
        };
        /**
         * Login
         * @description A user's name and password.
         * @example {
         *       "password": "kodu-fami-zelo-tiva-4821",
         *       "user": "admin"
         *     }
         */
        Login: {
            /**
             * User
             * @example admin
             */
            user: string;
            /**
             * Password
             * @example kodu-fami-zelo-tiva-4821
             */
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
            /**
             * Holder
             * @description Tells one browser session or token from another.
             */
            holder: string;
            /**
             * By
             * @description Who that is, for people.
             * @default
             */
            by: string;
            /** Expires Ns */
            expires_ns: number;
        };
        /**
         * ManualView
         * @description Who drives by hand, while their lease is fresh.
         */
        ManualView: {
            /** Holder */
            holder: string;
            /** By */
            by: string;
            /** Linear Mps */
            linear_mps: number;
            /** Angular Radps */
            angular_radps: number;
            /** Expires Ns */
            expires_ns: number;
        };
        /**
         * Mode
         * @description VDA5050's operating modes, as far as they apply.
         * @enum {string}
         */
        Mode: "AUTOMATIC" | "MANUAL";
        /**
         * Movement
         * @description What a command asks for. The first four are GPSS's; `Drive` carries a hand-driven twist.
         * @enum {string}
         */
        Movement: "MoveTo" | "Waiting" | "NoAction" | "Rotate" | "Drive";
        /**
         * NewToken
         * @description A token to issue: role `robot` names its robot, the others do not.
         * @example {
         *       "name": "night shift script",
         *       "role": "operator"
         *     }
         */
        NewToken: {
            /**
             * Name
             * @example night shift script
             */
            name: string;
            role: components["schemas"]["Role"];
            /** Robot */
            robot?: string | null;
        };
        /**
         * NewTokenView
         * @description A new token with its text, shown this once.
         */
        NewTokenView: {
            /** Id */
            id: string;
            /** Name */
            name: string;
            role: components["schemas"]["Role"];
            /** Robot */
            robot: string | null;
            /**
             * Token
             * @example lilliput_Zm9yIGV4YW1wbGUgb25seSwgbm90IGEgcmVhbCB0b2tlbg
             */
            token: string;
        };
        /**
         * NewUser
         * @description A user to create; without a password a random one is made.
         * @example {
         *       "name": "eva",
         *       "role": "operator"
         *     }
         */
        NewUser: {
            /**
             * Name
             * @example eva
             */
            name: string;
            role: components["schemas"]["Role"];
            /** Password */
            password?: string | null;
        };
        /**
         * NewUserView
         * @description The user created, with the password that was made for them, shown this once (null: the one given).
         */
        NewUserView: {
            /** Name */
            name: string;
            role: components["schemas"]["Role"];
            /** Created Ns */
            created_ns: number;
            /** Password */
            password: string | null;
        };
        /**
         * ObstacleBox
         * @description The blue box in front of a robot (spec gpss): where it starts ahead of the rotation centre, its length along the
         *     path and its width, in metres, and whether it ends at the next waypoint or runs past it. `robots` and `unknown` say whether
         *     other robots and floor that no camera sees count.
         */
        ObstacleBox: {
            /**
             * Start M
             * @default 1
             */
            start_m: number;
            /**
             * Length M
             * @default 1
             */
            length_m: number;
            /**
             * Width M
             * @default 0.6
             */
            width_m: number;
            /**
             * Stop At Waypoint
             * @default false
             */
            stop_at_waypoint: boolean;
            /**
             * Robots
             * @default true
             */
            robots: boolean;
            /**
             * Unknown
             * @default true
             */
            unknown: boolean;
        };
        /**
         * ObstaclesView
         * @description A grid on the floor. Cell (row, column) covers x from origin_x + column * cell_m and y from origin_y + row * cell_m;
         *     rows grow with y.
         */
        ObstaclesView: {
            /**
             * Stamp Ns
             * @description When its cells last changed.
             */
            stamp_ns: number;
            /** Origin X */
            origin_x: number;
            /** Origin Y */
            origin_y: number;
            /** Cell M */
            cell_m: number;
            /** Columns */
            columns: number;
            /** Rows */
            rows: number;
            /**
             * Occupied
             * @description Base64 of a bit field, row-major, most significant bit first.
             */
            occupied: string;
            /**
             * Observed
             * @description As `occupied`; a cell that is not observed says nothing.
             */
            observed: string;
        };
        /**
         * Outcome
         * @description What became of a command. `accepted` has an empty reached_ns, as in the report.
         * @enum {string}
         */
        Outcome: "accepted" | "refused" | "reached";
        /**
         * Ports
         * @description Where the system listens: HTTP of the console and API, UDP from robots, the loopback-only port of the 3D scene,
         *     and UDP of the simulated lab's vehicles. Every robot's agent listens on `stop_udp` for emergency stops by broadcast. `redis`
         *     opens the private Redis to robots that speak GPSS (none: closed).
         */
        Ports: {
            /**
             * Http
             * @default 8000
             */
            http: number;
            /**
             * Robots Udp
             * @default 2020
             */
            robots_udp: number;
            /**
             * Scene
             * @default 8010
             */
            scene: number;
            /**
             * Lab Udp
             * @default 2030
             */
            lab_udp: number;
            /**
             * Stop Udp
             * @default 2040
             */
            stop_udp: number;
            /** Redis */
            redis?: number | null;
        };
        /**
         * PoseView
         * @description Where the cameras see the robot's rotation centre: metres and radians in the map frame, m/s, rad/s.
         */
        PoseView: {
            /** X */
            x: number;
            /** Y */
            y: number;
            /** Yaw */
            yaw: number;
            /** Vx */
            vx: number;
            /** Vy */
            vy: number;
            /** Yaw Rate */
            yaw_rate: number;
            /** Stamp Ns */
            stamp_ns: number;
            /**
             * Age S
             * @description Seconds, by the server's clock, when the answer was made.
             */
            age_s: number;
            /**
             * Fresh
             * @description Whether it is young enough to drive by.
             */
            fresh: boolean;
            /** Cameras */
            cameras: string[];
            /** Area */
            area: string | null;
            /**
             * Position Std M
             * @description Standard deviation of the position along its worse axis.
             */
            position_std_m: number;
        };
        /**
         * Problem
         * @description Why a request was refused.
         */
        Problem: {
            /**
             * Detail
             * @example route 'charge' is being driven by wifibot-14; stop it before it is changed
             */
            detail: string;
        };
        /**
         * ProblemView
         * @description Something that an operator should know, in a sentence.
         */
        ProblemView: {
            /**
             * Severity
             * @enum {string}
             */
            severity: "warning" | "error";
            /**
             * Source
             * @description The camera, robot or process that it is about.
             * @example cam2
             */
            source: string;
            /**
             * Since Ns
             * @description Since when, if that is known.
             */
            since_ns: number | null;
            /**
             * Text
             * @example no frames from cam2 since 12:03:10
             */
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
         * ProtectiveFieldSpec
         * @description The fields that the agent watches where a vehicle has a scanner (agents/protection).
         *
         *     - `margin_m`: what must remain free around everything that the outline sweeps until it stands.
         *     - `reaction_s`: from an echo to the beginning of braking: a turn of the scanner, transport, the motors' delay; on ROS 2
         *       the agent adds a round of its control loop (50 ms).
         *     - `clear_s`: how long the protective field must have been clear before the robot moves again.
         *     - `warning_s`, `warning_margin_m`: the warning field reaches as much farther as the robot drives in this time, and keeps so
         *       much free around it.
         *     - `slow_mps`: the speed of the outline's fastest point while anything is in the warning field.
         *     - `neighbours`: so many neighbouring beams with echoes side by side are a thing at once; fewer are one when the next turn
         *       of the scanner shows them again.
         */
        ProtectiveFieldSpec: {
            /**
             * Margin M
             * @default 0.08
             */
            margin_m: number;
            /**
             * Reaction S
             * @default 0.15
             */
            reaction_s: number;
            /**
             * Clear S
             * @default 1
             */
            clear_s: number;
            /**
             * Warning S
             * @default 1
             */
            warning_s: number;
            /**
             * Warning Margin M
             * @default 0.2
             */
            warning_margin_m: number;
            /**
             * Slow Mps
             * @default 0.12
             */
            slow_mps: number;
            /**
             * Neighbours
             * @default 3
             */
            neighbours: number;
        };
        /**
         * QueuedRoute
         * @description A route that waits for a robot to be done with what it drives; its id becomes the assignment's.
         */
        QueuedRoute: {
            /** Id */
            id: string;
            /** Route */
            route: string;
            /**
             * Speed Scale
             * @default 1
             */
            speed_scale: number;
            /** Queued Ns */
            queued_ns: number;
            /**
             * Queued By
             * @default
             */
            queued_by: string;
        };
        /**
         * Reason
         * @description A code for machines and a sentence for people, e.g. ("obstacle", "0.42 m ahead at (3.1, 0.9)"); since when it holds.
         */
        Reason: {
            code: components["schemas"]["ReasonCode"];
            /**
             * Text
             * @default
             */
            text: string;
            /** Since Ns */
            since_ns?: number | null;
        };
        /**
         * ReasonCode
         * @description Why a robot drives, waits or stands; machine-readable.
         * @enum {string}
         */
        ReasonCode: "route" | "detour" | "yielding" | "at_stop" | "route_done" | "manual" | "idle" | "paused" | "obstacle" | "robot_ahead" | "emergency_stop" | "pose_stale" | "command_stale" | "obstacles_unknown" | "outside_area" | "waypoint_missing" | "not_connected" | "driver_fault" | "protective_field" | "battery_empty";
        /**
         * RedisView
         * @description Whether Redis answers.
         */
        RedisView: {
            /** Reachable */
            reachable: boolean;
            /**
             * Since Ns
             * @description Since when it does not.
             */
            since_ns: number | null;
        };
        /**
         * RegistrationView
         * @description Where the robot sends its STATUS datagrams, how often to expect poses, and how soon to register again.
         */
        RegistrationView: {
            /** Robots Udp */
            robots_udp: number;
            /** Pose Rate Hz */
            pose_rate_hz: number;
            /** Again S */
            again_s: number;
        };
        /**
         * Release
         * @description A person's word that it is safe to move again.
         * @example {
         *       "confirm": true
         *     }
         */
        Release: {
            /**
             * Confirm
             * @constant
             */
            confirm: true;
        };
        /**
         * Response
         * @description Robot to server: the command it answers, what was really applied, and when the target was reached (empty before).
         * @example {
         *       "applied_speed_mps": 0.3,
         *       "command_order": [
         *         3,
         *         1207
         *       ],
         *       "command_stamp_ns": 1700000000000000000,
         *       "movement": "MoveTo",
         *       "outcome": "accepted",
         *       "robot": "wifibot-14",
         *       "stamp_ns": 1700000000020000000
         *     }
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
         * @example {
         *       "box_length_m": 0.8,
         *       "box_start_m": 0,
         *       "box_width_m": 0.6
         *     }
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
            /**
             * Box Robots
             * @description Whether other robots in the box count.
             */
            box_robots?: boolean | null;
            /**
             * Box Unknown
             * @description Whether floor in the box that no camera sees counts.
             */
            box_unknown?: boolean | null;
            /**
             * Detours
             * @description Whether it drives around what blocks it.
             */
            detours?: boolean | null;
            /**
             * Detour After S
             * @description How long it waits before it looks for a way around.
             */
            detour_after_s?: number | null;
            /**
             * Detour Clearance M
             * @description What it keeps free beside itself on a detour.
             */
            detour_clearance_m?: number | null;
            /**
             * Priority
             * @description Among robots that wait for each other the one with the least yields; of equals the last by id.
             * @default 0
             */
            priority: number;
        };
        /**
         * RobotState
         * @description What a robot does, in a word; `lost`: no camera has seen it lately.
         * @enum {string}
         */
        RobotState: "offline" | "emergency_stop" | "fault" | "manual" | "lost" | "driving" | "waiting" | "paused" | "idle";
        /**
         * RobotView
         * @description A robot with all that is known of it.
         */
        RobotView: {
            /** Id */
            id: string;
            /** Kind */
            kind: string;
            /**
             * Footprint
             * @description Metres, seen from the rotation centre: x forward, y left.
             */
            footprint: [
                number,
                number
            ][];
            limits: components["schemas"]["Limits"];
            connection: components["schemas"]["Connection"];
            /** Last Heard Ns */
            last_heard_ns: number | null;
            state: components["schemas"]["RobotState"];
            /** @description Why it waits or stands still; null while it drives. */
            reason: components["schemas"]["Reason"] | null;
            pose: components["schemas"]["PoseView"] | null;
            status: components["schemas"]["StatusView"] | null;
            command: components["schemas"]["CommandView"] | null;
            /** @description Its newest one, also when that is over. */
            assignment: components["schemas"]["Assignment"] | null;
            guidance: components["schemas"]["GuidanceView"] | null;
            manual: components["schemas"]["ManualView"] | null;
            /** @description In force: the lab's, with the operator's settings over it. */
            obstacle_box: components["schemas"]["ObstacleBox"];
            /** @description In force: whether and when it drives around what blocks it. */
            detours: components["schemas"]["Detours"];
            /** @description What the operator has set; null falls back to the lab description. */
            settings: components["schemas"]["RobotSettings"];
        };
        /**
         * Role
         * @description What somebody may do: look; change and drive; manage users and tokens; or be one robot.
         * @enum {string}
         */
        Role: "viewer" | "operator" | "admin" | "robot";
        /**
         * Ros2Base
         * @description Where on ROS 2 a vehicle with driver `ros2` is: the namespace of its topics (none: the vehicle's id, dashes as
         *     underscores, after `robot_` if it begins with a digit) and the DDS domain (none: ROS_DOMAIN_ID). `scan` says whether it has a
         *     laser scanner; `scan_pose` is the scanner's x, y (m) and yaw (rad) seen from the rotation centre.
         */
        Ros2Base: {
            /** Namespace */
            namespace?: string | null;
            /** Domain */
            domain?: number | null;
            /**
             * Scan
             * @default true
             */
            scan: boolean;
            /**
             * Scan Pose
             * @default [
             *       0,
             *       0,
             *       0
             *     ]
             */
            scan_pose: [
                number,
                number,
                number
            ];
        };
        /**
         * Route
         * @description Ordered legs, driven once or looped.
         * @example {
         *       "id": "charge",
         *       "legs": [
         *         {
         *           "speed_mps": 0.3,
         *           "waypoint": "charger"
         *         }
         *       ],
         *       "loop": false
         *     }
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
        /**
         * RunState
         * @description collecting: cameras look at the floor tags; refining: all is being computed; proposed: a person has to decide; failed:
         *     it gave nothing, `text` says why; accepted, discarded: it was decided.
         * @enum {string}
         */
        RunState: "collecting" | "refining" | "proposed" | "failed" | "accepted" | "discarded";
        /**
         * RunTimingsView
         * @description A run's stages in the order in which they happen, kind by kind.
         */
        RunTimingsView: {
            /** Name */
            name: string;
            /** Start Ns */
            start_ns: number;
            /** Processes */
            processes: string[];
            /** Stages */
            stages: components["schemas"]["StageView"][];
        };
        /**
         * ScannerSpec
         * @description A 2D safety scanner. `pose` is its x, y (m) and yaw (rad) seen from the rotation centre; its `beams` lie evenly over
         *     `field_rad` around that yaw, both borders included unless it looks all around. It measures from `range_min_m` to
         *     `range_m`, `rate_hz` times a second.
         */
        ScannerSpec: {
            /**
             * Pose
             * @default [
             *       0,
             *       0,
             *       0
             *     ]
             */
            pose: [
                number,
                number,
                number
            ];
            /**
             * Field Rad
             * @default 4.71238898038469
             */
            field_rad: number;
            /**
             * Beams
             * @default 271
             */
            beams: number;
            /**
             * Range Min M
             * @default 0.02
             */
            range_min_m: number;
            /**
             * Range M
             * @default 4
             */
            range_m: number;
            /**
             * Rate Hz
             * @default 33
             */
            rate_hz: number;
        };
        /**
         * SeriesView
         * @description A time graph: seconds since the run's start, and the median and highest ms of each short while.
         */
        SeriesView: {
            /** Seconds */
            seconds: number[];
            /** Median */
            median: number[];
            /** Highest */
            highest: number[];
        };
        /**
         * SessionView
         * @description Who is logged in; `robot` is the one that a robot's token is bound to.
         */
        SessionView: {
            /**
             * User
             * @example admin
             */
            user: string;
            role: components["schemas"]["Role"];
            /** Robot */
            robot?: string | null;
        };
        /**
         * SimulatedObject
         * @description A person or a pallet on the simulated floor; a person with `path` walks it back and forth at `speed_mps`.
         * @example {
         *       "id": "pallet-1",
         *       "kind": "pallet",
         *       "x": 1,
         *       "y": 1
         *     }
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
        /**
         * SpeedZone
         * @description A part of the floor where robots drive no faster than `speed_mps`: an outline in metres, map frame. It holds for a robot
         *     while any part of it is inside.
         * @example {
         *       "id": "doorway",
         *       "outline": [
         *         [
         *           3,
         *           1
         *         ],
         *         [
         *           4,
         *           1
         *         ],
         *         [
         *           4,
         *           2
         *         ],
         *         [
         *           3,
         *           2
         *         ]
         *       ],
         *       "speed_mps": 0.2
         *     }
         */
        SpeedZone: {
            /** Id */
            id: string;
            /** Outline */
            outline: [
                number,
                number
            ][];
            /** Speed Mps */
            speed_mps: number;
        };
        /**
         * StageView
         * @description A stage of a kind of process, over all processes of that kind.
         */
        StageView: {
            /**
             * Kind
             * @example camera
             */
            kind: string;
            /**
             * Stage
             * @example total
             */
            stage: string;
            box: components["schemas"]["BoxView"];
            series: components["schemas"]["SeriesView"];
        };
        /**
         * Start
         * @description Which route to drive; `speed_scale` multiplies the speed of every leg.
         * @example {
         *       "route": "charge",
         *       "speed_scale": 1
         *     }
         */
        Start: {
            /**
             * Route
             * @example charge
             */
            route: string;
            /**
             * Speed Scale
             * @default 1
             */
            speed_scale: number;
        };
        /**
         * StartCalibration
         * @description Which cameras are to look at the floor tags anew; null: all.
         * @example {
         *       "cameras": [
         *         "cam0",
         *         "cam1"
         *       ]
         *     }
         * @example {}
         */
        StartCalibration: {
            /** Cameras */
            cameras?: string[] | null;
        };
        /**
         * StatusView
         * @description What the robot says of itself, as last heard.
         */
        StatusView: {
            /** Stamp Ns */
            stamp_ns: number;
            /**
             * Age S
             * @description Seconds, by the server's clock, when the answer was made.
             */
            age_s: number;
            /**
             * X
             * @description Where it believes to be; null until it has been localized once.
             */
            x: number | null;
            /** Y */
            y: number | null;
            /** Yaw */
            yaw: number | null;
            /** Linear Mps */
            linear_mps: number;
            /** Angular Radps */
            angular_radps: number;
            /** Ip */
            ip: string;
            /**
             * Battery
             * @description Share of full charge.
             */
            battery: number | null;
            mode: components["schemas"]["Mode"];
            /** Faults */
            faults: string[];
            /** @description Why the robot itself holds still, if it does. */
            stopped_by: components["schemas"]["Reason"] | null;
            /** Pose Age S */
            pose_age_s: number | null;
            /** Command Age S */
            command_age_s: number | null;
            /**
             * Command Loss
             * @description Share of guidance's commands of the last seconds that did not reach the robot in time.
             */
            command_loss: number | null;
            /**
             * Loss
             * @description Share of the robot's statuses of the last seconds that did not arrive here.
             */
            loss: number | null;
        };
        /**
         * StopAction
         * @description What a robot stops for.
         * @enum {string}
         */
        StopAction: "pick_up" | "drop_off" | "charge";
        /**
         * Target
         * @description Where to drive, metres in the map frame, and the heading to end with (rad) if it matters.
         */
        Target: {
            /** X */
            x: number;
            /** Y */
            y: number;
            /** Yaw */
            yaw?: number | null;
        };
        /**
         * TimingRunView
         * @description A run whose timings this server's machine has: one start of the system there. `newest_ns` is when it was last written
         *     to.
         */
        TimingRunView: {
            /** Name */
            name: string;
            /** Start Ns */
            start_ns: number;
            /** Newest Ns */
            newest_ns: number;
            /** Lab */
            lab: string;
            /** Machine */
            machine: string;
            /** Version */
            version: string;
            /** Processes */
            processes: string[];
            /** Size Bytes */
            size_bytes: number;
        };
        /**
         * TokenView
         * @description A token without its text; `last_used_ns` is exact to the minute.
         */
        TokenView: {
            /** Id */
            id: string;
            /** Name */
            name: string;
            role: components["schemas"]["Role"];
            /** Robot */
            robot: string | null;
            /** Created Ns */
            created_ns: number;
            /** Created By */
            created_by: string;
            /** Last Used Ns */
            last_used_ns: number | null;
        };
        /**
         * Twist
         * @description What the hand on the stick asks for: m/s forward, rad/s to the left.
         * @example {
         *       "angular_radps": -0.5,
         *       "linear_mps": 0.2
         *     }
         */
        Twist: {
            /**
             * Linear Mps
             * @example 0.2
             */
            linear_mps: number;
            /**
             * Angular Radps
             * @example -0.5
             */
            angular_radps: number;
        };
        /**
         * UdpView
         * @description What became of the datagrams that robots sent, counted since the intake started.
         */
        UdpView: {
            /**
             * Listening
             * @description Whether the intake says so; the counts are what it said last.
             */
            listening: boolean;
            /** Received */
            received: number;
            /** Accepted */
            accepted: number;
            /**
             * Undecodable
             * @description Short, garbled, of another version, forged, or unsigned although a key is set.
             */
            undecodable: number;
            /** Wrong Kind */
            wrong_kind: number;
            /** Unknown Robot */
            unknown_robot: number;
            /**
             * Wrong Sender
             * @description The envelope's sender is not the robot that the status is of.
             */
            wrong_sender: number;
            /** Old */
            old: number;
            /** Future */
            future: number;
            /** Duplicate */
            duplicate: number;
            /** Out Of Order */
            out_of_order: number;
            /** Last Problem */
            last_problem: string | null;
        };
        /**
         * UserChange
         * @description What to change of a user; their sessions end.
         * @example {
         *       "role": "viewer"
         *     }
         */
        UserChange: {
            role?: components["schemas"]["Role"] | null;
            /** Password */
            password?: string | null;
        };
        /**
         * UserView
         * @description A user.
         */
        UserView: {
            /** Name */
            name: string;
            role: components["schemas"]["Role"];
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
         * VehicleSpec
         * @description A robot. `footprint` is its outline in metres seen from its rotation centre (x forward, y left); `scanner` is its safety
         *     scanner, if the simulated lab is to have one (a ROS 2 base has its own, see `ros2`).
         */
        VehicleSpec: {
            /** Id */
            id: string;
            /**
             * Kind
             * @enum {string}
             */
            kind: "wifibot" | "turtlebot" | "agv" | "freke";
            /** Footprint */
            footprint: [
                number,
                number
            ][];
            /**
             * Driver
             * @default sim
             */
            driver: string;
            tag: components["schemas"]["VehicleTag"];
            /**
             * @default {
             *       "speed_mps": 0.5,
             *       "yaw_rate_radps": 1,
             *       "acceleration_mps2": 0.5,
             *       "braking_mps2": 2,
             *       "yaw_acceleration_radps2": 4,
             *       "jerk_mps3": 4,
             *       "yaw_jerk_radps3": 40
             *     }
             */
            limits: components["schemas"]["Limits"];
            /**
             * @default {
             *       "start_m": 1,
             *       "length_m": 1,
             *       "width_m": 0.6,
             *       "stop_at_waypoint": false,
             *       "robots": true,
             *       "unknown": true
             *     }
             */
            obstacle_box: components["schemas"]["ObstacleBox"];
            /**
             * @default {
             *       "enabled": true,
             *       "after_s": 3,
             *       "clearance_m": 0.3
             *     }
             */
            detours: components["schemas"]["Detours"];
            ros2?: components["schemas"]["Ros2Base"] | null;
            /**
             * @default {
             *       "gpss": {},
             *       "go_to_goal": {},
             *       "frenet": {}
             *     }
             */
            control: components["schemas"]["ControlSpec"];
            scanner?: components["schemas"]["ScannerSpec"] | null;
            /**
             * @default {
             *       "margin_m": 0.08,
             *       "reaction_s": 0.15,
             *       "clear_s": 1,
             *       "warning_s": 1,
             *       "warning_margin_m": 0.2,
             *       "slow_mps": 0.12,
             *       "neighbours": 3
             *     }
             */
            protective_field: components["schemas"]["ProtectiveFieldSpec"];
            /**
             * @default {
             *       "low": 0.2,
             *       "empty": 0.05
             *     }
             */
            battery: components["schemas"]["BatterySpec"];
        };
        /**
         * VehicleTag
         * @description The tag on a vehicle's roof. `height_m` is its height above the floor; `offset` is x, y (m) and yaw (rad) of its
         *     centre seen from the vehicle's rotation centre.
         */
        VehicleTag: {
            /**
             * Family
             * @default tag36h11
             * @constant
             */
            family: "tag36h11";
            /** Id */
            id: number;
            /** Size M */
            size_m: number;
            /** Height M */
            height_m: number;
            /**
             * Offset
             * @default [
             *       0,
             *       0,
             *       0
             *     ]
             */
            offset: [
                number,
                number,
                number
            ];
        };
        /**
         * Waypoint
         * @description A place on the floor: metres in the map frame; the radius within which it counts as reached; the heading (rad) to
         *     leave it with if that matters.
         * @example {
         *       "area": "camp",
         *       "id": "charger",
         *       "radius_m": 0.15,
         *       "x": 1,
         *       "y": 1
         *     }
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
        /**
         * ZoneSpec
         * @description An exclusive zone cut into sub-areas (polygons in metres, map frame); vehicles nearer than `detection_m` matter.
         */
        ZoneSpec: {
            /** Id */
            id: string;
            /** Detection M */
            detection_m: number;
            /** Subareas */
            subareas: {
                [key: string]: [
                    number,
                    number
                ][];
            };
        };
    };
    responses: never;
    parameters: never;
    requestBodies: never;
    headers: never;
    pathItems: never;
}
export type Area = components['schemas']['Area'];
export type Assignment = components['schemas']['Assignment'];
export type AssignmentState = components['schemas']['AssignmentState'];
export type BatterySpec = components['schemas']['BatterySpec'];
export type Blockage = components['schemas']['Blockage'];
export type BoxView = components['schemas']['BoxView'];
export type CalibratedCamera = components['schemas']['CalibratedCamera'];
export type CalibratedFloorTag = components['schemas']['CalibratedFloorTag'];
export type Calibration = components['schemas']['Calibration'];
export type CalibrationProposal = components['schemas']['CalibrationProposal'];
export type CalibrationRun = components['schemas']['CalibrationRun'];
export type CalibrationView = components['schemas']['CalibrationView'];
export type CameraComparison = components['schemas']['CameraComparison'];
export type CameraFault = components['schemas']['CameraFault'];
export type CameraSpec = components['schemas']['CameraSpec'];
export type CameraStateView = components['schemas']['CameraStateView'];
export type CameraView = components['schemas']['CameraView'];
export type ChannelView = components['schemas']['ChannelView'];
export type CommandView = components['schemas']['CommandView'];
export type Condition = components['schemas']['Condition'];
export type Connection = components['schemas']['Connection'];
export type ControlSpec = components['schemas']['ControlSpec'];
export type Decision = components['schemas']['Decision'];
export type Detours = components['schemas']['Detours'];
export type EmergencyStop = components['schemas']['EmergencyStop'];
export type Engage = components['schemas']['Engage'];
export type Event = components['schemas']['Event'];
export type EventLevel = components['schemas']['EventLevel'];
export type ExtrinsicsView = components['schemas']['ExtrinsicsView'];
export type FaultKind = components['schemas']['FaultKind'];
export type FloorTagComparison = components['schemas']['FloorTagComparison'];
export type FloorTags = components['schemas']['FloorTags'];
export type FrenetControl = components['schemas']['FrenetControl'];
export type GoToGoalControl = components['schemas']['GoToGoalControl'];
export type GpssControl = components['schemas']['GpssControl'];
export type GuidanceView = components['schemas']['GuidanceView'];
export type HttpValidationError = components['schemas']['HTTPValidationError'];
export type HealthSummary = components['schemas']['HealthSummary'];
export type HealthView = components['schemas']['HealthView'];
export type Intrinsics = components['schemas']['Intrinsics'];
export type Introduction = components['schemas']['Introduction'];
export type LabView = components['schemas']['LabView'];
export type Leg = components['schemas']['Leg'];
export type Limits = components['schemas']['Limits'];
export type LiveChanges = components['schemas']['LiveChanges'];
export type LiveSnapshot = components['schemas']['LiveSnapshot'];
export type Login = components['schemas']['Login'];
export type ManualDrive = components['schemas']['ManualDrive'];
export type ManualView = components['schemas']['ManualView'];
export type Mode = components['schemas']['Mode'];
export type Movement = components['schemas']['Movement'];
export type NewToken = components['schemas']['NewToken'];
export type NewTokenView = components['schemas']['NewTokenView'];
export type NewUser = components['schemas']['NewUser'];
export type NewUserView = components['schemas']['NewUserView'];
export type ObstacleBox = components['schemas']['ObstacleBox'];
export type ObstaclesView = components['schemas']['ObstaclesView'];
export type Outcome = components['schemas']['Outcome'];
export type Ports = components['schemas']['Ports'];
export type PoseView = components['schemas']['PoseView'];
export type Problem = components['schemas']['Problem'];
export type ProblemView = components['schemas']['ProblemView'];
export type ProcessState = components['schemas']['ProcessState'];
export type ProtectiveFieldSpec = components['schemas']['ProtectiveFieldSpec'];
export type QueuedRoute = components['schemas']['QueuedRoute'];
export type Reason = components['schemas']['Reason'];
export type ReasonCode = components['schemas']['ReasonCode'];
export type RedisView = components['schemas']['RedisView'];
export type RegistrationView = components['schemas']['RegistrationView'];
export type Release = components['schemas']['Release'];
export type Response = components['schemas']['Response'];
export type RobotSettings = components['schemas']['RobotSettings'];
export type RobotState = components['schemas']['RobotState'];
export type RobotView = components['schemas']['RobotView'];
export type Role = components['schemas']['Role'];
export type Ros2Base = components['schemas']['Ros2Base'];
export type Route = components['schemas']['Route'];
export type RunState = components['schemas']['RunState'];
export type RunTimingsView = components['schemas']['RunTimingsView'];
export type ScannerSpec = components['schemas']['ScannerSpec'];
export type SeriesView = components['schemas']['SeriesView'];
export type SessionView = components['schemas']['SessionView'];
export type SimulatedObject = components['schemas']['SimulatedObject'];
export type SpeedZone = components['schemas']['SpeedZone'];
export type StageView = components['schemas']['StageView'];
export type Start = components['schemas']['Start'];
export type StartCalibration = components['schemas']['StartCalibration'];
export type StatusView = components['schemas']['StatusView'];
export type StopAction = components['schemas']['StopAction'];
export type Target = components['schemas']['Target'];
export type TimingRunView = components['schemas']['TimingRunView'];
export type TokenView = components['schemas']['TokenView'];
export type Twist = components['schemas']['Twist'];
export type UdpView = components['schemas']['UdpView'];
export type UserChange = components['schemas']['UserChange'];
export type UserView = components['schemas']['UserView'];
export type ValidationError = components['schemas']['ValidationError'];
export type VehicleSpec = components['schemas']['VehicleSpec'];
export type VehicleTag = components['schemas']['VehicleTag'];
export type Waypoint = components['schemas']['Waypoint'];
export type ZoneSpec = components['schemas']['ZoneSpec'];
export type $defs = Record<string, never>;
export interface operations {
    who_am_i: {
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
                    "application/json": components["schemas"]["SessionView"];
                };
            };
            /** @description The body is not JSON. */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Not logged in, or the token is not valid. */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The role is too small, or a change by cookie lacks the header `X-Lilliput: 1`. */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Redis (or what else is needed) is out of reach; nothing was changed. */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    log_in: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["Login"];
            };
        };
        responses: {
            /** @description Successful Response */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["SessionView"];
                };
            };
            /** @description The body is not JSON. */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Not logged in, or the token is not valid. */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
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
            /** @description Too many wrong passwords; the header `Retry-After` says how long to wait. */
            429: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Redis (or what else is needed) is out of reach; nothing was changed. */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    log_out: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
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
            /** @description The body is not JSON. */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Not logged in, or the token is not valid. */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The role is too small, or a change by cookie lacks the header `X-Lilliput: 1`. */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Redis (or what else is needed) is out of reach; nothing was changed. */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    get_lab: {
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
                    "application/json": components["schemas"]["LabView"];
                };
            };
            /** @description The body is not JSON. */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Not logged in, or the token is not valid. */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The role is too small, or a change by cookie lacks the header `X-Lilliput: 1`. */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Redis (or what else is needed) is out of reach; nothing was changed. */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    get_health: {
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
                    "application/json": components["schemas"]["HealthView"] | components["schemas"]["HealthSummary"];
                };
            };
        };
    };
    list_events: {
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
            /** @description The body is not JSON. */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Not logged in, or the token is not valid. */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The role is too small, or a change by cookie lacks the header `X-Lilliput: 1`. */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
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
            /** @description Redis (or what else is needed) is out of reach; nothing was changed. */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    list_robots: {
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
                    "application/json": components["schemas"]["RobotView"][];
                };
            };
            /** @description The body is not JSON. */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Not logged in, or the token is not valid. */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The role is too small, or a change by cookie lacks the header `X-Lilliput: 1`. */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Redis (or what else is needed) is out of reach; nothing was changed. */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    get_robot: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                robot_id: string;
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
                    "application/json": components["schemas"]["RobotView"];
                };
            };
            /** @description The body is not JSON. */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Not logged in, or the token is not valid. */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The role is too small, or a change by cookie lacks the header `X-Lilliput: 1`. */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description It does not exist. */
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
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
            /** @description Redis (or what else is needed) is out of reach; nothing was changed. */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    list_responses: {
        parameters: {
            query?: {
                count?: number;
            };
            header?: never;
            path: {
                robot_id: string;
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
                    "application/json": components["schemas"]["Response"][];
                };
            };
            /** @description The body is not JSON. */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Not logged in, or the token is not valid. */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The role is too small, or a change by cookie lacks the header `X-Lilliput: 1`. */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description It does not exist. */
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
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
            /** @description Redis (or what else is needed) is out of reach; nothing was changed. */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    post_response: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                robot_id: string;
            };
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
            /** @description The body is not JSON. */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Not logged in, or the token is not valid. */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The role is too small, or a change by cookie lacks the header `X-Lilliput: 1`. */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description It does not exist. */
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
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
            /** @description Redis (or what else is needed) is out of reach; nothing was changed. */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    put_robot_settings: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                robot_id: string;
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
            /** @description The body is not JSON. */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Not logged in, or the token is not valid. */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The role is too small, or a change by cookie lacks the header `X-Lilliput: 1`. */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description It does not exist. */
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
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
            /** @description Redis (or what else is needed) is out of reach; nothing was changed. */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    start_route: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                robot_id: string;
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
            /** @description The body is not JSON. */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Not logged in, or the token is not valid. */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The role is too small, or a change by cookie lacks the header `X-Lilliput: 1`. */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description It does not exist. */
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Its state forbids this; the detail says why. */
            409: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
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
            /** @description Redis (or what else is needed) is out of reach; nothing was changed. */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    stop_route: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                robot_id: string;
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
            /** @description The body is not JSON. */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Not logged in, or the token is not valid. */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The role is too small, or a change by cookie lacks the header `X-Lilliput: 1`. */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description It does not exist. */
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Its state forbids this; the detail says why. */
            409: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
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
            /** @description Redis (or what else is needed) is out of reach; nothing was changed. */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    pause_route: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                robot_id: string;
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
            /** @description The body is not JSON. */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Not logged in, or the token is not valid. */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The role is too small, or a change by cookie lacks the header `X-Lilliput: 1`. */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description It does not exist. */
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Its state forbids this; the detail says why. */
            409: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
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
            /** @description Redis (or what else is needed) is out of reach; nothing was changed. */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    resume_route: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                robot_id: string;
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
            /** @description The body is not JSON. */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Not logged in, or the token is not valid. */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The role is too small, or a change by cookie lacks the header `X-Lilliput: 1`. */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description It does not exist. */
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Its state forbids this; the detail says why. */
            409: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
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
            /** @description Redis (or what else is needed) is out of reach; nothing was changed. */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    skip_leg: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                robot_id: string;
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
            /** @description The body is not JSON. */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Not logged in, or the token is not valid. */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The role is too small, or a change by cookie lacks the header `X-Lilliput: 1`. */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description It does not exist. */
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Its state forbids this; the detail says why. */
            409: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
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
            /** @description Redis (or what else is needed) is out of reach; nothing was changed. */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    proceed: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                robot_id: string;
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
            /** @description The body is not JSON. */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Not logged in, or the token is not valid. */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The role is too small, or a change by cookie lacks the header `X-Lilliput: 1`. */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description It does not exist. */
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Its state forbids this; the detail says why. */
            409: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
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
            /** @description Redis (or what else is needed) is out of reach; nothing was changed. */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    cancel_route: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                robot_id: string;
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
            /** @description The body is not JSON. */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Not logged in, or the token is not valid. */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The role is too small, or a change by cookie lacks the header `X-Lilliput: 1`. */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description It does not exist. */
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Its state forbids this; the detail says why. */
            409: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
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
            /** @description Redis (or what else is needed) is out of reach; nothing was changed. */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    queue_route: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                robot_id: string;
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
            201: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Assignment"];
                };
            };
            /** @description The body is not JSON. */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Not logged in, or the token is not valid. */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The role is too small, or a change by cookie lacks the header `X-Lilliput: 1`. */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description It does not exist. */
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Its state forbids this; the detail says why. */
            409: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
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
            /** @description Redis (or what else is needed) is out of reach; nothing was changed. */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    empty_queue: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                robot_id: string;
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
            /** @description The body is not JSON. */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Not logged in, or the token is not valid. */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The role is too small, or a change by cookie lacks the header `X-Lilliput: 1`. */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description It does not exist. */
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
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
            /** @description Redis (or what else is needed) is out of reach; nothing was changed. */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    dequeue_route: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                robot_id: string;
                entry_id: string;
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
            /** @description The body is not JSON. */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Not logged in, or the token is not valid. */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The role is too small, or a change by cookie lacks the header `X-Lilliput: 1`. */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description It does not exist. */
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
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
            /** @description Redis (or what else is needed) is out of reach; nothing was changed. */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    drive_by_hand: {
        parameters: {
            query?: never;
            header?: {
                /** @description Tells one tab, or one thread of a program, from another of the same login: each has a hand of its own. */
                "X-Lilliput-Tab"?: string | null;
            };
            path: {
                robot_id: string;
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
            /** @description The body is not JSON. */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Not logged in, or the token is not valid. */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The role is too small, or a change by cookie lacks the header `X-Lilliput: 1`. */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description It does not exist. */
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Its state forbids this; the detail says why. */
            409: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
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
            /** @description Redis (or what else is needed) is out of reach; nothing was changed. */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    let_go: {
        parameters: {
            query?: never;
            header?: {
                /** @description Tells one tab, or one thread of a program, from another of the same login: each has a hand of its own. */
                "X-Lilliput-Tab"?: string | null;
            };
            path: {
                robot_id: string;
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
            /** @description The body is not JSON. */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Not logged in, or the token is not valid. */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The role is too small, or a change by cookie lacks the header `X-Lilliput: 1`. */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description It does not exist. */
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Its state forbids this; the detail says why. */
            409: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
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
            /** @description Redis (or what else is needed) is out of reach; nothing was changed. */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    register_robot: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                robot_id: string;
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["Introduction"];
            };
        };
        responses: {
            /** @description Successful Response */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["RegistrationView"];
                };
            };
            /** @description The body is not JSON. */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Not logged in, or the token is not valid. */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The role is too small, or a change by cookie lacks the header `X-Lilliput: 1`. */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description It does not exist. */
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
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
            /** @description Redis (or what else is needed) is out of reach; nothing was changed. */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    stream_commands: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                robot_id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description Server-sent events: first `emergency_stop` (EmergencyStop), again at each of its changes; `command` (Command), only the newest if the robot is slow; a comment every half second while nothing happens. */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    /**
                     * @example event: emergency_stop
                     *     data: {"engaged":false,"epoch":0}
                     */
                    "text/event-stream": string;
                };
            };
            /** @description The body is not JSON. */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Not logged in, or the token is not valid. */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The role is too small, or a change by cookie lacks the header `X-Lilliput: 1`. */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description It does not exist. */
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
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
            /** @description Redis (or what else is needed) is out of reach; nothing was changed. */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    list_waypoints: {
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
                    "application/json": components["schemas"]["Waypoint"][];
                };
            };
            /** @description The body is not JSON. */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Not logged in, or the token is not valid. */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The role is too small, or a change by cookie lacks the header `X-Lilliput: 1`. */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Redis (or what else is needed) is out of reach; nothing was changed. */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    create_waypoint: {
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
            /** @description The body is not JSON. */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Not logged in, or the token is not valid. */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The role is too small, or a change by cookie lacks the header `X-Lilliput: 1`. */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Its state forbids this; the detail says why. */
            409: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
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
            /** @description Redis (or what else is needed) is out of reach; nothing was changed. */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    put_waypoint: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                waypoint_id: string;
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
            /** @description The body is not JSON. */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Not logged in, or the token is not valid. */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The role is too small, or a change by cookie lacks the header `X-Lilliput: 1`. */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
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
            /** @description Redis (or what else is needed) is out of reach; nothing was changed. */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    delete_waypoint: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                waypoint_id: string;
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
            /** @description The body is not JSON. */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Not logged in, or the token is not valid. */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The role is too small, or a change by cookie lacks the header `X-Lilliput: 1`. */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description It does not exist. */
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Its state forbids this; the detail says why. */
            409: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
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
            /** @description Redis (or what else is needed) is out of reach; nothing was changed. */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    list_routes: {
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
                    "application/json": components["schemas"]["Route"][];
                };
            };
            /** @description The body is not JSON. */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Not logged in, or the token is not valid. */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The role is too small, or a change by cookie lacks the header `X-Lilliput: 1`. */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Redis (or what else is needed) is out of reach; nothing was changed. */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    create_route: {
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
            /** @description The body is not JSON. */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Not logged in, or the token is not valid. */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The role is too small, or a change by cookie lacks the header `X-Lilliput: 1`. */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Its state forbids this; the detail says why. */
            409: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
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
            /** @description Redis (or what else is needed) is out of reach; nothing was changed. */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    put_route: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                route_id: string;
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
            /** @description The body is not JSON. */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Not logged in, or the token is not valid. */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The role is too small, or a change by cookie lacks the header `X-Lilliput: 1`. */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Its state forbids this; the detail says why. */
            409: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
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
            /** @description Redis (or what else is needed) is out of reach; nothing was changed. */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    delete_route: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                route_id: string;
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
            /** @description The body is not JSON. */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Not logged in, or the token is not valid. */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The role is too small, or a change by cookie lacks the header `X-Lilliput: 1`. */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description It does not exist. */
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Its state forbids this; the detail says why. */
            409: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
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
            /** @description Redis (or what else is needed) is out of reach; nothing was changed. */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    list_speed_zones: {
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
                    "application/json": components["schemas"]["SpeedZone"][];
                };
            };
            /** @description The body is not JSON. */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Not logged in, or the token is not valid. */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The role is too small, or a change by cookie lacks the header `X-Lilliput: 1`. */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Redis (or what else is needed) is out of reach; nothing was changed. */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    create_speed_zone: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["SpeedZone"];
            };
        };
        responses: {
            /** @description Successful Response */
            201: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["SpeedZone"];
                };
            };
            /** @description The body is not JSON. */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Not logged in, or the token is not valid. */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The role is too small, or a change by cookie lacks the header `X-Lilliput: 1`. */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Its state forbids this; the detail says why. */
            409: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
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
            /** @description Redis (or what else is needed) is out of reach; nothing was changed. */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    put_speed_zone: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                zone_id: string;
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["SpeedZone"];
            };
        };
        responses: {
            /** @description Successful Response */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["SpeedZone"];
                };
            };
            /** @description The body is not JSON. */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Not logged in, or the token is not valid. */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The role is too small, or a change by cookie lacks the header `X-Lilliput: 1`. */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Its state forbids this; the detail says why. */
            409: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
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
            /** @description Redis (or what else is needed) is out of reach; nothing was changed. */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    delete_speed_zone: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                zone_id: string;
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
            /** @description The body is not JSON. */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Not logged in, or the token is not valid. */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The role is too small, or a change by cookie lacks the header `X-Lilliput: 1`. */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description It does not exist. */
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Its state forbids this; the detail says why. */
            409: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
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
            /** @description Redis (or what else is needed) is out of reach; nothing was changed. */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    get_emergency_stop: {
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
            /** @description The body is not JSON. */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Not logged in, or the token is not valid. */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The role is too small, or a change by cookie lacks the header `X-Lilliput: 1`. */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Redis (or what else is needed) is out of reach; nothing was changed. */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    engage_emergency_stop: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["Engage"];
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
            /** @description The body is not JSON. */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Not logged in, or the token is not valid. */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The role is too small, or a change by cookie lacks the header `X-Lilliput: 1`. */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
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
            /** @description Redis is out of reach: the robots on open streams were told to stop, and it is yet to be written. */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    release_emergency_stop: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["Release"];
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
            /** @description The body is not JSON. */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Not logged in, or the token is not valid. */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The role is too small, or a change by cookie lacks the header `X-Lilliput: 1`. */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
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
            /** @description Redis (or what else is needed) is out of reach; nothing was changed. */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    list_cameras: {
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
                    "application/json": components["schemas"]["CameraView"][];
                };
            };
            /** @description The body is not JSON. */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Not logged in, or the token is not valid. */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The role is too small, or a change by cookie lacks the header `X-Lilliput: 1`. */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Redis (or what else is needed) is out of reach; nothing was changed. */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    get_preview: {
        parameters: {
            query?: never;
            header?: {
                "if-none-match"?: string | null;
            };
            path: {
                camera_id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description A JPEG. */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "image/jpeg": string;
                };
            };
            /** @description The picture is still the one of `If-None-Match`. */
            304: {
                headers: {
                    [name: string]: unknown;
                };
                content?: never;
            };
            /** @description The body is not JSON. */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Not logged in, or the token is not valid. */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The role is too small, or a change by cookie lacks the header `X-Lilliput: 1`. */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description It does not exist. */
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
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
            /** @description Redis (or what else is needed) is out of reach; nothing was changed. */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    get_floor: {
        parameters: {
            query?: never;
            header?: {
                "if-none-match"?: string | null;
            };
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description A JPEG. */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "image/jpeg": string;
                };
            };
            /** @description The picture is still the one of `If-None-Match`. */
            304: {
                headers: {
                    [name: string]: unknown;
                };
                content?: never;
            };
            /** @description The body is not JSON. */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Not logged in, or the token is not valid. */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The role is too small, or a change by cookie lacks the header `X-Lilliput: 1`. */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description It does not exist. */
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
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
            /** @description Redis (or what else is needed) is out of reach; nothing was changed. */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    get_calibration: {
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
                    "application/json": components["schemas"]["CalibrationView"];
                };
            };
            /** @description The body is not JSON. */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Not logged in, or the token is not valid. */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The role is too small, or a change by cookie lacks the header `X-Lilliput: 1`. */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Redis (or what else is needed) is out of reach; nothing was changed. */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    start_calibration: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["StartCalibration"];
            };
        };
        responses: {
            /** @description Successful Response */
            201: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["CalibrationRun"];
                };
            };
            /** @description The body is not JSON. */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Not logged in, or the token is not valid. */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The role is too small, or a change by cookie lacks the header `X-Lilliput: 1`. */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Its state forbids this; the detail says why. */
            409: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
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
            /** @description Redis (or what else is needed) is out of reach; nothing was changed. */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    accept_calibration: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["Decision"];
            };
        };
        responses: {
            /** @description Successful Response */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Calibration"];
                };
            };
            /** @description The body is not JSON. */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Not logged in, or the token is not valid. */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The role is too small, or a change by cookie lacks the header `X-Lilliput: 1`. */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Its state forbids this; the detail says why. */
            409: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
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
            /** @description Redis (or what else is needed) is out of reach; nothing was changed. */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    discard_calibration: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["Decision"];
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
            /** @description The body is not JSON. */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Not logged in, or the token is not valid. */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The role is too small, or a change by cookie lacks the header `X-Lilliput: 1`. */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Its state forbids this; the detail says why. */
            409: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
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
            /** @description Redis (or what else is needed) is out of reach; nothing was changed. */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    restore_calibration: {
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
                    "application/json": components["schemas"]["Calibration"];
                };
            };
            /** @description The body is not JSON. */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Not logged in, or the token is not valid. */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The role is too small, or a change by cookie lacks the header `X-Lilliput: 1`. */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Its state forbids this; the detail says why. */
            409: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Redis (or what else is needed) is out of reach; nothing was changed. */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    list_simulated_objects: {
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
                    "application/json": components["schemas"]["SimulatedObject"][];
                };
            };
            /** @description The body is not JSON. */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Not logged in, or the token is not valid. */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The role is too small, or a change by cookie lacks the header `X-Lilliput: 1`. */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description It does not exist. */
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Redis (or what else is needed) is out of reach; nothing was changed. */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    create_simulated_object: {
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
            /** @description The body is not JSON. */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Not logged in, or the token is not valid. */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The role is too small, or a change by cookie lacks the header `X-Lilliput: 1`. */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description It does not exist. */
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Its state forbids this; the detail says why. */
            409: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
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
            /** @description Redis (or what else is needed) is out of reach; nothing was changed. */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    put_simulated_object: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                object_id: string;
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
            /** @description The body is not JSON. */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Not logged in, or the token is not valid. */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The role is too small, or a change by cookie lacks the header `X-Lilliput: 1`. */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description It does not exist. */
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
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
            /** @description Redis (or what else is needed) is out of reach; nothing was changed. */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    delete_simulated_object: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                object_id: string;
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
            /** @description The body is not JSON. */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Not logged in, or the token is not valid. */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The role is too small, or a change by cookie lacks the header `X-Lilliput: 1`. */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description It does not exist. */
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
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
            /** @description Redis (or what else is needed) is out of reach; nothing was changed. */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    put_camera_fault: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                camera_id: string;
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["CameraFault"];
            };
        };
        responses: {
            /** @description Successful Response */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["CameraFault"];
                };
            };
            /** @description The body is not JSON. */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Not logged in, or the token is not valid. */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The role is too small, or a change by cookie lacks the header `X-Lilliput: 1`. */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description It does not exist. */
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
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
            /** @description Redis (or what else is needed) is out of reach; nothing was changed. */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    delete_camera_fault: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                camera_id: string;
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
            /** @description The body is not JSON. */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Not logged in, or the token is not valid. */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The role is too small, or a change by cookie lacks the header `X-Lilliput: 1`. */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description It does not exist. */
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
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
            /** @description Redis (or what else is needed) is out of reach; nothing was changed. */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    list_users: {
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
                    "application/json": components["schemas"]["UserView"][];
                };
            };
            /** @description The body is not JSON. */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Not logged in, or the token is not valid. */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The role is too small, or a change by cookie lacks the header `X-Lilliput: 1`. */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Redis (or what else is needed) is out of reach; nothing was changed. */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    create_user: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["NewUser"];
            };
        };
        responses: {
            /** @description Successful Response */
            201: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["NewUserView"];
                };
            };
            /** @description The body is not JSON. */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Not logged in, or the token is not valid. */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The role is too small, or a change by cookie lacks the header `X-Lilliput: 1`. */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Its state forbids this; the detail says why. */
            409: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
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
            /** @description Redis (or what else is needed) is out of reach; nothing was changed. */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    change_user: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                name: string;
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["UserChange"];
            };
        };
        responses: {
            /** @description Successful Response */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["UserView"];
                };
            };
            /** @description The body is not JSON. */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Not logged in, or the token is not valid. */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The role is too small, or a change by cookie lacks the header `X-Lilliput: 1`. */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description It does not exist. */
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Its state forbids this; the detail says why. */
            409: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
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
            /** @description Redis (or what else is needed) is out of reach; nothing was changed. */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    delete_user: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                name: string;
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
            /** @description The body is not JSON. */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Not logged in, or the token is not valid. */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The role is too small, or a change by cookie lacks the header `X-Lilliput: 1`. */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description It does not exist. */
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Its state forbids this; the detail says why. */
            409: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
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
            /** @description Redis (or what else is needed) is out of reach; nothing was changed. */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    list_tokens: {
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
                    "application/json": components["schemas"]["TokenView"][];
                };
            };
            /** @description The body is not JSON. */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Not logged in, or the token is not valid. */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The role is too small, or a change by cookie lacks the header `X-Lilliput: 1`. */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Redis (or what else is needed) is out of reach; nothing was changed. */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    issue_token: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["NewToken"];
            };
        };
        responses: {
            /** @description Successful Response */
            201: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["NewTokenView"];
                };
            };
            /** @description The body is not JSON. */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Not logged in, or the token is not valid. */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The role is too small, or a change by cookie lacks the header `X-Lilliput: 1`. */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Its state forbids this; the detail says why. */
            409: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
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
            /** @description Redis (or what else is needed) is out of reach; nothing was changed. */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    revoke_token: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                token_id: string;
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
            /** @description The body is not JSON. */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Not logged in, or the token is not valid. */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The role is too small, or a change by cookie lacks the header `X-Lilliput: 1`. */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description It does not exist. */
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
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
            /** @description Redis (or what else is needed) is out of reach; nothing was changed. */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    list_timing_runs: {
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
                    "application/json": components["schemas"]["TimingRunView"][];
                };
            };
            /** @description The body is not JSON. */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Not logged in, or the token is not valid. */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The role is too small, or a change by cookie lacks the header `X-Lilliput: 1`. */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Redis (or what else is needed) is out of reach; nothing was changed. */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
    get_timings: {
        parameters: {
            query?: {
                last_s?: number | null;
            };
            header?: never;
            path: {
                run: string;
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
                    "application/json": components["schemas"]["RunTimingsView"];
                };
            };
            /** @description The body is not JSON. */
            400: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description Not logged in, or the token is not valid. */
            401: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description The role is too small, or a change by cookie lacks the header `X-Lilliput: 1`. */
            403: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
            /** @description It does not exist. */
            404: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
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
            /** @description Redis (or what else is needed) is out of reach; nothing was changed. */
            503: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Problem"];
                };
            };
        };
    };
}
