/* A host program: one tool position on a part of its own, through the installed library. */
#include <bitangent/bitangent.h>

#include <stdio.h>
#include <stdlib.h>

/* A bicubic Bezier patch over 150 mm x 150 mm; these are its control points' heights, mm. */
static const double heights[4][4] = {
    {80, 65, 90, 85}, {80, 85, 90, 95}, {100, 105, 95, 100}, {90, 100, 100, 85}};

int main(void) {
    btg_message message;

    /* The part: control points x, y, z, v fastest. */
    double points[16][3];
    for (int i = 0; i < 16; i++) {
        points[i][0] = 50.0 * (i / 4);
        points[i][1] = 50.0 * (i % 4);
        points[i][2] = heights[i / 4][i % 4];
    }
    btg_surface_def surface = {.degree_u = 3, .degree_v = 3, .count_u = 4, .count_v = 4};
    surface.control_points = &points[0][0];
    btg_part_def part_def = btg_part_def_default();
    part_def.surfaces = &surface;
    part_def.surface_count = 1;
    btg_part *part;
    if (btg_part_create(&part_def, &part, &message) < 0) {
        fprintf(stderr, "%s\n", message.text);
        return 1;
    }

    /* The tool: round inserts of 6 mm on a circle of 6.7 mm. */
    btg_tool_def tool_def = btg_tool_def_default();
    tool_def.major_radius_mm = 6.7;
    tool_def.minor_radius_mm = 6.0;
    btg_tool tool;
    if (btg_tool_init(&tool_def, &tool, &message) < 0) {
        fprintf(stderr, "%s\n", message.text);
        return 1;
    }

    /* Solving never allocates: the workspace is ours, one a thread. */
    btg_solver_def solver = btg_solver_def_default();
    size_t size = btg_workspace_size(part);
    void *workspace = malloc(size);
    btg_position at;
    btg_status status = btg_position_solve(part, &tool, &solver, 72, 74, workspace, size, &at);
    printf("%s\n", btg_status_name(status));
    if (status == BTG_OK) {
        printf("tip  %.4f %.4f %.4f\n", at.tip.x, at.tip.y, at.tip.z);
        printf("axis %.5f %.5f %.5f\n", at.axis.x, at.axis.y, at.axis.z);
        printf("tilt %.4f degrees\n", at.tilt_rad * 57.29577951308232);
    }
    free(workspace);
    btg_part_destroy(part);
    return status == BTG_OK ? 0 : 1;
}
