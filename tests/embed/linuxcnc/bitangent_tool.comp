component bitangent_tool
"Two-contact tool position over a footprint point, one each period";

description """Drops a toroidal cutter over (foot-x, foot-y) on the part and leans it until it touches a second
time. Part and tool are made when the component is loaded; a controller of its own reads them
from where it keeps them.""";

pin in float foot_x "footprint point, mm, part frame";
pin in float foot_y;
pin in u32 nodes_max = 2000 "most tree nodes a drop or a tilt may visit: bounds the time";

pin out bit valid "the pose below is of this period and proven safe";
pin out s32 outcome "btg_status: 0 two contacts, 1 osculating, 2 single, 3 none, 4 budget, < 0 error";
pin out float tip_x "tool tip, mm; kept from the last valid period, as all below";
pin out float tip_y;
pin out float tip_z;
pin out float axis_x "unit tool axis, tip to holder";
pin out float axis_y;
pin out float axis_z;
pin out float tilt "degrees";
pin out float gouge_bound "mm: proven, the tool is nowhere deeper in the part";

pin out u32 periods "how often this ran";
pin out u32 invalid "how many of them without a valid pose";
pin out u32 cut_short "how many of them with the budget spent";

// A pin's name is a macro below ;; that is why the header stands here, and why no pin is called
// like a member or a parameter in it (node_budget, tip, axis, bound_mm).
include <bitangent/bitangent.h>;
include <stdlib.h>;
include <string.h>;

option singleton yes;
option extra_setup yes;
option extra_cleanup yes;
function _ fp;
author "The Bitangent authors";
license "MIT";
;;

static btg_part *part;
static btg_tool tool;
static btg_solver_def solver;
static void *workspace;
static size_t workspace_bytes;
static btg_position last;
static const btg_position *neighbour;

static btg_status make_part(btg_message *message) {
    static const double heights[16] = {80,  65,  90, 85,  80, 85,  90,  95,
                                       100, 105, 95, 100, 90, 100, 100, 85};
    double points[48];
    int i;
    for (i = 0; i < 16; i++) {
        points[3 * i] = 50 * (i / 4);
        points[3 * i + 1] = 50 * (i % 4);
        points[3 * i + 2] = heights[i];
    }
    btg_surface_def surface = {3, 3, 4, 4, points, NULL, NULL, NULL};
    btg_part_def def = btg_part_def_default();
    def.surfaces = &surface;
    def.surface_count = 1;
    return btg_part_create(&def, &part, message);
}

// Load time: pins do not exist yet, memory may still be asked for.
EXTRA_SETUP() {
    btg_message message;
    btg_tool_def def = btg_tool_def_default();
    (void)__comp_inst;
    (void)prefix;
    (void)extra_arg;
    solver = btg_solver_def_default();
    if (make_part(&message) < 0 || btg_tool_init(&def, &tool, &message) < 0) {
        rtapi_print_msg(RTAPI_MSG_ERR, "bitangent_tool: %s\n", message.text);
        return -EINVAL;
    }
    workspace_bytes = btg_workspace_size(part);
    workspace = malloc(workspace_bytes);
    if (!workspace) return -ENOMEM;
    memset(workspace, 0, workspace_bytes); // the pages are there before the first period
    return 0;
}

EXTRA_CLEANUP() {
    free(workspace);
    btg_part_destroy(part);
}

// Each period: bounded by nodes_max; no memory, locks or system calls.
FUNCTION(_) {
    btg_position at;
    (void)period;
    solver.node_budget = nodes_max > 0 ? nodes_max : 1;
    outcome = btg_position_follow(part, &tool, &solver, foot_x, foot_y, neighbour, workspace,
                                  workspace_bytes, &at);
    periods++;
    cut_short += outcome == BTG_BUDGET;
    valid = outcome >= 0 && outcome != BTG_NO_CONTACT && at.bound_mm <= solver.tolerance_mm;
    if (!valid) {
        invalid++;
        return;
    }
    tip_x = at.tip.x;
    tip_y = at.tip.y;
    tip_z = at.tip.z;
    axis_x = at.axis.x;
    axis_y = at.axis.y;
    axis_z = at.axis.z;
    tilt = at.tilt_rad * 57.29577951308232;
    gouge_bound = at.bound_mm;
    last = at;
    neighbour = &last;
}
