/* A controller's program, to copy: everything is made before the start; then a path is followed,
 * one position a step, without allocation. C11, and C++ as it stands.
 *
 *     cc embed.c $(pkg-config --cflags --libs bitangent) */
#include <bitangent/bitangent.h>

#include <stdio.h>
#include <stdlib.h>

/* A bicubic Bezier patch over 150 mm x 150 mm; these are its control points' heights, mm. */
static const double heights[4][4] = {
    {80, 65, 90, 85}, {80, 85, 90, 95}, {100, 105, 95, 100}, {90, 100, 100, 85}};

static btg_part *make_part(btg_message *message) {
    double points[16][3]; /* x, y, z, v fastest */
    for (int i = 0; i < 16; i++) {
        points[i][0] = 50.0 * (i / 4);
        points[i][1] = 50.0 * (i % 4);
        points[i][2] = heights[i / 4][i % 4];
    }
    btg_surface_def surface = {3, 3, 4, 4, &points[0][0], NULL, NULL, NULL};
    btg_part_def def = btg_part_def_default();
    def.surfaces = &surface;
    def.surface_count = 1;
    btg_part *part = NULL;
    return btg_part_create(&def, &part, message) < 0 ? NULL : part;
}

int main(void) {
    /* Set-up: may allocate, and says in one line what it does not like. */
    btg_message message;
    btg_tool_def tool_def = btg_tool_def_default();
    tool_def.major_radius_mm = 6.7; /* round inserts of 6 mm on a circle of 6.7 mm */
    tool_def.minor_radius_mm = 6.0;
    btg_tool tool;
    btg_part *part = make_part(&message);
    if (!part || btg_tool_init(&tool_def, &tool, &message) < 0) {
        fprintf(stderr, "%s\n", message.text);
        return 1;
    }
    btg_solver_def solver = btg_solver_def_default();
    solver.tolerance_mm = 0.001; /* no deeper in the part than this */
    solver.node_budget = 100000; /* what bounds the time of a position */
    size_t size = btg_workspace_size(part);
    void *workspace = malloc(size); /* one a thread */
    btg_position at, before;
    const btg_position *neighbour = NULL; /* none before the first */
    int bad = workspace == NULL;

    /* Run: no allocation, lock or system call in btg_position_follow from here on. */
    for (int y = 64; y <= 84 && !bad; y += 2) {
        btg_status status =
            btg_position_follow(part, &tool, &solver, 72, y, neighbour, workspace, size, &at);
        /* An error leaves `at` as it was; no contact has no pose; other poses are proven safe as
         * far as bound_mm says, one cut short by the budget too. */
        bad = status < 0 || status == BTG_NO_CONTACT || !(at.bound_mm <= solver.tolerance_mm);
        printf("%s over %g %g\n", btg_status_name(status), 72.0, (double)y);
        if (bad) break;
        printf("  tip %.4f %.4f %.4f axis %.5f %.5f %.5f tilt %.4f\n", at.tip.x, at.tip.y, at.tip.z,
               at.axis.x, at.axis.y, at.axis.z, at.tilt_rad * 57.29577951308232);
        before = at;
        neighbour = &before;
    }
    free(workspace);
    btg_part_destroy(part);
    return bad;
}
